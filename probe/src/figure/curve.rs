//! Long recordings made short enough to draw, without hiding what was in them.
//!
//! A series is cut into groups of samples. A group becomes its mean, for a line, or its least and greatest sample,
//! for a band: a spike of a single sample still shows. Groups are whole periods of the mains where they can be, whose
//! hum would otherwise beat with the groups and look like a slow movement.

/// A point: x and y.
pub type Point = (f64, f64);
/// A stretch of y at an x: x, least, greatest.
pub type Stretch = (f64, f64, f64);

/// Period of the mains, s.
const MAINS_PERIOD_S: f64 = 0.02;

/// Samples in a group: whole periods of the mains at `rate_hz`, so that at most `groups` groups come out of `samples`.
#[must_use]
pub fn group_of(samples: usize, groups: usize, rate_hz: f64) -> usize {
    let period = ((MAINS_PERIOD_S * rate_hz).round() as usize).max(1);
    samples
        .div_ceil(groups.max(1))
        .max(1)
        .next_multiple_of(period)
}

/// Mean of each group of `group` points.
#[must_use]
pub fn means(points: &[Point], group: usize) -> Vec<Point> {
    let mean = |points: &[Point]| {
        let count = points.len() as f64;
        let (x, y) = points
            .iter()
            .fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
        (x / count, y / count)
    };
    points.chunks(group.max(1)).map(mean).collect()
}

/// Least and greatest y of each group of `group` points, at the group's mean x.
#[must_use]
pub fn envelope(points: &[Point], group: usize) -> Vec<Stretch> {
    let stretch = |points: &[Point]| {
        let x = points.iter().map(|point| point.0).sum::<f64>() / points.len() as f64;
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = points.iter().fold(ends, |(low, high), point| {
            (low.min(point.1), high.max(point.1))
        });
        (x, low, high)
    };
    points.chunks(group.max(1)).map(stretch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_stays_in_the_envelope_and_the_mean_stays_the_mean() {
        let mut points: Vec<Point> = (0..1000).map(|n| (f64::from(n), 1.0)).collect();
        points[617].1 = 9.0;
        let group = group_of(points.len(), 30, 1000.0);
        let band = envelope(&points, group);
        assert!(band.len() <= 30);
        assert_eq!(band.iter().filter(|stretch| stretch.2 == 9.0).count(), 1);
        assert!(band.iter().all(|stretch| stretch.1 == 1.0));
        assert_eq!(means(&points, 2)[308], (616.5, 5.0));
        assert!(means(&[], 0).is_empty() && envelope(&[], 0).is_empty());
    }
}
