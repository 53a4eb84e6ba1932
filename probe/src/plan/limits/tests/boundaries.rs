//! The decisions at their limits: what lies on a limit is allowed, the nearest number beyond it is not.

use super::super::*;

const NONE: Use = Use {
    jack: 1,
    time_s: 0.0,
    value: 0.0,
    limit: f64::INFINITY,
    fraction: 0.0,
};
const SHORTEST_M: f64 = 2.0;
/// An acceleration of 4 m/s² adds 4·0.5²/2 = 0.5 m to a length in this time.
const STEP_S: f64 = 0.5;

fn jack_5(value: f64, limit: f64) -> Use {
    Use {
        jack: 5,
        time_s: 1.5,
        value,
        limit,
        fraction: 0.0,
    }
}

fn uses(change: impl FnOnce(&mut Uses)) -> Uses {
    let mut uses = Uses {
        length: Use {
            value: 2.75,
            ..NONE
        },
        speed: NONE,
        acceleration: NONE,
    };
    change(&mut uses);
    uses
}

fn refusal(quantity: Quantity, value: f64, limit: f64) -> BeyondLimit {
    BeyondLimit::Jack {
        run: "roll".to_owned(),
        jack: 5,
        time_s: 1.5,
        quantity,
        value,
        limit,
    }
}

/// That a use which may reach `reach` between samples is allowed at that limit, and refused at the next tighter one.
fn assert_edge(quantity: Quantity, reach: f64, limits: [f64; 2], of: impl Fn(f64) -> Uses) {
    let judged = |limit| jacks_within("roll", &of(limit), STEP_S, SHORTEST_M);
    let [at, beyond] = limits;
    assert_eq!(judged(at), Ok(()));
    assert_eq!(judged(beyond), Err(refusal(quantity, reach, beyond)));
}

#[test]
fn a_jack_may_grow_up_to_its_stop_with_what_it_may_grow_between_samples() {
    for acceleration in [4.0, -4.0] {
        let limits = [3.5, 3.5_f64.next_down()];
        assert_edge(Quantity::Length, 3.5, limits, |limit| {
            uses(|uses| {
                uses.length = jack_5(3.0, limit);
                uses.acceleration.value = acceleration;
            })
        });
    }
}

#[test]
fn a_jack_may_shrink_down_to_its_stop_with_what_it_may_shrink_between_samples() {
    for acceleration in [4.0, -4.0] {
        let shrunk = uses(|uses| {
            uses.acceleration.value = acceleration;
        });
        for (shortest_m, allowed) in [(2.0, true), (2.0_f64.next_up(), false)] {
            let uses = Uses {
                length: jack_5(2.5, shortest_m),
                ..shrunk
            };
            let judged = jacks_within("roll", &uses, STEP_S, shortest_m);
            let refused = Err(refusal(Quantity::Length, 2.0, shortest_m));
            assert_eq!(judged, if allowed { Ok(()) } else { refused });
        }
    }
}

#[test]
fn speed_may_be_as_high_as_its_limit_with_half_a_hundredth_between_samples() {
    for sign in [-1.0, 1.0] {
        let limits = [1.005, 1.005_f64.next_down()];
        assert_edge(Quantity::Speed, sign * 1.005, limits, |limit| {
            uses(|uses| uses.speed = jack_5(sign, limit))
        });
    }
}

#[test]
fn acceleration_may_be_as_high_as_its_limit_with_half_a_hundredth_between_samples() {
    for sign in [-1.0, 1.0] {
        let limits = [2.01, 2.01_f64.next_down()];
        assert_edge(Quantity::Acceleration, sign * 2.01, limits, |limit| {
            uses(|uses| uses.acceleration = jack_5(sign * 2.0, limit))
        });
    }
}

#[test]
fn what_is_not_a_number_is_within_no_limit() {
    let spoil: [fn(&mut Uses); 3] = [
        |uses| uses.length = jack_5(f64::NAN, 3.5),
        |uses| uses.speed = jack_5(f64::NAN, 1.0),
        |uses| uses.acceleration = jack_5(f64::NAN, 1.0),
    ];
    for spoil in spoil {
        assert!(jacks_within("roll", &uses(spoil), STEP_S, SHORTEST_M).is_err());
    }
}

#[test]
fn a_hinge_may_turn_up_to_its_limit() {
    for (joint, jack) in [(Joint::Lower, 2), (Joint::Upper, 6)] {
        let with = |angle_deg| HingeUse {
            joint,
            jack,
            time_s: 2.5,
            angle_deg,
            limit_deg: 30.0,
        };
        assert_eq!(hinge_within("roll", &with(30.0)), Ok(()));
        let angle_deg = 30.0_f64.next_up();
        let refused = BeyondLimit::Hinge {
            run: "roll".to_owned(),
            jack,
            joint,
            time_s: 2.5,
            angle_deg,
            limit_deg: 30.0,
        };
        assert_eq!(hinge_within("roll", &with(angle_deg)), Err(refused));
        assert!(hinge_within("roll", &with(f64::NAN)).is_err());
    }
}

#[test]
fn a_condition_number_of_twenty_five_holds_the_platform_and_the_next_larger_one_does_not() {
    let with = |bound| Conditioning {
        time_s: 2.5,
        condition: 3.0,
        bound,
    };
    assert_eq!(condition_within("roll", &with(25.0)), Ok(()));
    let bound = 25.0_f64.next_up();
    let refused = BeyondLimit::Condition {
        run: "roll".to_owned(),
        time_s: 2.5,
        bound,
        better_order: None,
    };
    assert_eq!(condition_within("roll", &with(bound)), Err(refused));
    for bound in [f64::INFINITY, f64::NAN] {
        assert!(condition_within("roll", &with(bound)).is_err());
    }
}
