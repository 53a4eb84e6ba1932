//! The equations of forward kinematics, counted from home.
//!
//! An excursion from home is a shift s = p − p° of O and a unit quaternion q = (q₀, v). With d°_k and l°_k the jacks at
//! home, l_k the lengths that are wanted and c_k = A·b_k,
//!
//! ```text
//! δ_k = s + (A − 1)·b_k           (A − 1)·b = 2·q₀·(v × b) + 2·v × (v × b)
//! d_k = d°_k + δ_k
//! F_k = ½·(l_k² − |d_k|²) = (l_k − l°_k)·½(l_k + l°_k) − δ_k·(d°_k + ½·δ_k)
//! ```
//!
//! F has the zeros of l − |d| and needs no root; and since it is put together from differences against home, single
//! precision loses nothing to the subtraction of two squares.
//!
//! A small movement (u, w), shift in m and rotation vector in rad, both in the earth frame, changes F_k by
//! −(d_k·u + (c_k × d_k)·w), which is row k of the Jacobian times l_k, and is made by
//!
//! ```text
//! s ← s + u,   q ← (1, w/2)·q
//! ```
//!
//! This turns by 2·atan(|w|/2), to third order the angle |w|, without sine and cosine.

use nalgebra::{Quaternion, RealField, UnitQuaternion, Vector3, convert, convert_unchecked};
use simba::scalar::SupersetOf;

use super::{
    exact,
    geometry::Geometry,
    linear::{Factors, Rows},
    pose::Pose,
    six::{Six, Triple, combine, cross, dot, each},
};

/// Where the body is, counted from home.
#[derive(Clone, Copy, Debug)]
pub(super) struct Excursion<T> {
    shift: Triple<T>,
    /// Scalar part, then vector part; not normalised.
    quaternion: [T; 4],
    /// Two over the squared norm of the quaternion.
    scale: T,
}

/// The base as seen from home: its jacks in the order that suits [`Factors`], coordinate by jack.
#[derive(Clone, Debug)]
pub(super) struct Home<T: RealField + Copy> {
    pose: Pose<T>,
    order: [usize; 6],
    pub upper: [Six<T>; 3],
    pub jacks: [Six<T>; 3],
    lengths: Six<T>,
    /// ½·(l° as rounded squared − l°²), m².
    offsets: Six<T>,
    /// Factors of the matrix with rows d_k, c_k × d_k at home.
    pub factors: Factors<T>,
    /// Mean square of |b_k|, m²: a turn of w moves the upper hinges by about this much times |w|².
    pub radius_squared: T,
}

/// The jacks d_k and the upper hinges about O, c_k, at some excursion.
pub(super) struct Placed<T> {
    jacks: [Six<T>; 3],
    hinges: [Six<T>; 3],
}

impl<T: RealField + Copy> Home<T> {
    /// Everything is computed in the precision of `geometry` and rounded once. What single precision would lose is
    /// carried along: a sum of coordinates with its error, a difference of squares as in [`super::exact`].
    pub fn new<S: RealField + Copy>(geometry: &Geometry<S>) -> Self
    where
        T: SupersetOf<S>,
    {
        // Home itself as it is rounded, so that excursions from it add up to exact positions.
        let position: Vector3<T> = geometry.home().position.map(convert);
        let unrounded: [S; 3] = position.map(convert_unchecked).into();
        let by_coordinate = |at: &dyn Fn(usize, usize) -> S| {
            each(&[0, 1, 2], |axis| {
                Six([0, 1, 2, 3, 4, 5].map(|jack| at(jack, axis)))
            })
        };
        let upper = by_coordinate(&|jack, axis| geometry.upper()[jack][axis]);
        let jack = |jack: usize, axis: usize| {
            let (high, error) = exact::sum(unrounded[axis], geometry.upper()[jack][axis]);
            let (high, second) = exact::sum(high, -geometry.lower()[jack][axis]);
            (high, error + second)
        };
        let jacks = by_coordinate(&|k, axis| jack(k, axis).0);
        let errors = by_coordinate(&|k, axis| jack(k, axis).1);
        // The cross product in a loop, which leaves the code small: a home is made seldom.
        let moment =
            [(1, 2), (2, 0), (0, 1)].map(|(a, b)| upper[a] * jacks[b] - upper[b] * jacks[a]);
        let order = Rows {
            direction: jacks,
            moment,
        }
        .best_order();
        let lengths: [T; 6] = order.map(|k| {
            let [x, y, z] = each(&jacks, |row| row.0[k]);
            convert((x * x + y * y + z * z).sqrt())
        });
        let offset = |place: usize| {
            let k = order[place];
            let d = each(&jacks, |row| row.0[k]);
            let e = each(&errors, |row| row.0[k]);
            let excess = exact::square_less_squares(convert_unchecked(lengths[place]), &d);
            convert(excess * convert::<f64, S>(0.5) - dot(&d, &e))
        };
        let in_order = |v: Triple<Six<S>>| each(&v, |v| v.ordered(&order).rounded());
        let (upper, jacks, moment) = (in_order(upper), in_order(jacks), in_order(moment));
        Self {
            pose: Pose {
                position,
                rotation: UnitQuaternion::identity(),
            },
            order,
            upper,
            jacks,
            lengths: Six(lengths),
            offsets: Six([0, 1, 2, 3, 4, 5].map(offset)),
            factors: Rows {
                direction: jacks,
                moment,
            }
            .factor(),
            radius_squared: dot(&upper, &upper).sum() / convert(6.0),
        }
    }

    /// The part of F that the lengths determine, ½·(l_k² − l°_k²), in home's order of jacks, m².
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn demand(&self, lengths: &[T; 6]) -> Six<T> {
        let excess = Six(*lengths).ordered(&self.order) - self.lengths;
        excess * (self.lengths + excess * convert::<f64, T>(0.5)) + self.offsets
    }

    /// The excursion that leads to `pose`.
    #[inline(always)]
    pub fn excursion(&self, pose: &Pose<T>) -> Excursion<T> {
        let q = pose.rotation.quaternion();
        Excursion {
            shift: (pose.position - self.pose.position).into(),
            quaternion: [q.w, q.i, q.j, q.k],
            scale: convert(2.0),
        }
    }

    /// The pose that `excursion` leads to.
    #[inline(always)]
    pub fn pose(&self, excursion: &Excursion<T>) -> Pose<T> {
        let [w, x, y, z] = excursion.quaternion;
        let scale = T::one() / (w * w + x * x + y * y + z * z).sqrt();
        let rotation = Quaternion::new(w * scale, x * scale, y * scale, z * scale);
        Pose {
            position: self.pose.position + Vector3::from(excursion.shift),
            rotation: UnitQuaternion::new_unchecked(rotation),
        }
    }

    /// No excursion.
    pub fn none() -> Excursion<T> {
        let (zero, one) = (T::zero(), T::one());
        Excursion {
            shift: [zero; 3],
            quaternion: [one, zero, zero, zero],
            scale: convert(2.0),
        }
    }

    /// The jacks at `excursion` and F there for `demand`, m².
    #[cfg(not(target_os = "none"))]
    #[inline(always)]
    pub fn place(&self, excursion: &Excursion<T>, demand: &Six<T>) -> (Placed<T>, Six<T>) {
        let [x, y, z] = self.upper;
        let t = each(
            &excursion.turn(),
            #[inline(always)]
            |row| x * row[0] + y * row[1] + z * row[2],
        );
        let delta = combine(
            &t,
            &excursion.shift,
            #[inline(always)]
            |t, s| t + Six::splat(s),
        );
        let half: T = convert(0.5);
        let middle = combine(
            &self.jacks,
            &delta,
            #[inline(always)]
            |d, delta| d + delta * half,
        );
        let residuals = *demand - dot(&delta, &middle);
        let placed = Placed {
            jacks: combine(
                &self.jacks,
                &delta,
                #[inline(always)]
                |d, delta| d + delta,
            ),
            hinges: combine(
                &self.upper,
                &t,
                #[inline(always)]
                |b, t| b + t,
            ),
        };
        (placed, residuals)
    }

    /// The same, jack by jack: a processor that computes one number at a time has no registers for six jacks at once.
    #[cfg(target_os = "none")]
    #[inline(never)]
    pub fn place(&self, excursion: &Excursion<T>, demand: &Six<T>) -> (Placed<T>, Six<T>) {
        let half: T = convert(0.5);
        let turn = excursion.turn();
        let mut residuals = *demand;
        let mut placed = Placed {
            jacks: self.jacks,
            hinges: self.upper,
        };
        for jack in 0..6 {
            let [x, y, z] = jack_of(&self.upper, jack);
            let d = jack_of(&self.jacks, jack);
            let t = each(
                &turn,
                #[inline(always)]
                |row| x * row[0] + y * row[1] + z * row[2],
            );
            let delta = [
                t[0] + excursion.shift[0],
                t[1] + excursion.shift[1],
                t[2] + excursion.shift[2],
            ];
            let middle = combine(
                &d,
                &delta,
                #[inline(always)]
                |d, delta| d + delta * half,
            );
            residuals.0[jack] = demand.0[jack] - dot(&delta, &middle);
            placed.jacks[0].0[jack] = d[0] + delta[0];
            placed.jacks[1].0[jack] = d[1] + delta[1];
            placed.jacks[2].0[jack] = d[2] + delta[2];
            placed.hinges[0].0[jack] = x + t[0];
            placed.hinges[1].0[jack] = y + t[1];
            placed.hinges[2].0[jack] = z + t[2];
        }
        (placed, residuals)
    }
}

#[cfg(target_os = "none")]
#[inline(always)]
fn jack_of<T: Copy>(coordinates: &[Six<T>; 3], jack: usize) -> Triple<T> {
    [
        coordinates[0].0[jack],
        coordinates[1].0[jack],
        coordinates[2].0[jack],
    ]
}

impl<T: RealField + Copy> Excursion<T> {
    /// After a step: shift `u`, m, and rotation vector `w`, rad.
    #[inline(always)]
    pub fn moved(&self, u: &Triple<T>, w: &Triple<T>) -> Self {
        let half: T = convert(0.5);
        let [a, b, c] = each(
            w,
            #[inline(always)]
            |w| w * half,
        );
        let [q, x, y, z] = self.quaternion;
        Self {
            shift: combine(
                &self.shift,
                u,
                #[inline(always)]
                |s, u| s + u,
            ),
            quaternion: [
                q - (a * x + b * y + c * z),
                x + a * q + (b * z - c * y),
                y + b * q + (c * x - a * z),
                z + c * q + (a * y - b * x),
            ],
            scale: self.scale / (T::one() + (a * a + b * b + c * c)),
        }
    }

    /// A − 1, by rows.
    #[inline(always)]
    fn turn(&self) -> [Triple<T>; 3] {
        let [w, x, y, z] = self.quaternion;
        let [sx, sy, sz] = each(
            &[x, y, z],
            #[inline(always)]
            |v| v * self.scale,
        );
        let (xx, yy, zz) = (sx * x, sy * y, sz * z);
        let (xy, xz, yz) = (sx * y, sx * z, sy * z);
        let (wx, wy, wz) = (sx * w, sy * w, sz * w);
        [
            [-(yy + zz), xy - wz, xz + wy],
            [xy + wz, -(xx + zz), yz - wx],
            [xz - wy, yz + wx, -(xx + yy)],
        ]
    }
}

impl<T: RealField + Copy> Placed<T> {
    #[inline(always)]
    pub fn rows(&self) -> Rows<T> {
        Rows {
            direction: self.jacks,
            moment: cross(&self.hinges, &self.jacks),
        }
    }
}
