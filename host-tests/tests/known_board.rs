//! The host tool and the firmware know the same board.

#[test]
fn the_board_that_the_host_tool_assumes_is_the_one_of_the_firmware() {
    assert_eq!(hexsense_probe::known_board::FACTS, hexsense::FACTS);
}
