//! Prints the time that kinematics takes, as one JSON document; `cargo xtask bench kinematics` builds and runs it. With
//! the argument `--cases` it prints the base and poses instead, for another program to solve.

fn main() -> serde_json::Result<()> {
    let text = if std::env::args().any(|argument| argument == "--cases") {
        serde_json::to_string(&host_tests::speed::cases())?
    } else {
        serde_json::to_string(&host_tests::speed::measure())?
    };
    println!("{text}");
    Ok(())
}
