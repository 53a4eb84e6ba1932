//! Geometry files that come with the product, as TOML text.
//!
//! Two kinds: `il-96-300`, `tu-204` and `an-74tk-200` are representative 6-3 layouts, fixed so that results compare,
//! and not the real hinges of those simulators; the `rexroth_…` bases are real ones, z-up as published. The `note` of
//! each file says what is known and what is assumed. The host tool and the twin each read these files with their own
//! code, and turn z-up ones into the body frame by (x, y, z) → (x, z, −y).
#![no_std]
#![forbid(unsafe_code)]

/// Name and geometry file (TOML text, lengths in metres) of each preset.
pub const PRESETS: &[(&str, &str)] = &[
    ("il-96-300", include_str!("../il-96-300.toml")),
    ("tu-204", include_str!("../tu-204.toml")),
    ("an-74tk-200", include_str!("../an-74tk-200.toml")),
    (
        "rexroth_emotion8000",
        include_str!("../rexroth_emotion8000.toml"),
    ),
    (
        "rexroth_emotion1500",
        include_str!("../rexroth_emotion1500.toml"),
    ),
];
