//! Least squares by another method: columns made orthogonal one after another (Gram-Schmidt), on single samples.

use std::f64::consts::TAU;

/// Coefficients β that minimise |y − Σ β·column|.
pub fn least_squares(mut columns: Vec<Vec<f64>>, y: &[f64]) -> Vec<f64> {
    let unknowns = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut triangle = vec![vec![0.0; unknowns]; unknowns];
    let (mut rest, mut projected) = (y.to_vec(), vec![0.0; unknowns]);
    let remove = |from: &mut [f64], times: f64, what: &[f64]| {
        from.iter_mut()
            .zip(what)
            .for_each(|(from, what)| *from -= times * what);
    };
    for pivot in 0..unknowns {
        let (done, open) = columns.split_at_mut(pivot + 1);
        let column = &mut done[pivot];
        let length = dot(column, column).sqrt();
        column.iter_mut().for_each(|value| *value /= length);
        triangle[pivot][pivot] = length;
        for (index, later) in open.iter_mut().enumerate() {
            let share = dot(column, later);
            triangle[pivot][pivot + 1 + index] = share;
            remove(later, share, column);
        }
        projected[pivot] = dot(column, &rest);
        remove(&mut rest, projected[pivot], column);
    }
    let mut solution = vec![0.0; unknowns];
    for row in (0..unknowns).rev() {
        let known: f64 = (row + 1..unknowns)
            .map(|column| triangle[row][column] * solution[column])
            .sum();
        solution[row] = (projected[row] - known) / triangle[row][row];
    }
    solution
}

/// Value of each column at sample n of `length`: offset, drift over the window, and cosine and sine of five harmonics
/// at `cycles` turns per sample; sample 0 has phase zero.
fn columns(cycles: f64, length: usize) -> Vec<Box<dyn Fn(usize) -> f64>> {
    let drift = move |n: usize| (n as f64 + 0.5) / length as f64 - 0.5;
    let mut columns: Vec<Box<dyn Fn(usize) -> f64>> = vec![Box::new(|_| 1.0), Box::new(drift)];
    for k in 1..=5 {
        let angle = move |n: usize| TAU * (f64::from(k) * cycles * n as f64).fract();
        columns.push(Box::new(move |n| angle(n).cos()));
        columns.push(Box::new(move |n| angle(n).sin()));
    }
    columns
}

/// Offset, drift, and cosine and sine of five harmonics of a series.
pub fn harmonics(cycles: f64, y: &[f64]) -> Vec<f64> {
    let sampled = |column: Box<dyn Fn(usize) -> f64>| (0..y.len()).map(column).collect();
    least_squares(
        columns(cycles, y.len()).into_iter().map(sampled).collect(),
        y,
    )
}

/// The same from sums over blocks, with the columns summed in the same way.
pub fn harmonics_of_sums(cycles: f64, counts: &[u16], block: usize) -> Vec<f64> {
    let samples: Vec<f64> = counts.iter().map(|count| f64::from(*count)).collect();
    let summed = |values: &[f64]| {
        values
            .chunks_exact(block)
            .map(|block| block.iter().sum())
            .collect()
    };
    let column = |column: Box<dyn Fn(usize) -> f64>| {
        let sampled: Vec<f64> = (0..samples.len()).map(column).collect();
        summed(&sampled)
    };
    let columns = columns(cycles, samples.len())
        .into_iter()
        .map(column)
        .collect();
    least_squares(columns, &summed(&samples))
}
