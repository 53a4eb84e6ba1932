//! The Jacobian against automatic differentiation.

use hexsense_core::kinematics::{Angles, Convention, Geometry, Pose, jacobian};
use nalgebra::{Matrix3, Matrix6, Vector3};
use num_dual::{Dual64, DualNum};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{ball, dietmaier, presets};

/// Length of jack `k` at (x, y, z, roll, yaw, pitch) in `gost`, written out for a number that differentiates itself.
fn dual_length(geometry: &Geometry<f64>, k: usize, q: [Dual64; 6]) -> Dual64 {
    let (sg, cg) = q[3].sin_cos();
    let (sp, cp) = q[4].sin_cos();
    let (st, ct) = q[5].sin_cos();
    let rotation = [
        [cp * ct, sp * sg - cp * st * cg, sp * cg + cp * st * sg],
        [st, ct * cg, -ct * sg],
        [-sp * ct, cp * sg + sp * st * cg, cp * cg - sp * st * sg],
    ];
    let (a, b) = (geometry.lower()[k], geometry.upper()[k]);
    let mut square = Dual64::from(0.0);
    for i in 0..3 {
        let d = q[i] + rotation[i][0] * b.x + rotation[i][1] * b.y + rotation[i][2] * b.z - a[i];
        square += d * d;
    }
    square.sqrt()
}

/// Derivatives of the six lengths with respect to the six coordinates.
fn automatic_jacobian(geometry: &Geometry<f64>, q: [f64; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|k, column| {
        let seeded = |i: usize| Dual64::new(q[i], if i == column { 1.0 } else { 0.0 });
        dual_length(geometry, k, core::array::from_fn(seeded)).eps
    })
}

fn random_coordinates(geometry: &Geometry<f64>, random: &mut ChaCha8Rng) -> [f64; 6] {
    let shift = ball(random) * 0.5;
    let angle = ball(random);
    [
        shift.x,
        geometry.home_height_m() + shift.y,
        shift.z,
        angle.x,
        angle.y,
        angle.z,
    ]
}

fn pose(q: [f64; 6]) -> Pose<f64> {
    Convention::Gost.pose(
        Vector3::new(q[0], q[1], q[2]),
        Angles {
            roll: q[3],
            yaw: q[4],
            pitch: q[5],
        },
    )
}

/// Body axes' share in the angular velocity when one of roll, yaw and pitch turns at 1 rad/s, one angle a column:
/// ω = (γ̇ + ψ̇·sin ϑ, ψ̇·cos ϑ·cos γ + ϑ̇·sin γ, −ψ̇·cos ϑ·sin γ + ϑ̇·cos γ) by GOST 20058-80.
fn body_rates(roll: f64, pitch: f64) -> Matrix3<f64> {
    let ((sg, cg), (st, ct)) = (roll.sin_cos(), pitch.sin_cos());
    Matrix3::new(1.0, st, 0.0, 0.0, ct * cg, sg, 0.0, -ct * sg, cg)
}

/// The automatic derivatives are by angles; J wants the rotation vector in the earth frame.
#[test]
fn the_jacobian_agrees_with_automatic_differentiation() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for (name, geometry) in presets().into_iter().chain([("dietmaier40", dietmaier())]) {
        for _ in 0..200 {
            let q = random_coordinates(&geometry, &mut random);
            let pose = pose(q);
            let mut chain = Matrix6::identity();
            let turns = pose.rotation.to_rotation_matrix() * body_rates(q[3], q[5]);
            chain.fixed_view_mut::<3, 3>(3, 3).copy_from(&turns);
            let difference = jacobian(&geometry, &pose) * chain - automatic_jacobian(&geometry, q);
            assert!(difference.amax() < 1e-12, "{name}: {difference}");
        }
    }
}
