//! Small crates and workspaces in memory, on which each check fails, or does not.

use serde_json::{Value, json};

use crate::circles::{self, Halves};
use crate::source::Source;
use crate::workspace;

fn find(files: &[(&str, &str)]) -> Vec<String> {
    find_with(files, &[])
}

fn find_with(files: &[(&str, &str)], halves: &[Halves]) -> Vec<String> {
    let sources: Vec<Source> = files
        .iter()
        .map(|(path, text)| Source::new(path, text))
        .collect();
    circles::find(&sources, "made_up", halves)
}

/// The one circle there is has these lines, in any order.
#[track_caller]
fn one_circle(files: &[(&str, &str)], lines: &[&str]) {
    let found = find(files);
    assert_eq!(found.len(), 1, "{found:#?}");
    for line in lines {
        assert!(found[0].contains(line), "{line:?} is not in\n{}", found[0]);
    }
}

const ROOT: (&str, &str) = ("lib.rs", "mod a; mod b; mod c;");

#[test]
fn two_folders_that_import_each_other_are_named_with_file_and_line() {
    one_circle(
        &[
            ROOT,
            ("a/mod.rs", "pub mod one;"),
            (
                "a/one.rs",
                "//! One.\n\nuse crate::b::two::Two;\npub struct One(Two);",
            ),
            ("b/mod.rs", "pub mod two; pub mod three;"),
            ("b/two.rs", "pub struct Two;"),
            (
                "b/three.rs",
                "use crate::a::one::One;\npub struct Three(One);",
            ),
        ],
        &[
            "circle in src: a, b",
            "a/one.rs:3 crate::b::two::Two (b/two.rs)",
            "b/three.rs:1 crate::a::one::One (a/one.rs)",
        ],
    );
}

#[test]
fn three_files_of_one_folder_in_a_circle_are_found() {
    one_circle(
        &[
            ("lib.rs", "mod a;"),
            ("a/mod.rs", "mod one; mod two; mod three;"),
            ("a/one.rs", "use super::two::Two; pub struct One(Two);"),
            ("a/two.rs", "pub struct Two; fn f() { super::three::g() }"),
            ("a/three.rs", "pub fn g() { let _: crate::a::one::One; }"),
        ],
        &[
            "circle in a: one.rs, three.rs, two.rs",
            "a/two.rs:1 super::three::g (a/three.rs)",
        ],
    );
}

#[test]
fn arrows_one_way_are_no_circle() {
    let files = [
        (
            "main.rs",
            "mod a; mod b; mod c; fn main() { a::f(); c::g(); }",
        ),
        ("a.rs", "use crate::b::B; use crate::c::C; pub fn f() {}"),
        ("b.rs", "use crate::c::C; pub struct B(C);"),
        ("c.rs", "pub struct C; pub fn g() {}"),
    ];
    assert_eq!(find(&files), Vec::<String>::new());
}

#[test]
fn a_path_in_the_body_of_a_macro_is_an_arrow() {
    one_circle(
        &[
            ROOT,
            ("a.rs", "use crate::b::B; pub struct A;"),
            (
                "b.rs",
                "pub struct B;\nfn f() { println!(\"{}\", crate::a::A); }",
            ),
        ],
        &["b.rs:2 crate::a::A (a.rs)"],
    );
}

#[test]
fn a_group_of_imports_has_an_arrow_for_each() {
    one_circle(
        &[
            ROOT,
            (
                "a.rs",
                "use crate::{\n    b::{self, B},\n    c::C as Other,\n};",
            ),
            ("b.rs", "pub struct B;"),
            ("c.rs", "pub struct C;\nuse crate::a::*;"),
        ],
        &[
            "circle in src: a.rs, c.rs",
            "a.rs:3 crate::c::C (c.rs)",
            "c.rs:2 crate::a (a.rs)",
        ],
    );
}

#[test]
fn a_facade_is_looked_through() {
    let files = [
        ("lib.rs", "mod a;"),
        (
            "a/mod.rs",
            "mod one; mod two; pub use one::One; pub use two::*;",
        ),
        ("a/one.rs", "use super::Two; pub struct One(Two);"),
        ("a/two.rs", "pub struct Two;"),
    ];
    assert_eq!(find(&files), Vec::<String>::new());
}

#[test]
fn a_facade_that_uses_what_it_offers_has_an_arrow() {
    one_circle(
        &[
            ("lib.rs", "mod a;"),
            (
                "a/mod.rs",
                "mod one; pub use one::One;\npub struct Both(One); pub const LIMIT: u8 = 1;",
            ),
            (
                "a/one.rs",
                "use super::LIMIT; pub struct One([u8; LIMIT as usize]);",
            ),
        ],
        &["circle in a: mod.rs, one.rs", "a/mod.rs:2 One (a/one.rs)"],
    );
}

#[test]
fn tests_documentation_and_names_of_variables_are_no_arrows() {
    let files = [
        ROOT,
        ("a.rs", "use crate::b::B; pub fn a() {}"),
        (
            "b.rs",
            "//! See [`crate::a`].\npub struct B;\n#[cfg(test)]\nmod tests { use crate::a::a; }\n\
             #[cfg(test)] use crate::a::a;\nfn f(a: u8) -> u8 { let c = B; c.a(); a }",
        ),
    ];
    assert_eq!(find(&files), Vec::<String>::new());
}

#[test]
fn two_halves_of_one_type_may_import_each_other_and_nothing_more() {
    let halves = |files| Halves {
        files,
        reason: "the type and its methods",
    };
    let pair = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "use crate::a::A; pub struct B;"),
    ];
    let listed = [halves(["a.rs", "b.rs"])];
    assert_eq!(find_with(&pair, &listed), Vec::<String>::new());

    let third = ("c.rs", "use crate::b::B;");
    let outside = ("a.rs", "use crate::b::B; use crate::c::C; pub struct A;");
    let found = find_with(&[pair[0], outside, pair[2], third], &listed);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(
        found[0].contains("circle in src: a.rs, c.rs"),
        "{}",
        found[0]
    );

    let mended = find_with(&[pair[0], pair[1], ("b.rs", "pub struct B;")], &listed);
    assert!(mended[0].contains("take them off the list"), "{mended:#?}");
}

/// A workspace of one crate with one dependency inside the workspace.
fn crate_with(name: &str, dependency: &str, kind: Option<&str>) -> Value {
    json!({ "packages": [{
        "name": name,
        "dependencies": [
            { "name": dependency, "kind": kind, "path": "/made/up" },
            { "name": "serde", "kind": null },
        ],
    }]})
}

#[test]
fn an_arrow_against_the_architecture_is_forbidden() {
    for (name, dependency, kind) in [
        ("hexsense-core", "geometries", None),
        ("hexsense-core", "hexsense-client", Some("dev")),
        ("twin", "hexsense-core", None),
        ("hexsense-probe", "twin", None),
        ("hexsense-probe", "hexsense", None),
        ("hexsense-probe", "xtask", Some("dev")),
        ("xtask", "virtual-board", None),
        ("a-new-crate", "hexsense-core", None),
    ] {
        let wrong = workspace::forbidden(&crate_with(name, dependency, kind));
        assert_eq!(wrong.len(), 1, "{name} → {dependency}: {wrong:?}");
    }
    for (name, dependency, kind) in [
        ("hexsense-core", "geometries", Some("dev")),
        ("hexsense-probe", "twin", Some("dev")),
        ("hexsense", "hexsense-core", None),
    ] {
        let wrong = workspace::forbidden(&crate_with(name, dependency, kind));
        assert_eq!(wrong, Vec::<String>::new());
    }
}

#[test]
fn a_driver_below_the_core_is_found() {
    let tree = "hexsense-core v0.1.0 (/made/up)\nheapless v0.9.3\nembassy-stm32 v0.6.0\nembassy-executor v0.10.0\n";
    assert_eq!(workspace::below_the_core(tree).len(), 2);
    assert_eq!(workspace::below_the_core("").len(), 1);
}
