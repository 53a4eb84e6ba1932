//! The 6×6 linear system of a Newton step, solved by blocks.
//!
//! With the rows of three jacks above those of the other three, the step (u, w) in position and rotation vector
//! solves
//!
//! ```text
//! | D₁ M₁ | |u|   |g₁|        P = D₂·adj D₁         δ = det D₁
//! | D₂ M₂ | |w| = |g₂|        S = δ·M₂ − P·M₁       the Schur complement times δ
//!
//! w = adj S·(δ·g₂ − P·g₁)/det S       u = adj D₁·(g₁ − M₁·w)/δ       det = det S/δ²
//! ```
//!
//! Adjugates are cross products, so the whole takes two divisions, one beside the other, instead of the six in a row
//! of an elimination, and no branch. D₁ needs three jacks whose directions span space: [`Rows::best_order`] puts such
//! jacks first. If no three do, the whole matrix is singular.

use nalgebra::RealField;

use super::six::{Six, Triple, combine, cross, dot, each};

/// Rows d_k and c_k × d_k of six jacks: coordinate by jack, so that one instruction can serve several jacks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<T> {
    /// The jacks d_k, m.
    pub direction: Triple<Six<T>>,
    /// Their moments c_k × d_k about O, m².
    pub moment: Triple<Six<T>>,
}

/// The factors of one matrix of [`Rows`], ready to solve with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors<T> {
    d1_adjugate: [Triple<T>; 3],
    m1: [Triple<T>; 3],
    p: [Triple<T>; 3],
    s_adjugate: [Triple<T>; 3],
    leading_inverse: T,
    trailing_inverse: T,
    /// Determinant of the first three directions, m³.
    pub leading: T,
    /// Determinant of the whole, m⁹.
    pub determinant: T,
}

impl<T: RealField + Copy> Rows<T> {
    /// The order of the jacks in which the first three have the directions that span space best.
    pub fn best_order(&self) -> [usize; 6] {
        let mut best = ([0, 1, 2, 3, 4, 5], -T::one());
        for first in 0..6 {
            for second in first + 1..6 {
                for third in second + 1..6 {
                    let [a, b, c] =
                        [first, second, third].map(|k| self.direction.map(|row| row.0[k]));
                    let volume = dot(&a, &cross(&b, &c)).abs();
                    if volume > best.1 {
                        best = (leading(first, second, third), volume);
                    }
                }
            }
        }
        best.0
    }

    /// The rows in another order.
    pub fn ordered(&self, order: &[usize; 6]) -> Self {
        Self {
            direction: self.direction.map(|row| row.ordered(order)),
            moment: self.moment.map(|row| row.ordered(order)),
        }
    }

    /// Factors of the matrix. Where it is singular, or its first three directions lie in a plane, the factors are not
    /// finite and `leading` or `determinant` is zero.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn factor(&self) -> Factors<T> {
        let [d1, d2] = halves(&self.direction);
        let [m1, m2] = halves(&self.moment);
        let (d1_adjugate, leading) = adjugate(&d1);
        let leading_inverse = T::one() / leading;
        let p = multiply(&d2, &d1_adjugate);
        let pm = multiply(&p, &m1);
        let schur = combine(
            &m2,
            &pm,
            #[inline(always)]
            |m2, pm| {
                combine(
                    &m2,
                    &pm,
                    #[inline(always)]
                    |m2, pm| leading * m2 - pm,
                )
            },
        );
        let (s_adjugate, trailing) = adjugate(&schur);
        Factors {
            d1_adjugate,
            m1,
            p,
            s_adjugate,
            leading,
            leading_inverse,
            trailing_inverse: T::one() / trailing,
            determinant: trailing * leading_inverse * leading_inverse,
        }
    }
}

impl<T: RealField + Copy> Factors<T> {
    /// The step (u, w) for the right-hand side `g`, one number per jack.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn solve(&self, g: &Six<T>) -> (Triple<T>, Triple<T>) {
        let [g0, g1, g2, g3, g4, g5] = g.0;
        let (g1, g2) = ([g0, g1, g2], [g3, g4, g5]);
        let rest = combine(
            &g2,
            &apply(&self.p, &g1),
            #[inline(always)]
            |g, pg| self.leading * g - pg,
        );
        let w = each(
            &apply(&self.s_adjugate, &rest),
            #[inline(always)]
            |w| w * self.trailing_inverse,
        );
        let rest = combine(
            &g1,
            &apply(&self.m1, &w),
            #[inline(always)]
            |g, mw| g - mw,
        );
        let u = each(
            &apply(&self.d1_adjugate, &rest),
            #[inline(always)]
            |u| u * self.leading_inverse,
        );
        (u, w)
    }
}

/// The even permutation of the six jacks that puts the given three first, so that no determinant changes its sign.
fn leading(first: usize, second: usize, third: usize) -> [usize; 6] {
    let mut order = [first, second, third, 0, 0, 0];
    let others = (0..6).filter(|k| ![first, second, third].contains(k));
    for (place, other) in order[3..].iter_mut().zip(others) {
        *place = other;
    }
    // Bringing them there takes first + (second − 1) + (third − 2) exchanges of neighbours.
    if (first + second + third).is_multiple_of(2) {
        order.swap(4, 5);
    }
    order
}

/// The matrices of jacks 0..3 and 3..6, by rows.
#[inline(always)]
fn halves<T: RealField + Copy>(columns: &Triple<Six<T>>) -> [[Triple<T>; 3]; 2] {
    [
        [row(columns, 0), row(columns, 1), row(columns, 2)],
        [row(columns, 3), row(columns, 4), row(columns, 5)],
    ]
}

#[inline(always)]
fn row<T: RealField + Copy>(columns: &Triple<Six<T>>, jack: usize) -> Triple<T> {
    [columns[0].0[jack], columns[1].0[jack], columns[2].0[jack]]
}

/// The rows of a matrix made columns.
#[inline(always)]
fn transposed<T: Copy>([a, b, c]: &[Triple<T>; 3]) -> [Triple<T>; 3] {
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}

/// Adjugate, by rows, and determinant: the columns of the adjugate are the cross products of the rows.
#[inline(always)]
fn adjugate<T: RealField + Copy>([a, b, c]: &[Triple<T>; 3]) -> ([Triple<T>; 3], T) {
    let bc = cross(b, c);
    let columns = [bc, cross(c, a), cross(a, b)];
    (transposed(&columns), dot(a, &bc))
}

#[inline(always)]
fn multiply<T: RealField + Copy>(a: &[Triple<T>; 3], b: &[Triple<T>; 3]) -> [Triple<T>; 3] {
    let columns = transposed(b);
    [
        apply(&columns, &a[0]),
        apply(&columns, &a[1]),
        apply(&columns, &a[2]),
    ]
}

#[inline(always)]
fn apply<T: RealField + Copy>([first, second, third]: &[Triple<T>; 3], v: &Triple<T>) -> Triple<T> {
    [dot(first, v), dot(second, v), dot(third, v)]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix6, Vector6};

    use super::*;

    /// Any order of the jacks, led by any three of them, has the determinant and the solution of the whole matrix.
    #[test]
    fn blocks_agree_with_elimination_whichever_jacks_lead() {
        for seed in 1..100 {
            let entry = |k: usize, axis: usize| {
                (f64::from(seed) * 0.7 + k as f64 * 1.3 + axis as f64 * 2.9).sin() * 3.0
                    + (k * axis) as f64 % 2.0
            };
            let column = |axis: usize| {
                Six([0, 1, 2, 3, 4, 5].map(|k| entry(k, axis) + entry(k, axis + 7).powi(2)))
            };
            let rows = Rows {
                direction: [column(0), column(1), column(2)],
                moment: [column(3), column(4), column(5)],
            };
            let matrix = Matrix6::from_fn(|k, axis| column(axis).0[k]);
            let right = Six([1.0, -2.0, 3.0, 0.5, -1.5, 2.5]);
            let solution = matrix.lu().solve(&Vector6::from(right.0)).unwrap();

            let order = rows.best_order();
            let factors = rows.ordered(&order).factor();
            let (u, w) = factors.solve(&right.ordered(&order));
            let found = Vector6::new(u[0], u[1], u[2], w[0], w[1], w[2]);
            assert!((found - solution).amax() < 1e-9 * (1.0 + solution.amax()));
            assert!((factors.determinant / matrix.determinant() - 1.0).abs() < 1e-9);
        }
    }
}
