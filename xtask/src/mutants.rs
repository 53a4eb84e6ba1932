//! `cargo xtask mutants`: small mistakes, put into the code one at a time by cargo-mutants. The tests should notice each.
//!
//! All mutants of a package would take days, so a sample is drawn. A seed and a commit always give the same sample.
//!
//! The mistakes go into a copy of the sources in `target/mutants/tree`, which keeps its own builds, so that a mutant costs
//! what it changes and no more. The copy has what git tracks, with changes that are not committed yet; a new file counts
//! once it is added to git. The tests named like the mutant's file or folder come first, because they build soonest; the
//! other suites follow where those notice nothing.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};

use crate::command::{cargo, checked, printed, workspace};

/// `cargo xtask mutants`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Mutants to draw from each package
    #[arg(long, default_value_t = 20)]
    sample: usize,
    /// Another seed draws another sample
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The only package to change
    #[arg(long, value_parser = PACKAGES)]
    package: Option<String>,
}

/// The packages that are changed.
const PACKAGES: [&str; 2] = ["hexsense-core", "hexsense-probe"];
/// The packages whose tests should notice.
const SUITES: [&str; 3] = ["hexsense-core", "hexsense-probe", "host-tests"];
/// Folders of the suites' tests.
const TESTS: [&str; 2] = ["host-tests/tests", "probe/tests"];
/// Tests that take this many times as long as without a mistake hang.
const PATIENCE: u32 = 5;
/// Profile of the builds, which `.cargo/mutants.toml` names too.
const PROFILE: &str = "mutants";

/// Runs a sample of each package, and prints what was caught and what was missed.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    install("cargo-nextest", "nextest")?;
    install("cargo-mutants", "mutants")?;
    let tree = Tree::new()?;
    let timeout = tree.baseline()? * PATIENCE + Duration::from_secs(30);
    let wanted = |package: &&str| {
        arguments
            .package
            .as_ref()
            .is_none_or(|name| name == package)
    };
    let mut packages = PACKAGES.into_iter().filter(wanted);
    packages.try_for_each(|package| sample(&tree, package, timeout, arguments))
}

/// Installs a command of cargo where it is missing.
fn install(package: &str, command: &str) -> anyhow::Result<()> {
    if printed(cargo(command).arg("--version")).is_some() {
        return Ok(());
    }
    eprintln!("installing {package}");
    checked(cargo("install").args([package, "--locked"]))
}

/// One small mistake.
struct Mutant<'a> {
    package: &'a str,
    /// Place and change, as cargo-mutants lists it.
    name: &'a str,
    /// Its number in the list of its package, of how many.
    shard: String,
}

/// Runs a sample of a package and reports it.
fn sample(
    tree: &Tree,
    package: &str,
    timeout: Duration,
    arguments: &Arguments,
) -> anyhow::Result<()> {
    let list = printed(tree.mutants().args(["--list", "--package", package]));
    let list = list.with_context(|| format!("cargo mutants lists nothing for {package}"))?;
    let of = list.lines().count();
    let all = list.lines().enumerate().map(|(number, name)| Mutant {
        package,
        name,
        shard: format!("{number}/{of}"),
    });
    let drawn = draw(all.collect(), arguments.sample, arguments.seed);

    let (start, seed, number) = (Instant::now(), arguments.seed, drawn.len());
    let mut outcomes = Vec::new();
    for (mutant, index) in drawn.iter().zip(1..) {
        let begin = Instant::now();
        let outcome = tree.test(mutant, timeout)?;
        let seconds = begin.elapsed().as_secs();
        println!(
            "{index:>3}/{number} {outcome:<8} {seconds:>4} s  {}",
            mutant.name
        );
        outcomes.push((outcome, mutant.name));
    }
    let count = |outcome| {
        outcomes
            .iter()
            .filter(|(other, _)| *other == outcome)
            .count()
    };
    let counts = OUTCOMES
        .map(|outcome| format!("{} {outcome}", count(outcome)))
        .join(", ");
    let seconds = start.elapsed().as_secs() / number.max(1) as u64;
    println!("{package}: {number} of {of} mutants, seed {seed}: {counts}; {seconds} s each");
    for (outcome, name) in outcomes
        .iter()
        .filter(|(outcome, _)| ["missed", "timeout"].contains(outcome))
    {
        println!("  {outcome} {name}");
    }
    Ok(())
}

/// What can become of a mutant. Each is the name of a file of cargo-mutants, too. An unviable one does not compile.
const OUTCOMES: [&str; 4] = ["caught", "missed", "unviable", "timeout"];

/// The copy of the sources that takes the mistakes.
struct Tree {
    folder: PathBuf,
    /// Hash of all its files.
    hash: String,
}

impl Tree {
    /// Makes it equal to the sources. Files that are equal already stay untouched, so that they are not built again.
    fn new() -> anyhow::Result<Self> {
        let folder = workspace().join("target/mutants/tree");
        let source = workspace();
        let changed = git(&source, &["stash", "create"])?;
        let commit = if changed.is_empty() { "HEAD" } else { &changed };
        let commit = git(&source, &["rev-parse", commit])?;
        if folder.join(".git").exists() {
            git(&folder, &["checkout", "--force", "--detach", &commit])?;
        } else {
            let place = folder
                .to_str()
                .context("the path of the workspace is not UTF-8")?;
            git(
                &source,
                &["worktree", "add", "--force", "--detach", place, &commit],
            )?;
        }
        // What a test has left there, such as the case on which a property fails.
        git(&folder, &["clean", "--force", "-d"])?;
        let hash = git(&folder, &["rev-parse", "HEAD^{tree}"])?;
        Ok(Self { folder, hash })
    }

    /// How long the suites take without a mistake. They run once for the same sources.
    fn baseline(&self) -> anyhow::Result<Duration> {
        let record = self.folder.with_file_name("baseline");
        let known = std::fs::read_to_string(&record).unwrap_or_default();
        if let Some(Ok(seconds)) = known
            .strip_prefix(&self.hash)
            .map(|rest| rest.trim().parse())
        {
            return Ok(Duration::from_secs(seconds));
        }
        eprintln!("the suites without a mistake");
        let suites = || {
            let mut suites = cargo("nextest");
            suites.current_dir(&self.folder);
            suites.args(["run", "--cargo-profile", PROFILE]);
            suites.args(SUITES.iter().flat_map(|suite| ["--package", suite]));
            suites
        };
        checked(suites().arg("--no-run"))?;
        let start = Instant::now();
        checked(&mut suites())?;
        let took = start.elapsed();
        std::fs::write(record, format!("{} {}", self.hash, took.as_secs()))?;
        Ok(took)
    }

    /// Puts a mistake in and runs the tests, the likeliest first.
    fn test(&self, mutant: &Mutant, timeout: Duration) -> anyhow::Result<&'static str> {
        let likeliest = namesakes(mutant.name.split(':').next().unwrap_or_default());
        if !likeliest.is_empty() {
            let outcome = self.stage(mutant, timeout, &likeliest)?;
            if outcome != "missed" {
                return Ok(outcome);
            }
        }
        self.stage(mutant, timeout, &[])
    }

    /// Runs the suites with a mistake, or of them these files of tests and what is tested inside of the sources.
    fn stage(
        &self,
        mutant: &Mutant,
        timeout: Duration,
        only: &[String],
    ) -> anyhow::Result<&'static str> {
        let mut mutants = self.mutants();
        mutants.args([
            "--in-place",
            "--baseline",
            "skip",
            "--package",
            mutant.package,
        ]);
        // Not by its name: a mutant that deletes a field runs whatever names are asked for (cargo-mutants 27.1).
        mutants.args(["--shard", &mutant.shard]);
        mutants.args(["--test-package", &SUITES.join(",")]);
        mutants.args(["--timeout", &timeout.as_secs().to_string()]);
        let results = self.folder.with_file_name("results");
        mutants.arg("--output").arg(&results);
        if !only.is_empty() {
            mutants.args(["--cargo-arg", "--lib"]);
            mutants.args(only.iter().map(|test| format!("--cargo-arg=--test={test}")));
        }
        let status = mutants.stdout(Stdio::null()).status()?;
        let outcome = OUTCOMES.into_iter().find(|outcome| {
            let file = results.join("mutants.out").join(format!("{outcome}.txt"));
            std::fs::read_to_string(file).is_ok_and(|list| list.trim_end() == mutant.name)
        });
        let name = mutant.name;
        outcome.with_context(|| format!("no outcome of {name}; {mutants:?} ended with {status}"))
    }

    /// `cargo mutants` in this copy.
    fn mutants(&self) -> Command {
        let mut mutants = cargo("mutants");
        mutants.current_dir(&self.folder);
        mutants
    }
}

/// The output of git, which must succeed.
fn git(folder: &Path, arguments: &[&str]) -> anyhow::Result<String> {
    let output = Command::new("git")
        .current_dir(folder)
        .args(arguments)
        .output();
    let output =
        output.context("the copy of the sources is made by git, which cannot be started")?;
    if !output.status.success() {
        bail!(
            "git {}: {}",
            arguments.join(" "),
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Tests with the name of the file or of a folder that it is in.
fn namesakes(file: &str) -> Vec<String> {
    let is_test = |name: &&str| {
        TESTS.iter().any(|tests| {
            let test = workspace().join(tests).join(name);
            test.join("main.rs").exists() || test.with_extension("rs").exists()
        })
    };
    let names = file.split(['/', '.']);
    names.filter(is_test).map(str::to_owned).collect()
}

/// The first `number` of a shuffled list: Fisher-Yates with SplitMix64 (Steele, Lea, Flood 2014), whose values are so
/// wide that the remainder favours no place.
fn draw<T>(mut list: Vec<T>, number: usize, seed: u64) -> Vec<T> {
    let mut state = seed;
    let number = number.min(list.len());
    for place in 0..number {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut value = state;
        value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        value ^= value >> 31;
        let rest = list.len() - place;
        list.swap(place, place + (value % rest as u64) as usize);
    }
    list.truncate(number);
    list
}
