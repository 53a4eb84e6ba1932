//! Numbers as people read them: no more digits than their uncertainty allows, decimal points below each other.
//!
//! An uncertainty is given with two significant digits and its value with as many decimals (GUM 7.2.6). A column is
//! set flush right; [`align`] fills short fractions with figure spaces, which are as wide as a digit, so that the
//! points of a column stand below each other.

/// Most decimals that are ever written: beyond them a number is written with the wrong unit.
const MAX_DECIMALS: usize = 12;
const FIGURE_SPACE: char = '\u{2007}';
/// As wide as a decimal point.
const PUNCTUATION_SPACE: char = '\u{2008}';
const MINUS: &str = "\u{2212}";

/// `value` with this many decimals and a true minus sign.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "not finite".to_owned();
    }
    let digits = format!("{:.*}", decimals.min(MAX_DECIMALS), value.abs());
    let negative = value < 0.0 && digits.bytes().any(|byte| matches!(byte, b'1'..=b'9'));
    format!("{}{digits}", if negative { MINUS } else { "" })
}

/// `value` with this many significant digits, never in powers of ten.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    fixed(value, decimals(value, digits))
}

/// A value and its uncertainty: two significant digits of the uncertainty, as many decimals in the value. A value
/// without uncertainty has six significant digits and an empty one.
#[must_use]
pub fn rounded(value: f64, uncertainty: f64) -> [String; 2] {
    if uncertainty > 0.0 && uncertainty.is_finite() {
        let decimals = decimals(uncertainty, 2);
        [fixed(value, decimals), fixed(uncertainty, decimals)]
    } else {
        [significant(value, 6), String::new()]
    }
}

/// Decimals that show the leading `digits` of `value`.
fn decimals(value: f64, digits: usize) -> usize {
    if value == 0.0 || !value.is_finite() {
        return digits.saturating_sub(1);
    }
    // Rounding first: 0.0996 with two digits is 0.10.
    let written = format!("{:.*e}", digits.saturating_sub(1), value);
    let exponent: i32 = written
        .rsplit('e')
        .next()
        .and_then(|exponent| exponent.parse().ok())
        .unwrap_or(0);
    (digits as i32 - 1 - exponent).clamp(0, MAX_DECIMALS as i32) as usize
}

/// Fills the fractions of a column, so that flush right its decimal points stand below each other.
pub fn align(column: &mut [String]) {
    let fraction = |cell: &String| cell.rfind('.').map_or(0, |point| cell.len() - point);
    let longest = column.iter().map(fraction).max().unwrap_or(0);
    for cell in column.iter_mut() {
        let own = fraction(cell);
        if own == 0 && longest > 0 {
            cell.push(PUNCTUATION_SPACE);
        }
        let digits = longest.saturating_sub(own.max(1));
        cell.extend(std::iter::repeat_n(FIGURE_SPACE, digits));
    }
}

/// The exponent of ten in which a group of values reads best: the largest has one digit before its point.
#[must_use]
pub fn common_exponent(values: impl IntoIterator<Item = f64>) -> i32 {
    let largest = values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold(0.0, |largest: f64, value| largest.max(value.abs()));
    if largest > 0.0 {
        largest.log10().floor() as i32
    } else {
        0
    }
}

/// 10 to a power, with the exponent as superscript digits.
#[must_use]
pub fn power_of_ten(exponent: i32) -> String {
    let superscript = |digit: char| match digit {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => char::from_u32('⁴' as u32 + other as u32 - '4' as u32).unwrap_or(other),
    };
    format!(
        "10{}",
        exponent
            .to_string()
            .chars()
            .map(superscript)
            .collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_as_many_decimals_as_two_digits_of_its_uncertainty() {
        assert_eq!(rounded(6.54321, 0.0123), ["6.543", "0.012"]);
        assert_eq!(rounded(-6.54321, 0.0996), ["−6.54", "0.10"]);
        assert_eq!(rounded(32_768.4, 123.4), ["32768", "123"]);
        assert_eq!(rounded(1.0, 0.0), ["1.00000", ""]);
        assert_eq!(rounded(1.0, f64::NAN), ["1.00000", ""]);
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-0.0006, 3), "−0.001");
        assert_eq!(fixed(f64::NAN, 3), "not finite");
    }

    #[test]
    fn points_of_a_column_stand_below_each_other() {
        let mut column = ["6.543", "12.5", "7"].map(str::to_owned);
        align(&mut column);
        let after = |cell: &String| {
            cell.chars()
                .rev()
                .position(|c| c == '.' || c == PUNCTUATION_SPACE)
        };
        assert!(
            column.iter().all(|cell| after(cell) == Some(3)),
            "{column:?}"
        );
    }

    #[test]
    fn powers_are_written_with_superscripts() {
        assert_eq!(power_of_ten(common_exponent([6.5e-4, -1e-5])), "10⁻⁴");
        assert_eq!(power_of_ten(-1098), "10⁻¹⁰⁹⁸");
        assert_eq!(power_of_ten(57), "10⁵⁷");
    }
}
