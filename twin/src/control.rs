//! Requests to the motion controller: one line of JSON in, one line out. No line contains a part of the truth.
//!
//! `{"run":{"name":"pitch","program":"/path/pitch.csv"}}` or `{"stop":true}`; the answer is `{"ok":true}` or
//! `{"ok":false,"error":"what, value, limit"}`.

use std::ops::DerefMut;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::bench::Bench;
use crate::controller::Refusal;
use crate::program::{Program, ProgramError};
use crate::truth_log::TruthLog;

/// The bench on which requests act, and the log of one run.
#[derive(Debug)]
pub struct Twin {
    /// The bench.
    pub bench: Bench,
    /// The truth of one run; `None` without a log.
    pub truth_log: Option<TruthLog>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum Request {
    Run(Run),
    Stop(bool),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Run {
    name: String,
    program: PathBuf,
}

#[derive(Serialize)]
struct Answer {
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// Why a request was not carried out.
#[derive(Debug, Error)]
enum RequestError {
    #[error(
        "not a request ({0}); send {{\"run\":{{\"name\":…,\"program\":…}}}} or {{\"stop\":true}}"
    )]
    Syntax(#[from] serde_json::Error),
    #[error("stop: false; send true")]
    StopFalse,
    #[error(transparent)]
    Program(#[from] ProgramError),
    #[error("{program}: {source}", program = program.display())]
    Refused { program: PathBuf, source: Refusal },
    #[error("truth log: {0}")]
    TruthLog(#[from] std::io::Error),
}

/// Carries out the request in one line and answers with a line. `twin` is called after the request has been parsed and
/// its file read.
pub fn answer<T: DerefMut<Target = Twin>>(line: &[u8], twin: impl FnOnce() -> T) -> String {
    let error = perform(line, twin).err().map(|error| error.to_string());
    let answer = Answer {
        ok: error.is_none(),
        error,
    };
    // A struct of a bool and a string is always valid JSON.
    serde_json::to_string(&answer).unwrap_or_default() + "\n"
}

fn perform<T: DerefMut<Target = Twin>>(
    line: &[u8],
    twin: impl FnOnce() -> T,
) -> Result<(), RequestError> {
    match serde_json::from_slice(line)? {
        Request::Stop(false) => Err(RequestError::StopFalse),
        Request::Stop(true) => {
            twin().bench.stop();
            Ok(())
        }
        Request::Run(Run { name, program }) => {
            let loaded = Program::load(&program)?;
            let mut twin = twin();
            twin.bench
                .run(&name, loaded)
                .map_err(|source| RequestError::Refused { program, source })?;
            match &mut twin.truth_log {
                Some(log) => Ok(log.run_commanded(&name)?),
                None => Ok(()),
            }
        }
    }
}
