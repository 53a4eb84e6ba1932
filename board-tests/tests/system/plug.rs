//! The plug is pulled in runs and in an upload: the host tool reports it in time, no file and no set is half written, the
//! campaign goes on by itself or from its folder, and the upload can be repeated.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use board_tests::folders;
use board_tests::power;
use board_tests::process::{Beside, checked};
use board_tests::virtual_bench::VirtualBench;

use crate::bench;
use crate::told::{self, Told};

/// A campaign takes less, on two busy cores.
const CAMPAIGN_TAKES: Duration = Duration::from_secs(180);

#[test]
#[ignore = "needs the built programs"]
fn plug_pulled_in_runs_and_in_an_upload() -> anyhow::Result<()> {
    let folder = folders::emptied("system/plug")?;
    let bench = bench(&folder);
    let twin = bench.twin()?;
    bench.papers()?;
    pulled_in_runs(&bench, &twin).context("the plug pulled in a run")?;
    pulled_in_an_upload(&bench, &twin).context("the plug pulled in an upload")
}

/// When the board stays away, the host tool reports it at once or after the time that the user gave, and the campaign goes
/// on from its folder. When the board comes back, the campaign goes on by itself.
fn pulled_in_runs(bench: &VirtualBench, twin: &Beside) -> anyhow::Result<()> {
    let captures = bench.campaign().join("captures");
    let board = bench.board(twin)?;
    let mut calibrate = bench.drive("calibrate", &board, twin, 0)?;
    let calibrate = Told::start(calibrate.args(["--board-wait", "0"]))?;
    wait_for(&captures.join("pitch.json"))?;
    drop(board);
    calibrate.must_explain("starting again goes on")?;

    let board = bench.board(twin)?;
    let mut resume = bench.resume(&board, twin)?;
    let resume = Told::start(resume.args(["--board-wait", "2"]))?;
    wait_for(&captures.join("roll.json"))?;
    drop(board);
    resume.must_explain("starting again goes on")?;

    let board = bench.board(twin)?;
    let link = board.address("link")?.to_owned();
    let mut resume = Told::start(&mut bench.resume(&board, twin)?)?;
    wait_for(&captures.join("heave.json"))?;
    drop(board);
    resume.says("waiting 60 s for the board to come back")?;
    let board = bench.board_on(twin, Some(&link))?;
    resume.says("is recorded again from its start")?;
    resume.must_succeed(CAMPAIGN_TAKES)?;
    ensure!(bench.coefficients().exists(), "no coefficients were made");
    ensure!(
        bench.active_id(&board).is_err(),
        "a set is active that was never uploaded"
    );
    Ok(())
}

/// The old set or the new one is active, and the upload can be repeated.
fn pulled_in_an_upload(bench: &VirtualBench, twin: &Beside) -> anyhow::Result<()> {
    let board = bench.board(twin)?;
    bench.provision(&board)?;
    let flash = bench.folder.join(power::FLASH);
    let before = std::fs::read(&flash)?;
    let upload = Told::start(&mut bench.upload(&board)?)?;
    let start = Instant::now();
    while std::fs::read(&flash)? == before {
        ensure!(
            start.elapsed() < told::WITHIN,
            "the upload never reached the flash"
        );
    }
    drop(board);
    upload.ended(told::WITHIN)?;
    let board = bench.board(twin)?;
    checked(&mut bench.upload(&board)?)?;
    bench.active_id(&board).map(drop)
}

fn wait_for(file: &Path) -> anyhow::Result<()> {
    let start = Instant::now();
    while !file.exists() {
        ensure!(
            start.elapsed() < Duration::from_secs(60),
            "{} never came",
            file.display()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}
