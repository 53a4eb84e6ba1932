//! One number for each of the six jacks, with arithmetic on all six at once, and products of vectors of such numbers.
//!
//! Six jacks go through the same arithmetic. Written for all six at once, coordinate by coordinate, it compiles to
//! whatever vector instructions the target has; there is nothing to shuffle and no loop left.

use core::ops::{Add, Mul, Sub};

use nalgebra::RealField;
use simba::scalar::SupersetOf;

/// One number per jack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Six<T>(pub [T; 6]);

impl<T: RealField + Copy> Six<T> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let ([a0, a1, a2, a3, a4, a5], [b0, b1, b2, b3, b4, b5]) = (self.0, other.0);
        Self([
            f(a0, b0),
            f(a1, b1),
            f(a2, b2),
            f(a3, b3),
            f(a4, b4),
            f(a5, b5),
        ])
    }

    /// The same number for every jack.
    #[inline(always)]
    pub fn splat(number: T) -> Self {
        Self([number; 6])
    }

    /// Numbers in another order of jacks.
    #[inline(always)]
    pub fn ordered(self, order: &[usize; 6]) -> Self {
        let [a, b, c, d, e, f] = *order;
        let from = self.0;
        Self([from[a], from[b], from[c], from[d], from[e], from[f]])
    }

    /// Sum over the jacks.
    #[inline(always)]
    pub fn sum(self) -> T {
        let [a, b, c, d, e, f] = self.0;
        ((a + b) + (c + d)) + (e + f)
    }

    /// The greatest magnitude.
    #[inline(always)]
    pub fn largest(self) -> T {
        let [a, b, c, d, e, f] = self.0;
        let pairs = [
            larger(a.abs(), b.abs()),
            larger(c.abs(), d.abs()),
            larger(e.abs(), f.abs()),
        ];
        larger(larger(pairs[0], pairs[1]), pairs[2])
    }
}

impl<S: RealField + Copy> Six<S> {
    /// The same numbers in the precision of the solver.
    pub fn rounded<T: SupersetOf<S>>(self) -> Six<T> {
        Six(self.0.map(nalgebra::convert))
    }
}

impl<T: RealField + Copy> Add for Six<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a + b,
        )
    }
}

impl<T: RealField + Copy> Sub for Six<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a - b,
        )
    }
}

impl<T: RealField + Copy> Mul for Six<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a * b,
        )
    }
}

impl<T: RealField + Copy> Mul<T> for Six<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, number: T) -> Self {
        self * Self::splat(number)
    }
}

#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Three coordinates, of one vector or of one vector per jack.
pub(super) type Triple<E> = [E; 3];

#[inline(always)]
pub(super) fn dot<E: Copy + Add<Output = E> + Mul<Output = E>>(a: &Triple<E>, b: &Triple<E>) -> E {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross<E: Copy + Sub<Output = E> + Mul<Output = E>>(
    a: &Triple<E>,
    b: &Triple<E>,
) -> Triple<E> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Every coordinate on its own: `array::map`, but sure to leave no loop and no call behind.
#[inline(always)]
pub(super) fn each<A: Copy, B>(a: &Triple<A>, f: impl Fn(A) -> B) -> Triple<B> {
    [f(a[0]), f(a[1]), f(a[2])]
}

/// The coordinates of two vectors put together one by one.
#[inline(always)]
pub(super) fn combine<A: Copy, B: Copy, C>(
    a: &Triple<A>,
    b: &Triple<B>,
    f: impl Fn(A, B) -> C,
) -> Triple<C> {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}
