//! A command of `hexsense`, with the time and the memory that it takes.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::programs::Program;

/// Every command ends within this time.
pub const MOST_TIME: Duration = Duration::from_secs(60);
/// How often a command is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// How a command ended.
pub struct Ended {
    /// Its status; `None` when it was killed.
    pub code: Option<i32>,
    /// What it printed, to standard output and then to standard error.
    pub said: String,
    /// How long it took.
    pub took: Duration,
    /// The most memory that it had, KiB; 0 where the system does not tell.
    pub peak_kib: u64,
}

/// Where standard output goes.
pub enum Output {
    /// Into a file that is read afterwards.
    Kept,
    /// To a reader that closes its end at once.
    Closed,
    /// To this device.
    To(&'static str),
}

/// A command that is to be run.
pub struct Hexsense<'a> {
    folder: &'a Path,
    arguments: Vec<String>,
    /// Where its standard output goes.
    pub output: Output,
}

impl<'a> Hexsense<'a> {
    /// With these arguments, in `folder`.
    pub fn new(folder: &'a Path, arguments: &[&str]) -> Self {
        Self {
            folder,
            arguments: arguments.iter().map(ToString::to_string).collect(),
            output: Output::Kept,
        }
    }

    /// Runs it to its end.
    pub fn run(&self) -> anyhow::Result<Ended> {
        let [out, err] = ["stdout", "stderr"].map(|name| self.folder.join(name));
        let mut command = Command::new(Program::HostTool.path()?);
        command.args(&self.arguments).current_dir(self.folder);
        command.stdin(Stdio::null()).stderr(File::create(&err)?);
        match self.output {
            Output::Kept => command.stdout(File::create(&out)?),
            Output::Closed => command.stdout(Stdio::piped()),
            Output::To(device) => command.stdout(File::options().write(true).open(device)?),
        };
        let start = Instant::now();
        let mut child = command.spawn()?;
        drop(child.stdout.take());
        let mut peak_kib = 0;
        let code = loop {
            peak_kib = peak_kib.max(memory_kib(&child));
            if let Some(status) = child.try_wait()? {
                break status.code();
            }
            if start.elapsed() > MOST_TIME {
                child.kill()?;
            }
            std::thread::sleep(LOOK);
        };
        let read = |path: &Path| fs::read(path).unwrap_or_default();
        let said = [read(&out), read(&err)].concat();
        Ok(Ended {
            code,
            said: String::from_utf8_lossy(&said).into_owned(),
            took: start.elapsed(),
            peak_kib,
        })
    }
}

/// The most memory that a process has had so far, KiB.
fn memory_kib(child: &Child) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id()));
    let status = status.unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}
