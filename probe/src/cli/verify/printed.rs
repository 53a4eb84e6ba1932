//! What `hexsense verify` prints of channels and poses.

use super::*;

fn verdict(name: &str, unit: &str, numbers: [f64; 5]) -> ChannelVerdict {
    let [
        rms_signal,
        rms_error_before,
        rms_error_after,
        mean_error,
        mean_uncertainty,
    ] = numbers;
    ChannelVerdict {
        name: name.to_owned(),
        unit: unit.to_owned(),
        rms_signal,
        rms_error_before,
        rms_error_after,
        mean_error,
        mean_uncertainty,
    }
}

#[test]
fn before_after_share_mean_unit_and_verdict_stand_in_the_order_of_the_head() {
    let verdicts = [
        verdict("ax", "m/s²", [1.23, 0.456, 0.0123, -0.0021, 0.0045]),
        // 0.016 of 0.4 is 4 %.
        verdict("ey", "rad/s²", [0.4, 0.0345, 0.016, -0.0012, 0.0018]),
        // The mean is beyond its uncertainty.
        verdict("wz", "rad/s", [0.07, 0.00891, 0.0014, 0.00062, 0.00051]),
    ];
    let expected = "
channel  signal rms  error rms before  after      of signal   mean error ± uncertainty
ax          1.23000           0.45600    0.01230     1.00 %     -0.00210 ± 0.00450   m/s²    passes
ey          0.40000           0.03450    0.01600     4.00 %     -0.00120 ± 0.00180   rad/s²  does not pass
wz          0.07000           0.00891    0.00140     2.00 %      0.00062 ± 0.00051   rad/s   does not pass

";
    assert_eq!(table(&verdicts), expected);
}

#[test]
fn the_poses_their_largest_distance_with_its_scan_their_largest_angle_and_the_limit_of_both() {
    let difference = Difference {
        poses: 1_204,
        largest_m: 1.234e-7,
        largest_rad: 4.56e-8,
        scan: 98_765,
    };
    assert_eq!(
        poses_line(&difference),
        "1204 poses of the board: at most 1.23e-7 m (scan 98765) and 4.56e-8 rad off double precision, limit 5e-7"
    );
}
