//! Prints how long kinematics takes, as one JSON document; `cargo xtask bench kinematics` builds and runs it.

fn main() -> serde_json::Result<()> {
    let figures = host_tests::speed::measure();
    println!("{}", serde_json::to_string(&figures)?);
    Ok(())
}
