use super::*;
use hexsense_core::sampling::BlockSize;

#[test]
fn sums_count_when_they_are_complete_and_of_the_very_drive_that_was_asked_for() {
    let asked = Drive {
        increment: 1 << 52,
        block: BlockSize::Eight,
        settle_blocks: 300,
        blocks: 750,
    };
    assert!(is_whole(AnalyserState::Complete, &asked, &asked));
    for state in [
        AnalyserState::Idle,
        AnalyserState::Settling,
        AnalyserState::Summing,
    ] {
        assert!(!is_whole(state, &asked, &asked), "{state:?}");
    }
    let others: [fn(&mut Drive); 5] = [
        |drive| drive.increment += 1,
        |drive| drive.block = BlockSize::Four,
        |drive| drive.settle_blocks -= 1,
        |drive| drive.blocks -= 1,
        |drive| drive.blocks += 1,
    ];
    for change in others {
        let mut other = asked;
        change(&mut other);
        assert!(
            !is_whole(AnalyserState::Complete, &other, &asked),
            "{other:?}"
        );
    }
}
