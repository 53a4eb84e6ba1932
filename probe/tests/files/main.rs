//! `docs/files.md` and the templates against the code: every key, which keys are required, every range.
//!
//! - [`page`]: the tables of the page.
//! - [`toml_keys`]: the keys that a reader of TOML knows, from what it says of a key that it does not know.
//! - [`json_keys`]: the keys of a type that is written as JSON.
//! - [`template`]: a template, with each of its lines by its key.

mod json_keys;
mod page;
mod template;
mod toml_keys;

use std::collections::BTreeSet;

use assert_cmd::Command;
use hexsense_probe::analysis::results::Results;
use hexsense_probe::campaign::{Begun, BoardRecord, RunRecord, Verification};
use hexsense_probe::capture::Capture;
use hexsense_probe::characteristics::Characteristics;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::Plan;
use hexsense_probe::sensor_file::SensorFile;
use hexsense_probe::{coefficient_file, templates};

use page::{PAGE, Row, rows};
use template::Template;

/// What a reader says of a text.
type Reader = fn(&str) -> Result<(), String>;

fn geometry(text: &str) -> Result<(), String> {
    let read = GeometryFile::parse("file.toml", text).map(drop);
    read.map_err(|error| error.to_string())
}

fn sensors(text: &str) -> Result<(), String> {
    let read = SensorFile::parse("file.toml", text).map(drop);
    read.map_err(|error| error.to_string())
}

fn plan(text: &str) -> Result<(), String> {
    let read = Plan::parse("file.toml", text).map(drop);
    read.map_err(|error| error.to_string())
}

fn coefficients(text: &str) -> Result<(), String> {
    let read = coefficient_file::parse("file.toml", text).map(drop);
    read.map_err(|error| error.to_string())
}

fn plan_template() -> String {
    templates::plan(&GeometryFile::load("an-74tk-200").unwrap())
}

/// The files that people write: table of the page, reader, template.
fn written() -> [(&'static str, Reader, Template); 3] {
    [
        ("geometry", geometry, Template::of(templates::GEOMETRY)),
        ("sensors", sensors, Template::of(templates::SENSORS)),
        ("plan", plan, Template::of(&plan_template())),
    ]
}

fn assert_same(name: &str, page: &BTreeSet<String>, code: &BTreeSet<String>) {
    let missing: Vec<_> = code.difference(page).collect();
    assert!(
        missing.is_empty(),
        "{name}: docs/files.md lacks {missing:?}"
    );
    let stale: Vec<_> = page.difference(code).collect();
    assert!(stale.is_empty(), "{name}: no such keys any more: {stale:?}");
}

fn keys_of(rows: &[Row]) -> BTreeSet<String> {
    rows.iter().map(|row| row.key.clone()).collect()
}

#[test]
fn the_page_and_the_templates_have_every_key_that_the_readers_know_and_no_other() {
    for (name, reader, template) in written() {
        let known = toml_keys::known(reader);
        let code = leaves(&known, &known);
        assert_same(name, &leaves(&keys_of(&rows(name)), &known), &code);
        assert_same(&format!("template of {name}"), &template.keys(), &code);
    }
    let known = toml_keys::known(coefficients);
    let page = keys_of(&rows("coefficients"));
    assert_same("coefficients", &page, &leaves(&known, &known));
}

/// `keys` without those that are tables by what is `known`.
fn leaves(keys: &BTreeSet<String>, known: &BTreeSet<String>) -> BTreeSet<String> {
    let is_table = |key: &String| {
        let begin = format!("{key}.");
        known.iter().any(|other| other.starts_with(&begin))
    };
    keys.iter().filter(|key| !is_table(key)).cloned().collect()
}

#[test]
fn the_page_has_every_key_of_the_files_of_a_campaign() {
    for (name, keys) in [
        ("campaign.json", json_keys::of::<Begun>()),
        ("board.json", json_keys::of::<BoardRecord>()),
        ("run.json", json_keys::of::<RunRecord>()),
        ("results.json", json_keys::of::<Results>()),
        ("characteristics.json", json_keys::of::<Characteristics>()),
        ("verification.json", json_keys::of::<Verification>()),
    ] {
        assert!(!keys.is_empty());
        assert_same(name, &keys_of(&rows(name)), &keys);
    }
    let header = Capture {
        values: Some(Vec::new()),
        ..Capture::default()
    };
    assert!(PAGE.contains(&format!("\n{}", header.to_text())));
    assert!(PAGE.contains(&format!("\n{}\n", twin::program::HEADER)));
}

#[test]
fn a_template_reads_without_error_as_it_is_and_with_all_its_optional_keys() {
    for (name, reader, template) in written() {
        reader(&template.as_it_is).unwrap_or_else(|error| panic!("{name}: {error}"));
        reader(&template.with_all()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn a_key_is_required_where_the_page_says_so_and_may_be_left_out_where_it_has_a_default() {
    for (name, reader, template) in written() {
        for row in rows(name) {
            let Some(text) = template.without(&row.key) else {
                continue;
            };
            let read = reader(&text);
            match row.default.as_str() {
                "required" => {
                    let error = read.expect_err(&format!("{name}: {} is not required", row.key));
                    let last = row.key.rsplit('.').next().unwrap();
                    assert!(
                        error.contains(&format!("missing field `{last}`")),
                        "{error}"
                    );
                }
                conditional if conditional.starts_with("conditional: ") => {}
                _ => {
                    read.unwrap_or_else(|error| panic!("{name}: {} is required: {error}", row.key))
                }
            }
        }
    }
}

#[test]
fn a_number_outside_the_range_of_the_page_is_refused_with_that_very_range() {
    let mut tried = 0;
    for (name, reader, template) in written() {
        for row in rows(name) {
            let Some([low, high]) = row.range(&template) else {
                continue;
            };
            let below = if low > 0.0 { low / 2.0 } else { low - 1.0 };
            for value in [below, high + 1.0] {
                let text = template.with(&row.key, value);
                let refused = reader(&text).expect_err(&format!("{name}: {} = {value}", row.key));
                let last = row.key.rsplit('.').next().unwrap();
                let stem = last.trim_end_matches("_deg").trim_end_matches("_m");
                assert!(
                    refused.contains(stem) && refused.contains(&format!("{low} to {high}")),
                    "{name}: the page has {low} to {high} for {}; {refused}",
                    row.key
                );
                tried += 1;
            }
        }
    }
    assert!(tried > 120, "{tried} ranges");
}

#[test]
fn the_command_writes_files_that_the_tool_reads_and_replaces_none() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &str| {
        let mut command = Command::cargo_bin("hexsense").unwrap();
        command
            .current_dir(folder.path())
            .args(arguments.split_whitespace());
        command.assert()
    };
    for kind in ["geometry", "sensors", "plan"] {
        run(&format!("new {kind} {kind}.toml")).success();
        run(&format!("new {kind} {kind}.toml")).failure();
    }
    run("plan --geometry geometry.toml --sensors sensors.toml").success();
    run("plan --geometry an-74tk-200 --plan plan.toml --sensors sensors.toml").success();
    run("new plan own.toml --geometry geometry.toml").success();
    run("plan --geometry geometry.toml --plan own.toml").success();
}
