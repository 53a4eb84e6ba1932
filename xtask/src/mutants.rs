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

use crate::build::{cargo, checked, workspace};
use crate::setup::printed;

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

fn sample(
    tree: &Tree,
    package: &str,
    timeout: Duration,
    arguments: &Arguments,
) -> anyhow::Result<()> {
    let list = printed(tree.mutants().args(["--list", "--package", package]));
    let list = list.with_context(|| format!("cargo mutants lists nothing for {}", package))?;
    let all: Vec<&str> = list.lines().collect();
    let drawn = draw(all.clone(), arguments.sample, arguments.seed);

    let start = Instant::now();
    let mut outcomes = Vec::new();
    for (number, mutant) in drawn.iter().enumerate() {
        let begin = Instant::now();
        let outcome = tree.test(package, mutant, timeout)?;
        let seconds = begin.elapsed().as_secs();
        println!(
            "{:>3}/{} {outcome:<8} {seconds:>4} s  {mutant}",
            number + 1,
            drawn.len()
        );
        outcomes.push((outcome, mutant));
    }
    report(
        package,
        &outcomes,
        all.len(),
        arguments.seed,
        start.elapsed(),
    );
    Ok(())
}

fn report(package: &str, outcomes: &[(&str, &&str)], of: usize, seed: u64, took: Duration) {
    let count = |name| {
        outcomes
            .iter()
            .filter(|(outcome, _)| *outcome == name)
            .count()
    };
    let counts = OUTCOMES.map(|name| format!("{} {name}", count(name)));
    let number = outcomes.len();
    println!(
        "{}: {number} of {of} mutants, seed {seed}: {}; {:.0} s each",
        package,
        counts.join(", "),
        took.as_secs_f64() / number.max(1) as f64,
    );
    for (outcome, mutant) in outcomes {
        if ["missed", "timeout"].contains(outcome) {
            println!("  {outcome} {mutant}");
        }
    }
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
    fn test(&self, package: &str, mutant: &str, timeout: Duration) -> anyhow::Result<&'static str> {
        let file = mutant.split(':').next().unwrap_or(mutant);
        let likeliest = namesakes(file);
        if !likeliest.is_empty() {
            let outcome = self.stage(package, mutant, timeout, &likeliest)?;
            if outcome != "missed" {
                return Ok(outcome);
            }
        }
        self.stage(package, mutant, timeout, &[])
    }

    /// Runs the suites of a package with a mistake, or these tests of them and what is in the sources.
    fn stage(
        &self,
        package: &str,
        mutant: &str,
        timeout: Duration,
        only: &[String],
    ) -> anyhow::Result<&'static str> {
        let mut mutants = self.mutants();
        mutants.args(["--in-place", "--baseline", "skip", "--package", package]);
        mutants.args(["--re", &format!("^{}$", literal(mutant))]);
        mutants.args(["--test-package", &SUITES.join(",")]);
        mutants.args(["--timeout", &timeout.as_secs().to_string()]);
        let results = self.folder.with_file_name("results");
        mutants.arg("--output").arg(&results);
        if !only.is_empty() {
            mutants.args(["--cargo-arg", "--lib"]);
            for test in only {
                mutants.args(["--cargo-arg", &format!("--test={test}")]);
            }
        }
        let status = mutants.stdout(Stdio::null()).status()?;
        let outcome = OUTCOMES.into_iter().find(|name| {
            let file = results.join("mutants.out").join(format!("{name}.txt"));
            std::fs::read_to_string(file).is_ok_and(|list| !list.is_empty())
        });
        outcome.with_context(|| {
            format!("cargo mutants gives no outcome for {mutant} ({status}): {mutants:?}")
        })
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

/// A pattern that matches this text only.
fn literal(text: &str) -> String {
    let mut pattern = String::new();
    for character in text.chars() {
        if r"\.+*?()|[]{}^$#&-~".contains(character) {
            pattern.push('\\');
        }
        pattern.push(character);
    }
    pattern
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
