//! Jack programs as spreadsheets save them.

use twin::program::Program;

const HEADER: &str = "time_s,jack1_m,jack2_m,jack3_m,jack4_m,jack5_m,jack6_m";

#[test]
fn a_jack_program_that_a_spreadsheet_saved_is_the_same_program() {
    let text = format!("{HEADER}\n0.000,0.1,-0.2,0,0,0,0\n0.002,0.1,-0.2,0.5,0,0,1e-3\n");
    let program = Program::parse(&text).unwrap();
    assert_eq!(program.rows()[1], [0.1, -0.2, 0.5, 0.0, 0.0, 0.001]);
    let european = text
        .replace(',', ";")
        .replace('.', ",")
        .replace('\n', "\r\n");
    assert_eq!(
        Program::parse(&format!("\u{feff}{european}\r\n;;;;;;\r\n")).unwrap(),
        program
    );
    assert_eq!(Program::parse(&text.replace(',', "\t")).unwrap(), program);
}

#[test]
fn a_program_without_its_header_is_refused_with_the_line_to_put_above() {
    let said = |text: &str| Program::parse(text).unwrap_err().to_string();
    let refused = said("0,0,0,0,0,0,0\n1,0,0,0,0,0,0\n");
    assert!(
        refused.contains("line 1: the header is missing"),
        "{refused}"
    );
    assert!(refused.contains(HEADER), "{refused}");
    let refused = said(&format!("{HEADER}\n0,0,0,0,0,0,0\n\n1,0,0,0,0,0\n"));
    assert!(
        refused.contains("line 4: 6 cells; there must be 7"),
        "{refused}"
    );
}
