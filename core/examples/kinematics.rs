//! Kinematics of a motion base: hinges → jack lengths of a pose → the pose again → how well the jacks hold it.
//!
//! ```text
//! cargo run -p hexsense-core --example kinematics
//! ```

mod base;

use base::base;
use hexsense_core::kinematics::convention::{Angles, Convention};
use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::{Geometry, Pose, displacements, inverse};
use nalgebra::Vector3;

/// Forward, up and to the right of home, and turned about all three axes.
fn target(base: &Geometry<f64>) -> Pose<f64> {
    let angles = Angles {
        roll: 5_f64.to_radians(),
        pitch: (-10_f64).to_radians(),
        yaw: 15_f64.to_radians(),
    };
    let position = base.home().position + Vector3::new(0.10, 0.05, -0.08);
    Convention::Gost.pose(position, angles)
}

fn main() {
    let base = base();
    println!("home height          {:.6} m", base.home_height_m());

    // Inverse kinematics, equation (1): one length for each jack, and its displacement from mid-stroke.
    let pose = target(&base);
    let lengths_m = inverse(&base, &pose);
    for (jack, (length, displacement)) in
        (1..).zip(lengths_m.iter().zip(displacements(&base, &pose)))
    {
        println!(
            "jack {jack}               {length:.6} m, {:+8.3} mm from mid-stroke",
            displacement * 1e3
        );
    }

    // Forward kinematics, equation (3), from home: Newton's method on the same six equations.
    let solver = Solver::new(&base, Options::<f64>::default());
    let solution = solver
        .solve(&lengths_m)
        .expect("home's branch has a pose with these lengths");
    let (position, angles) = Convention::Gost.coordinates(&solution.pose);
    println!(
        "position             X {:.6}, Y {:.6}, Z {:.6} m",
        position.x, position.y, position.z
    );
    println!(
        "angles               roll {:.6}, pitch {:.6}, yaw {:.6} °",
        angles.roll.to_degrees(),
        angles.pitch.to_degrees(),
        angles.yaw.to_degrees()
    );
    let (distance_m, angle_rad) = solution.pose.distance(&pose);
    println!(
        "off the start by     {distance_m:.1e} m, {angle_rad:.1e} rad after {} iterations",
        solution.iterations
    );

    // The condition number of the Jacobian, 1 at best, with metres and radians as units: by how much an error of the
    // lengths may grow in the pose. It is infinite where the jacks do not hold the platform.
    println!(
        "condition number     {:.3} at home, {:.3} here",
        solver.condition(&base.home()),
        solver.condition(&pose)
    );

    // Lengths that no jack has are refused, with the jack and the stroke.
    let mut broken = lengths_m;
    broken[2] = 3.5;
    println!(
        "jack 3 at 3.5 m      {}",
        solver.solve(&broken).expect_err("beyond the stroke")
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_same_pose() {
        let base = base();
        // As the preset's file has it.
        assert!((base.home_height_m() - 2.129_757).abs() < 5e-7);
        let pose = target(&base);
        let solver = Solver::new(&base, Options::<f64>::default());
        let solution = solver.solve(&inverse(&base, &pose)).unwrap();
        let (distance_m, angle_rad) = solution.pose.distance(&pose);
        assert!(
            distance_m < 1e-12 && angle_rad < 1e-12,
            "{distance_m:e} m, {angle_rad:e} rad"
        );
        let condition = solver.condition(&pose);
        assert!((2.0..4.0).contains(&condition), "{condition}");
    }

    #[test]
    fn it_runs() {
        main();
    }
}
