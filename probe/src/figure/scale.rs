//! The scale of one axis: from where to where, and where the ticks stand.
//!
//! Ticks are 1, 2 or 5 times a power of ten apart, as on a ruler; on a symmetric scale 3 as well.

use super::number::{fixed, power_of_ten};

/// Scale of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    from: f64,
    to: f64,
    step: f64,
    /// Values are logarithms: ticks are labelled with powers of ten.
    decades: bool,
}

impl Scale {
    /// From `from` to `to` as they are, with at least `ticks` ticks; 0 to 1 when they make no scale.
    #[must_use]
    pub fn between(from: f64, to: f64, ticks: usize) -> Self {
        let usable = from.is_finite() && to.is_finite() && to > from;
        let (from, to) = if usable { (from, to) } else { (0.0, 1.0) };
        let mut steps = ruler_down_from(to - from);
        let enough = |step: &f64| (to / step).floor() - (from / step).ceil() + 1.0 >= ticks as f64;
        // Each step is at most half the one before, so that enough of them fit soon.
        let step = steps.find(enough).unwrap_or(to - from);
        Self {
            from,
            to,
            step,
            decades: false,
        }
    }

    /// Around all `values`, with a margin and at least three ticks.
    #[must_use]
    pub fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let values = values.into_iter().filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if low > high {
            return Self::between(0.0, 1.0, 3);
        }
        // A constant gets a scale of its own size; a scale of no size would divide by zero.
        let margin = match (high - low) * 0.06 {
            margin if margin > 1e-9 * high.abs() => margin,
            _ => (high.abs() * 0.1).max(1e-9),
        };
        Self::between(low - margin, high + margin, 3)
    }

    /// Around zero and all `values`, as far up as down, with a tick at zero and one on each side of it.
    #[must_use]
    pub fn symmetric(values: impl IntoIterator<Item = f64>) -> Self {
        let sizes = values.into_iter().map(f64::abs);
        let largest = sizes
            .filter(|size| size.is_finite())
            .fold(0.0, f64::max)
            .max(1e-9);
        let end = 1.08 * largest;
        let power = 10f64.powf(end.log10().floor());
        let fits = |factor: &f64| factor * power <= end;
        let step = [5.0, 3.0, 2.0].into_iter().find(fits).unwrap_or(1.0) * power;
        Self {
            from: -end,
            to: end,
            step,
            decades: false,
        }
    }

    /// Whole decades around all positive `values`; places are those of their logarithms.
    #[must_use]
    pub fn decades(values: impl IntoIterator<Item = f64>) -> Self {
        let logarithms = values.into_iter().map(f64::log10);
        let (low, high) = logarithms
            .filter(|value| value.is_finite())
            .fold((f64::MAX, f64::MIN), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let whole = if low <= high {
            Self::between(low.floor(), high.ceil().max(low.floor() + 1.0), 3)
        } else {
            Self::between(0.0, 1.0, 1)
        };
        Self {
            step: whole.step.max(1.0),
            decades: true,
            ..whole
        }
    }

    /// Where `value` stands, 0 at the start and 1 at the end; what is no number stands at the start.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        let value = if self.decades { value.log10() } else { value };
        let place = (value - self.from) / (self.to - self.from);
        if place.is_nan() {
            0.0
        } else {
            place.clamp(0.0, 1.0)
        }
    }

    /// Places of the ticks, 0 to 1, with their labels.
    pub fn ticks(&self) -> impl Iterator<Item = (f64, String)> + '_ {
        let decimals = (-(self.step.log10() + 1e-9).floor()).max(0.0) as usize;
        let first = (self.from / self.step - 1e-6).ceil() as i64;
        let last = (self.to / self.step + 1e-6).floor() as i64;
        (first..=last).map(move |tick| {
            let value = tick as f64 * self.step;
            let label = if self.decades {
                power_of_ten(value as i32)
            } else {
                fixed(value, decimals)
            };
            ((value - self.from) / (self.to - self.from), label)
        })
    }
}

/// 1, 2 and 5 times powers of ten, from the greatest that is not over `length` downwards.
fn ruler_down_from(length: f64) -> impl Iterator<Item = f64> {
    let power = length.log10().floor() as i32;
    let powers = (0..4).map(move |down| 10f64.powi(power - down));
    let steps = powers.flat_map(|power| [5.0 * power, 2.0 * power, power]);
    steps.skip_while(move |step| *step > length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<String> {
        scale.ticks().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_as_on_a_ruler_and_enough() {
        assert_eq!(
            labels(&Scale::between(0.0, 34.0, 3)),
            ["0", "10", "20", "30"]
        );
        assert_eq!(
            labels(&Scale::between(-0.31, 0.27, 3)),
            ["−0.2", "0.0", "0.2"]
        );
        assert_eq!(
            labels(&Scale::decades([0.3, 4_000.0])),
            ["10⁰", "10²", "10⁴"]
        );
        for end in 1..300 {
            let scale = Scale::around([0.0, f64::from(end) * 0.37]);
            assert!((3..=9).contains(&scale.ticks().count()), "{scale:?}");
        }
    }

    #[test]
    fn six_percent_are_left_on_either_side_and_a_constant_gets_a_tenth_of_its_size() {
        let ends = |values: &[f64]| {
            let scale = Scale::around(values.iter().copied());
            [scale.from, scale.to].map(|end| (end * 1e6).round() / 1e6)
        };
        assert_eq!(ends(&[10.0, -40.0, 3.0]), [-43.0, 13.0]);
        assert_eq!(ends(&[50.0, 50.0]), [45.0, 55.0]);
        assert_eq!(ends(&[f64::NAN, 2.0, 4.0]), [1.88, 4.12]);
    }

    #[test]
    fn a_symmetric_scale_has_three_ticks() {
        for size in 1..300 {
            let scale = Scale::symmetric([f64::from(size) * 0.037]);
            assert_eq!(scale.ticks().count(), 3, "{scale:?}");
        }
    }

    #[test]
    fn values_that_make_no_scale_still_give_one() {
        for scale in [
            Scale::around([]),
            Scale::around([f64::NAN, f64::INFINITY]),
            Scale::around([7.0, 7.0]),
            Scale::around([0.0]),
            Scale::symmetric([0.0]),
            Scale::symmetric([f64::NAN]),
            Scale::decades([0.0, -1.0]),
            Scale::between(2.0, 1.0, 0),
        ] {
            let ticks = scale.ticks().count();
            assert!((1..20).contains(&ticks), "{ticks} on {scale:?}");
            assert!((0.0..=1.0).contains(&scale.place(7.0)), "{scale:?}");
        }
    }
}
