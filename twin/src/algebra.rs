//! Vectors, rotations and small linear systems, with which the mechanism and the sensors are computed.
//!
//! The code is written for the twin alone. The core under test uses another library and other conventions, so that an
//! error of sign on one side cannot hide behind the same error on the other.

use std::ops::{Add, Mul, Neg, Sub};

/// A vector of three components along X (forward), Y (up), Z (right).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vec3(pub [f64; 3]);

impl Vec3 {
    /// The vector (0, 0, 0).
    pub const ZERO: Self = Self([0.0; 3]);

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        let (a, b) = (self.0, other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// Vector product.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ])
    }

    /// Length.
    #[must_use]
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|component| component * factor))
    }
}

/// A rotation from body to earth, as a unit quaternion w + xi + yj + zk (Hamilton's convention).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    w: f64,
    v: Vec3,
}

impl Rotation {
    /// Body axes parallel to earth axes.
    pub const LEVEL: Self = Self {
        w: 1.0,
        v: Vec3::ZERO,
    };

    /// The right-handed rotation about the unit vector `axis` by `angle_rad`.
    #[must_use]
    pub fn about(axis: Vec3, angle_rad: f64) -> Self {
        let (sine, cosine) = libm::sincos(0.5 * angle_rad);
        Self {
            w: cosine,
            v: axis * sine,
        }
    }

    /// The rotation by the small vector `angle` (rad), exact to the second order: |angle|³/12 is left out.
    #[must_use]
    pub fn small(angle: Vec3) -> Self {
        Self {
            w: 1.0,
            v: angle * 0.5,
        }
        .normalised()
    }

    /// This rotation after `first`.
    #[must_use]
    pub fn after(self, first: Self) -> Self {
        Self {
            w: self.w * first.w - self.v.dot(first.v),
            v: first.v * self.w + self.v * first.w + self.v.cross(first.v),
        }
        .normalised()
    }

    /// Turns a vector from body to earth.
    #[must_use]
    pub fn to_earth(self, body: Vec3) -> Vec3 {
        let t = self.v.cross(body) * 2.0;
        body + t * self.w + self.v.cross(t)
    }

    /// Turns a vector from earth to body.
    #[must_use]
    pub fn to_body(self, earth: Vec3) -> Vec3 {
        Self {
            w: self.w,
            v: -self.v,
        }
        .to_earth(earth)
    }

    fn normalised(self) -> Self {
        let factor = 1.0 / (self.w * self.w + self.v.dot(self.v)).sqrt();
        Self {
            w: self.w * factor,
            v: self.v * factor,
        }
    }
}

/// The factors of a square matrix: P·A = L·U, by Gaussian elimination with partial pivoting.
#[derive(Debug, Clone)]
pub struct Factors<const N: usize> {
    lu: [[f64; N]; N],
    order: [usize; N],
}

impl<const N: usize> Factors<N> {
    /// Factors a matrix given by rows; `None` when a pivot is below 1e-12 of the largest element (singular).
    #[must_use]
    pub fn new(mut lu: [[f64; N]; N]) -> Option<Self> {
        let largest = lu
            .iter()
            .flatten()
            .fold(0.0, |max: f64, x| max.max(x.abs()));
        let mut order: [usize; N] = std::array::from_fn(|i| i);
        for column in 0..N {
            let pivot =
                (column..N).max_by(|&a, &b| lu[a][column].abs().total_cmp(&lu[b][column].abs()))?;
            let size = lu[pivot][column].abs();
            if size.is_nan() || size <= 1e-12 * largest {
                return None;
            }
            lu.swap(column, pivot);
            order.swap(column, pivot);
            let top = lu[column];
            for row in &mut lu[column + 1..] {
                let factor = row[column] / top[column];
                row[column] = factor;
                for k in column + 1..N {
                    row[k] -= factor * top[k];
                }
            }
        }
        Some(Self { lu, order })
    }

    /// Solves A·x = b.
    #[must_use]
    pub fn solve(&self, b: [f64; N]) -> [f64; N] {
        let mut x = [0.0; N];
        for row in 0..N {
            let known: f64 = (0..row).map(|k| self.lu[row][k] * x[k]).sum();
            x[row] = b[self.order[row]] - known;
        }
        for row in (0..N).rev() {
            let known: f64 = (row + 1..N).map(|k| self.lu[row][k] * x[k]).sum();
            x[row] = (x[row] - known) / self.lu[row][row];
        }
        x
    }

    /// The inverse of A, by rows.
    #[must_use]
    pub fn inverse(&self) -> [[f64; N]; N] {
        let columns: [[f64; N]; N] = std::array::from_fn(|column| {
            self.solve(std::array::from_fn(|row| f64::from(row == column)))
        });
        std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
    }
}
