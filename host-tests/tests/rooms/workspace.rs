//! The arrows between crates, out of their manifests.

use std::process::Command;

use serde_json::Value;

use crate::root;

/// What a crate of the workspace may depend on.
struct Rule {
    name: &'static str,
    allowed: &'static [&'static str],
    /// In its tests and examples, beside `allowed`.
    in_tests: &'static [&'static str],
}

/// The library of `hexsense` is the numbers of this board, for the firmware and for tests; a host tool has them from the
/// board that it talks to.
///
/// Nothing links `virtual-board`: it is GPL-2.0 as a whole, and a process of its own. Nothing but `xtask` depends on the
/// tests, and nothing on `xtask`.
const RULES: &[Rule] = &[
    rule("hexsense", &["hexsense-core"], &[]),
    rule("hexsense-core", &[], &["geometries"]),
    rule("hexsense-client", &["hexsense-core"], &[]),
    rule("geometries", &[], &[]),
    rule(
        "hexsense-probe",
        &["geometries", "hexsense-client", "hexsense-core", "tables"],
        &["hexsense", "twin"],
    ),
    rule("tables", &[], &[]),
    rule("twin", &["geometries", "tables"], &[]),
    rule("virtual-board", &[], &[]),
    rule("sample-path-bench", &["hexsense-core"], &[]),
    rule(
        "hostile",
        &[
            "hexsense",
            "hexsense-client",
            "hexsense-core",
            "hexsense-probe",
        ],
        &[],
    ),
    rule(
        "host-tests",
        &[
            "geometries",
            "hexsense",
            "hexsense-client",
            "hexsense-core",
            "hexsense-probe",
            "hostile",
            "twin",
        ],
        &[],
    ),
    rule(
        "board-tests",
        &[
            "geometries",
            "hexsense",
            "hexsense-client",
            "hexsense-core",
            "hexsense-probe",
            "host-tests",
            "hostile",
            "tables",
            "twin",
        ],
        &[],
    ),
    rule(
        "xtask",
        &[
            "board-tests",
            "hexsense-client",
            "hexsense-core",
            "hexsense-probe",
            "host-tests",
            "hostile",
        ],
        &[],
    ),
];

/// Drivers, executors and register definitions of chips, by the beginning of their names.
const NOT_BELOW_THE_CORE: [&str; 5] = ["embassy-", "stm32", "cortex-m", "defmt", "probe-rs"];

const fn rule(
    name: &'static str,
    allowed: &'static [&'static str],
    in_tests: &'static [&'static str],
) -> Rule {
    Rule {
        name,
        allowed,
        in_tests,
    }
}

/// What `cargo metadata` says of the workspace's own crates; it needs no network.
pub fn metadata() -> Value {
    let text = cargo(&["metadata", "--no-deps", "--format-version", "1"]);
    serde_json::from_str(&text).expect("cargo metadata prints JSON")
}

/// The packages that the core is built from on the board's target, one a line.
pub fn core_tree() -> String {
    let target = ["--target", "thumbv7em-none-eabihf"];
    let normal = ["--edges", "normal", "--prefix", "none"];
    cargo(
        &[
            &["tree", "--package", "hexsense-core"],
            &target[..],
            &normal,
        ]
        .concat(),
    )
}

fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .args(["--offline", "--locked"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo {arguments:?}: {error}");
    String::from_utf8(output.stdout).expect("cargo prints UTF-8")
}

/// One text for each arrow between crates that no rule allows.
pub fn forbidden(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"]
        .as_array()
        .map_or(&[][..], Vec::as_slice);
    let mut wrong = Vec::new();
    for package in packages {
        let name = package["name"].as_str().unwrap_or_default();
        let Some(rule) = RULES.iter().find(|rule| rule.name == name) else {
            wrong.push(format!(
                "{name}: say in host-tests/tests/rooms/workspace.rs what it may depend on"
            ));
            continue;
        };
        let dependencies = package["dependencies"]
            .as_array()
            .map_or(&[][..], Vec::as_slice);
        for dependency in dependencies
            .iter()
            .filter(|dependency| dependency["path"].is_string())
        {
            let to = dependency["name"].as_str().unwrap_or_default();
            let in_tests = dependency["kind"].as_str() == Some("dev");
            if !(rule.allowed.contains(&to) || in_tests && rule.in_tests.contains(&to)) {
                wrong.push(format!(
                    "{name} depends on {to}, which the architecture forbids"
                ));
            }
        }
    }
    wrong
}

/// One text for each package that ties the core to a chip or an executor.
pub fn below_the_core(tree: &str) -> Vec<String> {
    let packages: Vec<&str> = tree
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    if !packages.contains(&"hexsense-core") {
        return vec![format!("no tree of hexsense-core:\n{tree}")];
    }
    packages
        .iter()
        .filter(|package| {
            NOT_BELOW_THE_CORE
                .iter()
                .any(|begin| package.starts_with(begin))
        })
        .map(|package| format!("the core is built from {package}"))
        .collect()
}
