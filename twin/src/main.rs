//! Command line of the twin.

use std::io::Write;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::{Args, Parser, Subcommand};
use serde::Serialize;
use twin::bench::Bench;
use twin::geometry::Geometry;
use twin::serve::Twin;
use twin::truth_log::TruthLog;
use twin::{papers, serve, truth};

/// A simulated six-degree-of-freedom motion base with nine inertial sensors on its cockpit.
///
/// The seed decides everything about it that a laboratory would not know. The same seed always gives the same base.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Args)]
struct Which {
    /// Seed from which the truth is drawn
    #[arg(long)]
    seed: u64,
    /// Geometry of the base: the name of a preset (such as an-74tk-200) or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    geometry: String,
}

#[derive(Subcommand)]
enum Command {
    /// Print the true offset and gain of each channel: value = M (u - u0), u in counts at 3.300 V
    Truth {
        #[command(flatten)]
        which: Which,
        /// Print one JSON document instead of a table
        #[arg(long)]
        json: bool,
    },
    /// Write the sensor file that a laboratory would have: data-sheet values and tolerances
    Papers {
        #[command(flatten)]
        which: Which,
        /// The file to write (TOML)
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Serve the base to a board (pins) and a host (control) until killed
    ///
    /// Prints {"pins":"HOST:PORT","control":"HOST:PORT"} when ready. Time advances only while a board asks for
    /// voltages; a board may leave and come back, as after a power cut.
    Serve {
        #[command(flatten)]
        which: Which,
        /// Address on which the board's pins are served; port 0 takes a free one
        #[arg(long, value_name = "HOST:PORT")]
        pins: String,
        /// Address on which the motion controller takes requests; port 0 takes a free one
        #[arg(long, value_name = "HOST:PORT")]
        control: String,
        /// Write the truth of one run to this CSV file, at 500 Hz
        #[arg(long, value_name = "FILE", requires = "truth_run")]
        truth_log: Option<PathBuf>,
        /// Name of that run
        #[arg(long, value_name = "NAME", requires = "truth_log")]
        truth_run: Option<String>,
    },
}

/// Where the twin listens.
#[derive(Serialize)]
struct Ready {
    pins: SocketAddr,
    control: SocketAddr,
}

fn main() -> ExitCode {
    match perform(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("twin: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn perform(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Truth { which, json } => {
            let geometry = Geometry::load(&which.geometry)?;
            let document = truth::Document::new(which.seed, &geometry.name);
            let text = if json {
                serde_json::to_string(&document)? + "\n"
            } else {
                document.table()
            };
            Ok(std::io::stdout().write_all(text.as_bytes())?)
        }
        Command::Papers { which, out } => {
            Geometry::load(&which.geometry)?;
            std::fs::write(&out, papers::sensor_file(which.seed))
                .with_context(|| format!("cannot write {}", out.display()))
        }
        Command::Serve {
            which,
            pins,
            control,
            truth_log,
            truth_run,
        } => {
            let geometry = Geometry::load(&which.geometry)?;
            let bench = Bench::with_geometry(which.seed, &geometry)?;
            let (pins, control) = (listen("pins", &pins)?, listen("control", &control)?);
            let truth_log = truth_log
                .zip(truth_run)
                .map(|(path, run)| open_log(&path, &run))
                .transpose()?;
            announce(&pins, &control)?;
            Ok(serve::serve(&pins, control, Twin { bench, truth_log })?)
        }
    }
}

fn listen(option: &str, address: &str) -> anyhow::Result<TcpListener> {
    TcpListener::bind(address).with_context(|| format!("--{option} {address}: cannot listen there"))
}

fn open_log(path: &Path, run: &str) -> anyhow::Result<TruthLog> {
    TruthLog::create(path, run).with_context(|| format!("cannot write {}", path.display()))
}

fn announce(pins: &TcpListener, control: &TcpListener) -> anyhow::Result<()> {
    let ready = Ready {
        pins: pins.local_addr()?,
        control: control.local_addr()?,
    };
    let mut stdout = std::io::stdout();
    writeln!(stdout, "{}", serde_json::to_string(&ready)?)?;
    Ok(stdout.flush()?)
}
