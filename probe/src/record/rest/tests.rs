use super::*;

#[test]
fn half_a_millimetre_within_the_windows_is_rest_and_the_next_larger_movement_is_not() {
    assert_eq!(at_rest_at_home(3, 0.000_5, 0.0), Ok(()));
    let moved_m = 0.000_5_f64.next_up();
    let moving = Unrest::Moving { jack: 3, moved_m };
    assert_eq!(at_rest_at_home(3, moved_m, 0.0), Err(moving));
}

#[test]
fn twenty_millimetres_from_home_are_home_and_the_next_larger_distance_is_not() {
    for sign in [-1.0, 1.0] {
        assert_eq!(at_rest_at_home(5, 0.0, sign * 0.02), Ok(()));
        let off_m = sign * 0.02_f64.next_up();
        let away = Unrest::Away { jack: 5, off_m };
        assert_eq!(at_rest_at_home(5, 0.0, off_m), Err(away));
    }
}

/// A base whose six homes differ, seen for a second in which each jack is a little off its home and trembles.
fn watch(change: impl FnOnce(&mut [Displacements])) -> RestWatch {
    let home_m = [0.011, -0.022, 0.033, -0.044, 0.055, -0.066];
    let window = |index: usize| {
        // Up and down by 0.1 mm, or by 0.2 mm for every second jack.
        let tremble_m = if index.is_multiple_of(2) { 1e-4 } else { -1e-4 };
        core::array::from_fn(|jack| home_m[jack] + 1e-3 + tremble_m * (1 + jack % 2) as f64)
    };
    let mut windows: Vec<Displacements> = (0..60).map(window).collect();
    change(&mut windows);
    RestWatch { home_m, windows }
}

#[test]
fn rest_is_told_with_the_mean_and_the_deviation_of_each_jack() {
    let rest = watch(|_| {}).judge().unwrap();
    let mean_m = [0.012, -0.021, 0.034, -0.043, 0.056, -0.065];
    let deviation_m = [1e-4, 2e-4, 1e-4, 2e-4, 1e-4, 2e-4];
    for jack in 0..JACKS {
        assert!((rest.mean_m[jack] - mean_m[jack]).abs() < 1e-12);
        assert!((rest.deviation_m[jack] - deviation_m[jack]).abs() < 1e-12);
    }
}

#[test]
fn the_jack_that_moves_is_named_with_the_whole_of_its_movement() {
    for jack in 0..JACKS {
        for (moved_m, moves) in [(0.000_499_9, false), (0.000_500_1, true)] {
            let judged = watch(|windows| {
                let lowest = windows.iter().map(|window| window[jack]);
                let lowest = lowest.fold(f64::INFINITY, f64::min);
                windows[41][jack] = lowest + moved_m;
            })
            .judge();
            let Err(unrest) = judged else {
                assert!(!moves, "jack {jack} moved {moved_m}");
                continue;
            };
            let Unrest::Moving {
                jack: named,
                moved_m: found,
            } = unrest
            else {
                panic!("{unrest:?}");
            };
            assert!(moves && named == jack + 1 && (found - moved_m).abs() < 1e-12);
        }
    }
}

#[test]
fn the_jack_that_is_away_from_its_own_home_is_named_with_its_distance() {
    for jack in 0..JACKS {
        for sign in [-1.0, 1.0] {
            let judged = |off_m: f64| {
                watch(|windows| {
                    let moved_m = sign * off_m - 1e-3;
                    windows
                        .iter_mut()
                        .for_each(|window| window[jack] += moved_m);
                })
                .judge()
            };
            assert!(judged(0.019_999_9).is_ok());
            let Err(Unrest::Away { jack: named, off_m }) = judged(0.020_000_1) else {
                panic!("jack {jack} is at home");
            };
            assert!(named == jack + 1 && (off_m - sign * 0.020_000_1).abs() < 1e-12);
        }
    }
}
