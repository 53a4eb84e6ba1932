//! Board, twin and host tool together, as a user has them.
//!
//! `cargo xtask test` builds them, names them in the environment (see [`board_tests::programs`]) and runs these tests with
//! `-- --ignored`.

mod demo;
mod plug;
mod streams;
mod told;

use std::path::Path;

use board_tests::virtual_bench::VirtualBench;

const SEED: u64 = 1;
const GEOMETRY: &str = "an-74tk-200";

/// A bench in this folder.
fn bench(folder: &Path) -> VirtualBench<'_> {
    VirtualBench {
        seed: SEED,
        geometry: GEOMETRY,
        folder,
    }
}
