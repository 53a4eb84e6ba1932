//! The linear fit: known lines, weights, covariance, and too few rows.

use approx::assert_relative_eq;
use hexsense_core::least_squares::NormalEquations;
use nalgebra::{Matrix2, Vector2, Vector3};

/// y = 2 + 3x through four points that are off by ±1.
fn line(weights: [f64; 4]) -> NormalEquations<2> {
    let mut equations = NormalEquations::default();
    for (index, weight) in weights.into_iter().enumerate() {
        let x = index as f64;
        let off = [1.0, -1.0, -1.0, 1.0][index];
        equations.add(&Vector2::new(1.0, x), 2.0 + 3.0 * x + off, weight);
    }
    equations
}

#[test]
fn a_line_is_fitted_with_its_covariance_and_residuals() {
    // ±1 in this order leaves mean and slope alone. (XᵀX)⁻¹ of 1, x with x = 0 … 3 by hand.
    let solution = line([1.0; 4]).solve().unwrap();
    assert_relative_eq!(solution.unknowns, Vector2::new(2.0, 3.0), epsilon = 1e-12);
    assert_relative_eq!(
        solution.cofactors,
        Matrix2::new(0.7, -0.3, -0.3, 0.2),
        epsilon = 1e-12
    );
    assert_relative_eq!(solution.residual_square, 4.0, epsilon = 1e-10);
    assert_eq!(solution.degrees_of_freedom, 2);
}

#[test]
fn a_weight_counts_as_that_many_rows() {
    let mut repeated = line([1.0; 4]);
    repeated.add(&Vector2::new(1.0, 1.0), 4.0, 1.0);
    repeated.add(&Vector2::new(1.0, 1.0), 4.0, 1.0);
    let (repeated, weighted) = (
        repeated.solve().unwrap(),
        line([1.0, 3.0, 1.0, 1.0]).solve().unwrap(),
    );
    assert_relative_eq!(repeated.unknowns, weighted.unknowns, epsilon = 1e-12);
    assert_relative_eq!(repeated.cofactors, weighted.cofactors, epsilon = 1e-12);
    assert_relative_eq!(
        repeated.residual_square,
        weighted.residual_square,
        epsilon = 1e-10
    );
}

#[test]
fn rows_that_do_not_determine_every_unknown_are_refused() {
    assert_eq!(NormalEquations::<3>::default().solve(), None);
    // The third column is the sum of the others, except for rounding, whose direction varies.
    for case in 1..=100 {
        let mut equations = NormalEquations::<3>::default();
        for index in 0..50 {
            let angle = f64::from(index * case);
            let (a, b) = ((angle * 0.1).sin() / 3.0, (angle * 0.37).cos() / 7.0);
            equations.add(&Vector3::new(a, b, a + b), 1.0, 1.0);
        }
        assert_eq!(equations.solve(), None, "case {case}");
        // One row that separates them by a ten-thousandth is enough.
        equations.add(&Vector3::new(1.0, 1.0, 2.0001), 1.0, 1.0);
        assert!(equations.solve().is_some(), "case {case}");
    }
}

#[test]
fn what_is_not_a_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut equations = line([1.0; 4]);
        equations.add(&Vector2::new(1.0, 5.0), bad, 1.0);
        assert_eq!(equations.solve(), None);
        let mut equations = line([1.0; 4]);
        equations.add(&Vector2::new(bad, 5.0), 1.0, 1.0);
        assert_eq!(equations.solve(), None);
        assert_eq!(line([1.0, bad, 1.0, 1.0]).solve(), None);
    }
}

#[test]
fn columns_of_any_size_are_determined_alike() {
    for scale in [1e-9, 1.0, 1e9] {
        let mut equations = NormalEquations::<2>::default();
        for x in 0..4 {
            let x = f64::from(x);
            equations.add(&Vector2::new(1.0, scale * x), 2.0 + 3.0 * x, 1.0);
        }
        let slope = equations.solve().unwrap().unknowns[1];
        assert_relative_eq!(slope * scale, 3.0, max_relative = 1e-12);
    }
}
