//! The report: every figure of a [small campaign](small) whose numbers are written by hand, section by section; then the
//! report of a whole campaign on the twin: complete, well-formed, escaped, and small.

mod base;
mod board_sums;
mod budgets;
mod captions;
mod channels;
mod checks;
mod conditions;
mod curves;
mod evidence;
mod held_out;
mod margins;
mod motion;
mod page;
mod response;
mod small;

use std::path::PathBuf;
use std::sync::LazyLock;

use hexsense_probe::campaign::BoardRecord;
use hexsense_probe::report::{ReportInput, render};

use evidence::Evidence;
use page::{elements, in_caption, number, parsed, rows, words};

/// A name that becomes markup wherever it is not escaped.
const HOSTILE: &str = "<script>alert(\"1\")</script> & 'x' \u{1}";

/// One campaign serves all tests.
static EVIDENCE: LazyLock<Evidence> = LazyLock::new(|| Evidence::gather("an-74tk-200", 1));

#[test]
fn every_figure_and_table_of_the_method_is_there_and_nothing_is_loaded() {
    let html = render(&EVIDENCE.verified()).unwrap();
    assert!(html.len() < 1_000_000, "{} bytes", html.len());
    let document = parsed(&html);
    let captions: Vec<String> = elements(&document, "figcaption")
        .into_iter()
        .map(words)
        .collect();
    let shows = |what: &str| {
        assert!(
            captions.iter().any(|caption| caption.contains(what)),
            "{what}"
        )
    };
    for run in [
        "pitch",
        "roll",
        "heave",
        "roll-sine",
        "yaw-sine",
        "pitch-sine",
    ] {
        shows(&format!("Run {run}: displacement of the six jacks"));
        let rms = in_caption(
            &captions,
            &format!("Run {run}: displacement"),
            "jacks 1 to 6: ",
            " mm",
        );
        // The base follows to a few millimetres, and not exactly.
        assert!(
            rms.len() == 6 && rms.iter().all(|rms| (0.01..5.0).contains(rms)),
            "{run} {rms:?}"
        );
    }
    for run in ["heave", "roll-sine", "yaw-sine", "pitch-sine"] {
        shows(&format!("Run {run}: driven channels at 0.5"));
    }
    for triad in [
        "Linear acceleration",
        "Angular acceleration",
        "Angular rate",
    ] {
        shows(&format!("{triad} on the held-out movement"));
    }
    shows("Command and measured pose");
    let hold_error = in_caption(
        &captions,
        "Mean counts on the 10 holds",
        "differences: ax ",
        " mm/s²",
    );
    assert!((0.1..20.0).contains(&hold_error[0]), "{hold_error:?}");
    assert!(
        elements(&document, "svg")
            .iter()
            .all(|svg| elements_in(*svg, "path") > 10)
    );
    assert!(html.contains("Representative 6-3 layout"));
    for outside in ["<script", "<link", "src=", "@import", "url(", "http"] {
        assert!(!html.contains(outside), "{outside}");
    }
}

fn elements_in(node: roxmltree::Node, name: &str) -> usize {
    node.descendants()
        .filter(|node| node.has_tag_name(name))
        .count()
}

#[test]
fn the_boards_sums_alone_give_the_gains_to_half_a_percent() {
    let html = render(&EVIDENCE.verified()).unwrap();
    let document = parsed(&html);
    let runs = ["heave", "roll-sine", "yaw-sine", "pitch-sine"];
    let rows = runs.iter().flat_map(|run| rows(&document, run));
    let factors: Vec<_> = rows.filter(|row| row.len() == 8).collect();
    assert_eq!(factors.len(), 7, "{factors:?}");
    for row in factors {
        let (ratio, fitted) = (number(&row[4]), number(&row[5]));
        assert!((ratio / fitted - 1.0).abs() < 0.005, "{row:?}");
        assert!(
            (100.0 * (ratio / fitted - 1.0) - number(&row[6])).abs() < 0.02,
            "{row:?}"
        );
    }
}

#[test]
fn names_from_files_cannot_become_markup() {
    let mut campaign = EVIDENCE.campaign.clone();
    campaign.geometry.name = format!("name {HOSTILE}");
    campaign.geometry.note = format!("note {HOSTILE}");
    campaign.sensors.name = format!("sensors {HOSTILE}");
    campaign.folder = PathBuf::from("folder <b>&");
    let mut runs = EVIDENCE.runs.clone();
    let board = BoardRecord {
        board: format!("board {HOSTILE}"),
        hardware: format!("hardware {HOSTILE}"),
        firmware: format!("firmware {HOSTILE}"),
        wire: 1,
        facts: hexsense::FACTS,
        build: None,
    };
    let mut analysis = EVIDENCE.analysis.clone();
    analysis.condensed.heave.name = format!("run {HOSTILE}");
    let mut characterisation = EVIDENCE.characterisation.clone();
    characterisation.characteristics.frequency_response[0].freedom = format!("freedom {HOSTILE}");
    analysis.results.channels[0].budget[0].cause = format!("cause {HOSTILE}");
    runs.iter_mut()
        .filter(|run| run.name == "heave")
        .for_each(|run| run.name = format!("run {HOSTILE}"));
    let input = ReportInput {
        campaign: &campaign,
        board: &board,
        runs: &runs,
        analysis: &analysis,
        characterisation: &characterisation,
        ..EVIDENCE.verified()
    };
    let html = render(&input).unwrap();
    let document = parsed(&html);
    assert!(elements(&document, "script").is_empty());
    let all = words(document.root());
    let seen = HOSTILE.replace('\u{1}', "\u{fffd}");
    for what in [
        "name", "note", "sensors", "board", "hardware", "firmware", "run", "freedom", "cause",
    ] {
        assert!(
            all.to_lowercase().contains(&format!("{what} {seen}")),
            "{what}"
        );
    }
    assert!(all.contains("folder <b>&"));
}
