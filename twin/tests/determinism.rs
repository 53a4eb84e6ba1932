//! The same seed gives the same bench, to the last bit, and another seed another bench.

mod support;

use support::an74;
use twin::Bench;

/// All voltages of a session with a run and a stop in it.
fn session(seed: u64) -> Vec<u32> {
    let geometry = an74();
    let mut bench = Bench::with_geometry(seed, &geometry).unwrap();
    let (mut rows, mut session) = (Vec::new(), Vec::new());
    for chunk in 0..750 {
        match chunk {
            10 => bench.run("six", support::six_axes(&geometry, 4.0)).unwrap(),
            700 => bench.stop(),
            _ => {}
        }
        bench.next_chunk(&mut rows, |_| ()).unwrap();
        session.extend(rows.iter().map(|volts| volts.to_bits()));
    }
    session
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    assert!(session(1) == session(1));
}

#[test]
fn another_seed_gives_another_bench() {
    let (one, two) = (session(1), session(2));
    let same = one.iter().zip(&two).filter(|(a, b)| a == b).count();
    assert!(
        same * 1000 < one.len(),
        "{same} of {} values agree",
        one.len()
    );
}
