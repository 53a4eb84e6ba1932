use super::*;
use crate::geometry_file::GeometryFile;
use hexsense_core::channel::Ratiometric;
use hexsense_core::records::{JackCoefficients, MotionBase, TriadCoefficients};

fn sources() -> Sources {
    let digest = |digit: &str| digit.repeat(64);
    Sources {
        captures_sha256: digest("1"),
        programs_sha256: digest("2"),
        geometry_sha256: digest("3"),
        sensors_sha256: digest("4"),
    }
}

/// A set in which no two numbers are alike.
fn set() -> CoefficientSet {
    let triad = |size: f32| TriadCoefficients {
        offset: [32_768.1, 32_000.0 / 3.0, 40_000.7].map(|counts| counts + size),
        matrix: [
            [1.0 / 3.0, 1e-3, -1e-7],
            [0.1, 0.7, 0.2],
            [-0.01, 0.02, 1e-2],
        ]
        .map(|row| row.map(|gain| size * gain)),
        offset_uncertainty: [0.1, 0.2, 0.3].map(|counts| size * counts),
        matrix_uncertainty: [[1e-5, 2e-5, 3e-5], [4e-5, 5e-5, 6e-5], [7e-5, 8e-5, 9e-5]]
            .map(|row| row.map(|gain| size * gain)),
        delay_s: 0.001_23 * size,
    };
    CoefficientSet {
        board: *b"\x01board\xff\x00uid2",
        geometry: "an-74tk-200".try_into().unwrap(),
        geometry_hash: [7, 6, 5, 4, 3, 2, 1, 0],
        unix_s: 1_780_000_000,
        temperature_c: 31.7,
        provenance: sources().provenance(),
        ratiometric: Ratiometric::NONE.with(2).with(10),
        build: None,
        triads: [triad(1.0), triad(2.0), triad(3.0)],
        base: MotionBase::new(&GeometryFile::load("an-74tk-200").unwrap().geometry),
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_761.1, 32_762.2, 32_763.3, 32_764.4, 32_765.5, 32_766.6],
            metres_per_count: [1e-4, 2e-4, -3e-4, 4e-4, 5e-4, 6e-4].map(|metres| metres / 3.0),
        },
    }
}

#[test]
fn a_file_gives_the_very_same_bytes() {
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    assert!(text.contains("ratiometric = [\"az\", \"jack2\"]"), "{text}");
    let (mut before, mut after) = ([0; MAX_ENCODED], [0; MAX_ENCODED]);
    let (read, from) = parse("c.toml", &text).unwrap();
    assert_eq!(from, sources());
    assert_eq!(
        set().encode(&mut before).unwrap(),
        read.encode(&mut after).unwrap()
    );
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    for length in 0..text.trim_end().len() {
        let error = parse("c.toml", &text[..length]).expect_err("a cut file");
        assert!(error.to_string().starts_with("c.toml"), "{error}");
    }
}

#[test]
fn a_ratiometric_channel_that_does_not_exist_is_refused_by_its_name() {
    let text = to_text("c.toml", &set(), &sources())
        .unwrap()
        .replace("jack2", "jack7");
    let error = parse("c.toml", &text).unwrap_err().to_string();
    assert!(error.contains("ratiometric is jack7"), "{error}");
}

#[test]
fn a_changed_number_is_refused_by_the_identity() {
    let text = to_text("c.toml", &set(), &sources())
        .unwrap()
        .replace("40001.7", "40001.8");
    assert!(matches!(
        parse("c.toml", &text),
        Err(CoefficientFileError::Identity { .. })
    ));
}

/// The file of [`set`] with one piece of its text in place of another.
fn changed(from: &str, to: &str) -> String {
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    assert_eq!(text.matches(from).count(), 1, "{from} in {text}");
    text.replace(from, to)
}

fn problem(text: &str) -> String {
    parse("c.toml", text).unwrap_err().to_string()
}

#[test]
fn every_number_is_part_of_the_identity() {
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    let mut numbers = 0;
    for (line, words) in text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.contains('"'))
    {
        let first_digits = words.match_indices(|c: char| c.is_ascii_digit());
        let first_digits = first_digits.filter(|(at, _)| {
            let before = words[..*at].strip_suffix('-').unwrap_or(&words[..*at]);
            before.ends_with(' ') || before.ends_with('[')
        });
        for (at, digit) in first_digits {
            let mut other: Vec<String> = text.lines().map(|line| line.to_owned() + "\n").collect();
            other[line].replace_range(at..=at, if digit == "9" { "4" } else { "9" });
            let error = parse("c.toml", &other.concat()).unwrap_err();
            let refused = matches!(
                error,
                CoefficientFileError::Identity { .. } | CoefficientFileError::Record { .. }
            );
            assert!(refused, "{error}");
            numbers += 1;
        }
    }
    // 25 numbers of each triad, 36 of the hinges, 3 lengths, 13 of the jacks, and the temperature.
    assert_eq!(numbers, 3 * 25 + 36 + 3 + 13 + 1);
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_what_they_belong_to() {
    for bad in ["nan", "inf", "-inf", "1e39"] {
        let triad = problem(&changed("40002.7", bad));
        assert!(
            triad.starts_with("c.toml: AngularAcceleration holds"),
            "{triad}"
        );
        let jack = problem(&changed("32763.3", bad));
        assert!(
            jack.starts_with("c.toml: the transducer of jack 3"),
            "{jack}"
        );
        let degrees = problem(&changed("31.7", bad));
        assert!(degrees.starts_with("c.toml: the temperature"), "{degrees}");
    }
}

#[test]
fn values_that_no_board_streams_are_refused_by_table_row_and_channel() {
    // 65535 counts at the largest supply, 1.1, are 72088.5 at nominal supply. So the counts of the angular accelerations
    // are 39318.4, 61419.8 and 40002.7 from their offsets at most; row 2 of the matrix is 0.2, 1.4, 0.4 per count.
    type Spoil = fn(&mut CoefficientSet);
    let spoilt: [(Spoil, &str); 4] = [
        (
            |set| {
                set.triads[1].matrix = set.triads[1].matrix.map(|row| row.map(|gain| 10.0 * gain))
            },
            "row 2 of the matrix in [angular_acceleration], ey can reach 1.1e6",
        ),
        (
            |set| {
                set.triads[1].matrix = set.triads[1].matrix.map(|row| row.map(|gain| 1e32 * gain))
            },
            "row 2 of the matrix in [angular_acceleration], ey can reach 1.1e37",
        ),
        (
            |set| set.triads[2].offset[2] = 3e38,
            "row 3 of the matrix in [angular_rate], wz can reach 3.0e38",
        ),
        (
            |set| set.triads[0].offset[0] = -1e6,
            "row 1 of the matrix in [linear_acceleration], ax can reach 1.0e6",
        ),
    ];
    for (spoil, named) in spoilt {
        let mut set = set();
        spoil(&mut set);
        let said = to_text("c.toml", &set, &sources()).unwrap_err().to_string();
        assert!(
            said.contains(named) && said.contains("below 1e6"),
            "{named}: {said}"
        );
        assert!(
            said.starts_with("c.toml: with the offset_counts and "),
            "{said}"
        );
    }
    let said = problem(&changed("40003.7", "3e38"));
    assert!(said.contains("wz can reach 3.0e38"), "{said}");
}

#[test]
fn identities_have_all_their_digits_and_names_at_most_thirty_two_bytes() {
    for (key, digits) in [
        ("board", "01626f617264ff0075696432"),
        ("geometry_hash", "0706050403020100"),
        ("provenance_sha256", &files::hex(&sources().provenance())),
    ] {
        let line = |digits: &str| format!("{key} = \"{digits}\"");
        let as_it_is = line(digits);
        let shorter = &digits[1..];
        for bad in [shorter, &format!("0{digits}"), &format!("{shorter}g"), ""] {
            let said = problem(&changed(&as_it_is, &line(bad)));
            let expected = format!("c.toml: {key} is ");
            assert!(said.starts_with(&expected), "{said}");
            let count = format!("it must have {} hexadecimal digits", digits.len());
            assert!(said.ends_with(&count), "{said}");
        }
    }
    let named = |bytes: usize| {
        let name = format!("geometry = \"{}\"", "n".repeat(bytes));
        problem(&changed("geometry = \"an-74tk-200\"", &name))
    };
    assert!(
        named(32).contains("its numbers are not those of that set"),
        "{}",
        named(32)
    );
    assert!(
        named(33).contains("too long for a coefficient set"),
        "{}",
        named(33)
    );
}

#[test]
fn an_older_file_is_refused_with_the_way_to_a_new_one() {
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    // Version 1 had neither base nor jacks, and version 2 no sources.
    for (version, (old, _)) in [
        (1, text.split_once("[base]").unwrap()),
        (2, text.split_once("[sources]").unwrap()),
    ] {
        let old = old.replace("version 3", &format!("version {version}"));
        let said = parse("c.toml", &old).unwrap_err().to_string();
        for words in [
            &format!("format is \"hexsense coefficients, version {version}\""),
            "do not name all that they were found from",
            "hexsense calibrate",
        ] {
            assert!(said.contains(words), "{said}");
        }
        assert!(!said.contains("cut off"), "{said}");
    }
}

#[test]
fn a_refused_file_does_not_tell_the_identity_that_would_make_it_pass() {
    let mut edited = set();
    edited.triads[0].offset[2] += 0.1;
    let its_own = identity("", &edited).unwrap();
    let text = changed("40001.7", &edited.triads[0].offset[2].to_string());
    let said = problem(&text);
    assert!(said.contains("changed or damaged"), "{said}");
    assert!(!said.contains(&its_own), "{said}");
    // It is the one: with it the edit would pass.
    let stated = identity("", &set()).unwrap();
    parse("c.toml", &text.replace(&stated, &its_own)).unwrap();
}

#[test]
fn every_digest_of_the_sources_is_part_of_the_provenance() {
    for digit in ["1", "2", "3", "4"] {
        let other = format!("9{}", digit.repeat(63));
        let said = problem(&changed(&digit.repeat(64), &other));
        assert!(
            said.contains("the table sources is not that of set"),
            "{said}"
        );
    }
    let text = to_text("c.toml", &set(), &sources()).unwrap();
    let (without, _) = text.split_once("[sources]").unwrap();
    assert!(problem(without).contains("the table sources is not that of set"));
}
