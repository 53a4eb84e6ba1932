//! From command to pose in the small campaign.

use crate::page::{captioned, parsed};
use crate::small::SMALL_PAGE;

#[test]
fn ratio_decibel_phase_and_distortion_stand_in_their_columns_with_sign_and_unit() {
    let table = captioned(&parsed(&SMALL_PAGE), 11);
    assert_eq!(
        table.caption,
        "Table 11. From command to pose: amplitudes of the first harmonic, their ratio and phase, and the total \
         harmonic distortion of the pose (harmonics 2 to 5). A negative phase is a lag."
    );
    assert_eq!(
        table.head,
        "Degree of freedom | Frequency [Hz] | Command | Pose |  | Ratio | Ratio [dB] | Phase [°] | Distortion [%]"
    );
    // 20 lg 0.97 = −0.2646, 20 lg 1.025 = 0.2145.
    let expected = [
        "heave | 0.50123 | 50.00 | 48.50 | mm | 0.9700 | −0.265 | −12.34 | 1.23",
        "roll | 0.25012 | 4.0000 | 4.1000 | degrees | 1.0250 | 0.214 | 3.21 | 0.45",
    ];
    assert_eq!(table.rows, expected);
}
