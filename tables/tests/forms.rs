//! One table in the forms of many programs, and what could be read in two ways.

use tables::{Problem, Table};

/// Header and numbers.
type Read = (Vec<String>, Vec<Vec<f64>>);

/// Header and numbers of a text.
fn read(text: &str) -> Result<Read, (usize, Problem)> {
    let mut table = Table::of(text)?;
    let names = tables::names(table.format(), table.header.text);
    let names = names.into_iter().map(str::to_owned).collect();
    let mut rows = Vec::new();
    while let Some(line) = table.next() {
        let format = table.format();
        let cells = format.cells(line.text).map(|cell| format.finite(cell));
        let row: Result<Vec<f64>, _> = cells.collect();
        rows.push(row.map_err(|problem| (line.number, problem))?);
    }
    Ok((names, rows))
}

fn problem(text: &str) -> (usize, String) {
    let (line, problem) = read(text).expect_err(text);
    (line, problem.to_string())
}

#[test]
fn every_form_gives_the_same_names_and_numbers() {
    for text in [
        "a,b\n2.9,-0.001\n",
        "a;b\n2.9;-1e-3\n",
        "a;b\r\n2,9;-0,001\r\n",
        "a;b\n2,9;-1,0E-03",
        "a\tb\n2,9\t-0,001\n",
        "\u{feff}\"a\",\"b\"\n\"2.9\", \"-0.001\" \n",
        "\"a\",\"b\"\n\"2,9\",\"-0,001\"\n",
        " a , b \n\n 2.9 ,-0.001  \n,\n\r\n",
        "sep=;\r\na;b\r\n2,9;-0,001\r\n",
        "\"sep=\t\"\na\tb\n2.9\t-0.001\n",
    ] {
        let (names, rows) = read(text).unwrap_or_else(|error| panic!("{text:?}: {error:?}"));
        assert_eq!(names, ["a", "b"], "{text:?}");
        assert_eq!(rows, [[2.9, -0.001]], "{text:?}");
    }
}

#[test]
fn whole_numbers_before_the_first_decimal_leave_its_mark_open() {
    let (_, rows) = read("a;b\n0;0\n0;1\n0,5;1\n").unwrap();
    assert_eq!(rows[2], [0.5, 1.0]);
    let (_, rows) = read("a;b\n0;0\n0.5;1\n").unwrap();
    assert_eq!(rows[1], [0.5, 1.0]);
    // With semicolons a comma is a decimal comma, whatever follows: 1,234 is no thousand.
    assert_eq!(read("a;b\n1,234;0\n").unwrap().1, [[1.234, 0.0]]);
}

#[test]
fn the_mark_may_not_change_and_thousands_are_not_guessed() {
    let (line, said) = problem("a;b\n0,5;1\n\n0.5;1\n");
    assert_eq!(line, 4);
    assert!(said.contains("\"0.5\" has a decimal point"), "{said}");
    let (line, said) = problem("a;b\n0.5;1\n0,5;1\n");
    assert_eq!(line, 3);
    assert!(said.contains("\"0,5\" has a decimal comma"), "{said}");
    let (line, said) = problem("a,b\n\"1,234\",\"2,345\"\n");
    assert_eq!(line, 2);
    assert!(
        said.contains("\"1,234\" may be a decimal comma or"),
        "{said}"
    );
    // A number before it that can be nothing else decides.
    assert_eq!(read("a,b\n\"0,5\",\"1,234\"\n").unwrap().1, [[0.5, 1.234]]);
    for text in [
        "a;b\n1.234,5;1\n",
        "a,b\n\"1,234.5\",1\n",
        "a,b\n\"1,234,567\",1\n",
        "a;b\n;1\n",
        "a;b\n1e999;1\n",
    ] {
        assert!(read(text).is_err(), "{text:?}");
    }
    assert!(
        problem("a;b\tc\n1;2\t3\n")
            .1
            .contains("both tabs and semicolons")
    );
}

#[test]
fn a_header_is_compared_name_by_name() {
    let table = Table::of("a,b,,\n").unwrap();
    assert_eq!(tables::names(table.format(), table.header.text), ["a", "b"]);
    let said = |header: &str| {
        let table = Table::of(header).unwrap();
        tables::expect(table.format(), table.header.text, "a,b,c").map_err(|e| e.to_string())
    };
    for header in [
        "a,b,c\n",
        "\"a\";\"b\";\"c\";;\r\n",
        "a\t b\tc",
        "\n\na,b,c",
    ] {
        assert_eq!(said(header), Ok(()), "{header:?}");
    }
    assert!(
        said("1,2,3\n")
            .unwrap_err()
            .contains("put this line above the rows: a,b,c")
    );
    assert!(
        said("a,a,c")
            .unwrap_err()
            .contains("a twice, in columns 1 and 2")
    );
    assert!(
        said("a,b")
            .unwrap_err()
            .contains("column 3 of the header is \"\" and must be \"c\"")
    );
    assert!(
        said("a,b,c,d")
            .unwrap_err()
            .contains("column 4 of the header is \"d\"")
    );
    assert!(said("").unwrap_err().contains("column 1"));
}

#[test]
fn a_last_line_without_an_end_is_not_whole() {
    let lines: Vec<_> = Table::of("a\r\n1\r\n\r\n2").unwrap().collect();
    let seen: Vec<_> = lines
        .iter()
        .map(|line| (line.number, line.is_whole()))
        .collect();
    assert_eq!(seen, [(2, true), (4, false)]);
}
