//! Hostile files, and outputs that are not there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use geometries::PRESETS;

use super::command::{Ended, Hexsense, Output};
use super::server::{good_board, with_board};

/// A hostile file.
pub struct Hostile {
    /// What it is.
    pub name: &'static str,
    /// What the command must say.
    pub told: &'static str,
    /// Makes the file in a folder and runs the command.
    pub carry_out: fn(&Path) -> anyhow::Result<Ended>,
}

const fn hostile(
    name: &'static str,
    told: &'static str,
    carry_out: fn(&Path) -> anyhow::Result<Ended>,
) -> Hostile {
    Hostile {
        name,
        told,
        carry_out,
    }
}

const PLAN: [&str; 4] = ["plan", "--geometry", "base.toml", "--out"];

/// All of them.
pub fn all() -> Vec<Hostile> {
    vec![
        hostile(
            "a device without an end",
            "is larger than 1048576 bytes",
            |folder| hexsense(folder, &["plan", "--geometry", "/dev/zero"]),
        ),
        hostile("100 MB of TOML", "is larger than 1048576 bytes", |folder| {
            let mut file = BufWriter::new(File::create(folder.join("base.toml"))?);
            for number in 0..5_000_000 {
                writeln!(file, "key{number} = [1.0, 2.0]")?;
            }
            file.flush()?;
            hexsense(folder, &[&PLAN[..], &["campaign"]].concat())
        }),
        hostile("TOML of many levels", "base.toml", |folder| {
            let deep = format!("name = {}{}", "[".repeat(400_000), "]".repeat(400_000));
            geometry(folder, &deep)
        }),
        hostile(
            "a name that moves the cursor",
            r"\u001b[2J\u000a\u009b",
            |folder| {
                geometry(
                    folder,
                    &preset().replacen(
                        "name = \"an-74tk-200\"",
                        "name = \"\\u001B[2J\\u000A\\u009B\\u007F\\u202E\"",
                        1,
                    ),
                )
            },
        ),
        hostile(
            "a line that moves the cursor",
            r"\u001b]0;owned\u0007",
            |folder| geometry(folder, &format!("\u{1b}]0;owned\u{7} = 1\n{}", preset())),
        ),
        hostile("numbers beyond every base", "must be", |folder| {
            geometry(
                folder,
                &preset().replacen("length_max = 3.40", "length_max = 1e308", 1),
            )
        }),
        hostile("a pipe in the place of a file", "it is a pipe", |folder| {
            std::process::Command::new("mkfifo")
                .arg(folder.join("base.toml"))
                .status()?;
            hexsense(folder, &[&PLAN[..], &["campaign"]].concat())
        }),
        hostile("a run that never ends", "must be", |folder| {
            let plan = plan_of(folder)?;
            changed_plan(folder, &plan.replacen("rest_s = 10.0", "rest_s = 1e300", 1))
        }),
        hostile("a program of endless rows", "must be", |folder| {
            let plan = plan_of(folder)?;
            changed_plan(
                folder,
                &plan.replacen("frequency_hz = ", "frequency_hz = 1e-300 # ", 1),
            )
        }),
        hostile("a note of many levels", "campaign.json", |folder| {
            plan_of(folder)?;
            let deep = format!("{}{}", "[".repeat(1_000_000), "]".repeat(1_000_000));
            fs::write(folder.join("campaign/campaign.json"), deep)?;
            hexsense(folder, &["report", "campaign"])
        }),
        hostile("a key that others read", "chmod 600", |folder| {
            key(folder, "5ec5", 0o644)
        }),
        hostile(
            "a key of zeros",
            "all bytes of this key are the same",
            |folder| key(folder, "0000", 0o600),
        ),
        hostile("a key without an end", "this is no key file", |folder| {
            with_board(
                good_board(),
                folder,
                &["rollback", "--key", "/dev/zero", "07"],
                |_| {},
            )
        }),
        hostile("a link in the place of a recording", "", |folder| {
            let [aim, part] = ["aim", "scans.csv.part"].map(|name| folder.join(name));
            fs::write(&aim, "mine")?;
            symlink(&aim, part)?;
            let arguments = ["capture", "--seconds", "0.1", "--out", "scans.csv"];
            let ended = with_board(good_board(), folder, &arguments, |_| {})?;
            anyhow::ensure!(fs::read_to_string(aim)? == "mine", "the link was followed");
            anyhow::ensure!(ended.code == Some(0), "no recording: {}", ended.said);
            Ok(ended)
        }),
        hostile("a reader that closes its end", "", |folder| {
            let closed = |command: &mut Hexsense| command.output = Output::Closed;
            let ended = with_board(good_board(), folder, &["show"], closed)?;
            anyhow::ensure!(
                ended.code == Some(0) && ended.said.is_empty(),
                "{}",
                ended.said
            );
            Ok(ended)
        }),
        hostile(
            "an output that is full",
            "standard output cannot be written",
            |folder| {
                let full = |command: &mut Hexsense| command.output = Output::To("/dev/full");
                with_board(good_board(), folder, &["show"], full)
            },
        ),
    ]
}

fn preset() -> &'static str {
    let found = PRESETS.iter().find(|(name, _)| *name == "an-74tk-200");
    found.map_or("", |(_, text)| text)
}

/// A plan for a geometry file with this text.
fn geometry(folder: &Path, text: &str) -> anyhow::Result<Ended> {
    fs::write(folder.join("base.toml"), text)?;
    hexsense(folder, &[&PLAN[..], &["campaign"]].concat())
}

/// The text of a good plan, which is in the folder then.
fn plan_of(folder: &Path) -> anyhow::Result<String> {
    let ended = geometry(folder, preset())?;
    anyhow::ensure!(ended.code == Some(0), "no plan: {}", ended.said);
    Ok(fs::read_to_string(folder.join("campaign/plan.toml"))?)
}

fn changed_plan(folder: &Path, plan: &str) -> anyhow::Result<Ended> {
    fs::write(folder.join("plan.toml"), plan)?;
    hexsense(
        folder,
        &["plan", "--geometry", "base.toml", "--plan", "plan.toml"],
    )
}

/// A rollback with a key file of these digits and permissions.
fn key(folder: &Path, digits: &str, mode: u32) -> anyhow::Result<Ended> {
    let path = folder.join("board.key");
    fs::write(&path, digits.repeat(16))?;
    fs::set_permissions(&path, fs::Permissions::from_mode(mode))?;
    with_board(
        good_board(),
        folder,
        &["rollback", "--key", "board.key", "07"],
        |_| {},
    )
}

/// `hexsense` with these arguments in `folder`.
fn hexsense(folder: &Path, arguments: &[&str]) -> anyhow::Result<Ended> {
    Hexsense::new(folder, arguments).run()
}
