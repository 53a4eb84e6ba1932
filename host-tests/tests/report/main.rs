//! The report of a whole campaign on the twin: complete, well-formed, escaped, and small.

mod evidence;
mod page;

use std::path::PathBuf;
use std::sync::LazyLock;

use hexsense_probe::analysis::results::Term;
use hexsense_probe::campaign::BoardRecord;
use hexsense_probe::report::{ReportInput, Verified, render};

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
fn the_tables_hold_the_results() {
    let html = render(&EVIDENCE.verified()).unwrap();
    let document = parsed(&html);
    let channels = EVIDENCE.analysis.results.channels.iter();
    for (channel, verdict) in channels.zip(&EVIDENCE.verdicts) {
        let rows = rows(&document, &channel.name);
        let [result, verified, matrix] = rows.as_slice() else {
            panic!("{}: {rows:?}", channel.name)
        };
        assert!((number(&result[1]) - channel.offset.estimate).abs() <= 0.5);
        let power = 10f64.powf(channel.gain.estimate.log10().floor());
        let rounding = 0.06 * channel.gain.expanded_uncertainty;
        assert!((number(&result[3]) * power - channel.gain.estimate).abs() <= rounding);
        assert!((number(&result[7]) * channel.gain.estimate - 1.0).abs() <= 1e-3);
        for (column, element) in channel.cross.iter().enumerate() {
            let cell = number(&matrix[1 + 2 * column]) * power;
            assert!((cell - element.estimate).abs() <= 0.06 * element.expanded_uncertainty);
        }
        assert!((number(&verified[3]) / verdict.rms_error_after - 1.0).abs() < 0.006);
        assert_eq!(
            verified[7],
            if verdict.passes() { "passes" } else { "fails" }
        );
    }
}

#[test]
fn the_terms_of_every_budget_stand_largest_first() {
    let html = render(&EVIDENCE.verified()).unwrap();
    let document = parsed(&html);
    let tables = elements(&document, "table");
    for channel in &EVIDENCE.analysis.results.channels {
        type Part = fn(&Term) -> f64;
        let parts: [(&str, Part); 2] = [
            ("k, %", |term| term.gain_relative),
            ("u0, counts", |term| term.offset_counts),
        ];
        for (title, part) in parts {
            let head = format!("{}{title}", channel.name);
            let is_it =
                |table: &&roxmltree::Node| words(table.first_element_child().unwrap()) == head;
            let table = tables.iter().find(is_it).expect(&head);
            let rows = table.descendants().filter(|node| node.has_tag_name("td"));
            let shown: Vec<String> = rows.step_by(3).map(words).collect();
            let mut terms: Vec<&Term> = channel.budget.iter().collect();
            terms.retain(|term| part(term) > 0.0);
            terms.sort_by(|a, b| part(b).total_cmp(&part(a)));
            let causes: Vec<&str> = terms.iter().map(|term| term.cause.as_str()).collect();
            assert!(causes.len() > 2, "{head}: {causes:?}");
            assert_eq!(shown[..causes.len()], causes, "{head}");
        }
    }
}

#[test]
fn the_boards_poses_and_the_place_of_the_sensors_are_reported() {
    let html = render(&EVIDENCE.verified()).unwrap();
    let document = parsed(&html);
    assert!(html.contains("the point O to 0.25 µm and the attitude to 0.11 µrad, limits 0.5 µm"));
    let found = &EVIDENCE.analysis.results.lever_arm_m;
    for (axis, place) in ["X", "Y", "Z"].into_iter().zip(found) {
        let row = &rows(&document, axis)[0];
        assert!(
            (number(&row[3]) - 1e3 * place.estimate).abs() < 0.06,
            "{row:?}"
        );
        assert!(
            (number(&row[1]) - number(&row[3])).abs() <= number(&row[2]),
            "{row:?}"
        );
    }
}

#[test]
fn the_boards_sums_are_compared_and_a_changed_one_is_seen() {
    let html = render(&EVIDENCE.verified()).unwrap();
    let document = parsed(&html);
    let of_heave: Vec<_> = rows(&document, "heave")
        .into_iter()
        .filter(|row| row[1] == "ay")
        .collect();
    assert!(number(&of_heave[0][6]).abs() < 0.1, "{of_heave:?}");
    assert_eq!(html.matches(">identical<").count(), 4);
    let mut records = EVIDENCE.records.clone();
    let sums = records
        .iter_mut()
        .find_map(|record| record.board_sums.first_mut())
        .unwrap();
    sums.channels[14].sine[4] += 1;
    let html = render(&ReportInput {
        records: &records,
        ..EVIDENCE.verified()
    })
    .unwrap();
    assert_eq!(html.matches(">identical<").count(), 3);
    assert_eq!(html.matches(">different<").count(), 1);
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
fn the_verdict_is_open_then_passed_or_failed() {
    let head = |input: &ReportInput| {
        let html = render(input).unwrap();
        words(elements(&parsed(&html), "header")[0])
    };
    let open = head(&EVIDENCE.unverified());
    assert!(
        open.contains("not yet verified") && open.contains("hexsense verify"),
        "{open}"
    );
    assert!(head(&EVIDENCE.verified()).contains("All nine channels pass"));
    let mut verdicts = EVIDENCE.verdicts.clone();
    verdicts[4].rms_error_after = 0.031 * verdicts[4].rms_signal;
    let verified = Verified {
        verdicts: &verdicts,
        ..EVIDENCE.verified().verified.unwrap()
    };
    let failed = head(&ReportInput {
        verified: Some(verified),
        ..EVIDENCE.verified()
    });
    assert!(
        failed.contains("Does not pass") && failed.contains("fail: ey."),
        "{failed}"
    );
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
    };
    let mut analysis = EVIDENCE.analysis.clone();
    analysis.condensed.heave.name = format!("run {HOSTILE}");
    analysis.results.motion[0].freedom = format!("freedom {HOSTILE}");
    analysis.results.channels[0].budget[0].cause = format!("cause {HOSTILE}");
    runs.iter_mut()
        .filter(|run| run.name == "heave")
        .for_each(|run| run.name = format!("run {HOSTILE}"));
    let input = ReportInput {
        campaign: &campaign,
        board: &board,
        runs: &runs,
        analysis: &analysis,
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
