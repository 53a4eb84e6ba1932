//! The report of a whole campaign on the twin: complete, well-formed, escaped, and small.

use std::path::PathBuf;
use std::sync::LazyLock;

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::Analyser;
use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase};
use hexsense_core::sampling::{BLOCK, BlockSize, BlockSums, Calibrator};
use hexsense_core::wire::Drive;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::held_out::{HeldOut, compare, held_out};
use hexsense_probe::analysis::results::{Analysis, Term, analyse};
use hexsense_probe::campaign::{
    BoardPoses, BoardRecord, BoardSums, Campaign, RunRecord, Verification,
};
use hexsense_probe::characteristics::Characterisation;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::{self, Purpose};
use hexsense_probe::report::{ReportInput, Verified, render};
use hexsense_probe::sensor_file::SensorFile;
use host_tests::bench::{Laboratory, Movement, RATE_HZ};

/// A name that becomes markup wherever it is not escaped.
const HOSTILE: &str = "<script>alert(\"1\")</script> & 'x' \u{1}";

/// Everything that a verified campaign leaves behind.
struct Evidence {
    campaign: Campaign,
    board: BoardRecord,
    set: CoefficientSet,
    runs: Vec<RecordedRun>,
    records: Vec<RunRecord>,
    analysis: Analysis,
    held_out_run: RecordedRun,
    curves: HeldOut,
    verification: Verification,
    characterisation: Characterisation,
}

impl Evidence {
    fn gather(geometry: &str, seed: u64) -> Self {
        let geometry = GeometryFile::load(geometry).unwrap();
        let sensors = SensorFile::parse("papers", &twin::papers::sensor_file(seed)).unwrap();
        let plan = plan::campaign::plan(&geometry).unwrap();
        let mut laboratory = Laboratory::new(seed, &geometry);
        let mut record = |run: &plan::Run| {
            laboratory.record(&Movement::new(
                &run.name,
                run.program(),
                run.rest_s,
                &geometry,
            ))
        };
        let runs: Vec<RecordedRun> = plan.runs_to(Purpose::Calibrate).map(&mut record).collect();
        let mut held_out_run = record(plan.run("held-out").unwrap());
        let analysis = analyse(&geometry, &sensors, &runs).unwrap();
        let characterisation = Characterisation::new(&geometry, &sensors, &runs).unwrap();
        let set = set(&geometry, &analysis);
        let calibrator = Calibrator::new(&set);
        let capture = &mut held_out_run.capture;
        let scans = capture.counts.iter().zip(&capture.supply);
        capture.values = Some(
            scans
                .map(|(scan, supply)| calibrator.apply(scan, *supply))
                .collect(),
        );
        let results = &analysis.results;
        let curves = held_out(&geometry, &sensors, &held_out_run, results).unwrap();
        let channels = compare(
            &curves.reference,
            &curves.after,
            &curves.before,
            results,
            200.0,
        );
        let records = runs
            .iter()
            .chain([&held_out_run])
            .map(|run| run_record(run, &analysis))
            .collect();
        let board = BoardRecord {
            board: "01626f617264ff0075696432".to_owned(),
            hardware: "NUCLEO-G474RE, STM32G474RE".to_owned(),
            firmware: "0.1.0".to_owned(),
            wire: 1,
        };
        let campaign = Campaign {
            folder: PathBuf::from("campaign"),
            plan,
            geometry,
            sensors,
        };
        Self {
            campaign,
            board,
            set,
            runs,
            records,
            analysis,
            held_out_run,
            curves,
            verification: Verification {
                board_pose: BoardPoses {
                    poses: 1886,
                    largest_m: 2.46e-7,
                    largest_rad: 1.14e-7,
                    limit: 5e-7,
                },
                channels,
            },
            characterisation,
        }
    }

    fn unverified(&self) -> ReportInput<'_> {
        ReportInput {
            campaign: &self.campaign,
            board: &self.board,
            set: &self.set,
            runs: &self.runs,
            records: &self.records,
            analysis: &self.analysis,
            characterisation: &self.characterisation,
            verified: None,
        }
    }

    fn verified(&self) -> ReportInput<'_> {
        let verified = Verified {
            run: &self.held_out_run,
            curves: &self.curves,
            verification: &self.verification,
        };
        ReportInput {
            verified: Some(verified),
            ..self.unverified()
        }
    }
}

fn set(geometry: &GeometryFile, analysis: &Analysis) -> CoefficientSet {
    CoefficientSet {
        board: *b"\x01board\xff\x00uid2",
        geometry: geometry.name.as_str().try_into().unwrap(),
        geometry_hash: *geometry.hash.first_chunk().unwrap(),
        unix_s: 1_780_000_000,
        temperature_c: 27.2,
        provenance: [0xa5; 32],
        triads: analysis.triads,
        base: MotionBase::new(&geometry.geometry),
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_768.0; 6],
            metres_per_count: [2e-5; 6],
        },
    }
}

/// A record as the host writes it, with the sums that a board would have kept over the estimate.
fn run_record(run: &RecordedRun, analysis: &Analysis) -> RunRecord {
    let condensed = &analysis.condensed;
    let mut sweeps = condensed.turns.iter().chain([&condensed.heave]);
    let sweep = sweeps.find(|sweep| sweep.name == run.name);
    let board_sums = sweep.into_iter().map(|sweep| {
        let first = (sweep.first - 100) / BLOCK * BLOCK;
        let drive = Drive {
            increment: (sweep.sine.frequency_hz / f64::from(RATE_HZ) * 2f64.powi(64)) as u64,
            block: BlockSize::default(),
            settle_blocks: (first / BLOCK) as u32,
            blocks: (sweep.length_s * f64::from(RATE_HZ) / BLOCK as f64) as u32,
        };
        let mut analyser = Analyser::new();
        analyser.start(drive);
        let blocks = run.capture.counts.as_chunks::<BLOCK>().0.iter();
        for (block, first_scan) in blocks.zip(run.capture.scans.iter().step_by(BLOCK)) {
            analyser.take(&BlockSums::of_scans(block, *first_scan));
        }
        let report = |channel| analyser.report(channel).unwrap();
        let channels: [_; CHANNELS] = std::array::from_fn(|channel| report(channel).2);
        BoardSums {
            drive,
            first_scan: report(0).1,
            channels,
        }
    });
    RunRecord {
        run: run.name.clone(),
        program_sha256: "5e".repeat(32),
        rate_hz: RATE_HZ,
        onset_scan: None,
        scans: run.capture.scans.len() as u64,
        scans_lost: 0,
        block: BlockSize::default(),
        set: None,
        board_sums: board_sums.collect(),
    }
}

/// The report as XML, which it is too; panics where it is not well-formed.
fn parsed(html: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(html, options).unwrap_or_else(|error| panic!("{error}"))
}

fn elements<'a>(document: &'a roxmltree::Document, name: &'a str) -> Vec<roxmltree::Node<'a, 'a>> {
    document
        .descendants()
        .filter(|node| node.has_tag_name(name))
        .collect()
}

fn words(node: roxmltree::Node) -> String {
    node.descendants()
        .filter(|node| node.is_text())
        .filter_map(|node| node.text())
        .collect()
}

/// One campaign serves all tests.
static EVIDENCE: LazyLock<Evidence> = LazyLock::new(|| Evidence::gather("an-74tk-200", 1));

/// Cells of all rows that begin with `name`, table by table.
fn rows(document: &roxmltree::Document, name: &str) -> Vec<Vec<String>> {
    let rows = elements(document, "tr").into_iter().map(|row| {
        row.children()
            .filter(|cell| cell.has_tag_name("td"))
            .map(words)
            .collect::<Vec<_>>()
    });
    rows.filter(|cells| cells.first().is_some_and(|first| first == name))
        .collect()
}

fn number(cell: &str) -> f64 {
    let plain: String = cell.chars().filter(|c| !c.is_whitespace()).collect();
    plain
        .replace('−', "-")
        .parse()
        .unwrap_or_else(|_| panic!("{cell:?} is no number"))
}

/// The numbers between `before` and `after` in the caption that begins with `start`.
fn in_caption(captions: &[String], start: &str, before: &str, after: &str) -> Vec<f64> {
    let caption = captions
        .iter()
        .find(|caption| caption.contains(start))
        .expect(start);
    let part = caption
        .split_once(before)
        .expect(before)
        .1
        .split_once(after)
        .expect(after)
        .0;
    part.split(',').map(number).collect()
}

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
    for (channel, verdict) in channels.zip(&EVIDENCE.verification.channels) {
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
    let mut verification = EVIDENCE.verification.clone();
    let verdict = &mut verification.channels[4];
    verdict.rms_error_after = 0.031 * verdict.rms_signal;
    let verified = Verified {
        verification: &verification,
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
