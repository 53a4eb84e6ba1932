//! Columns of tables: what a name in a header means, and in which unit the numbers under it are.
//!
//! A name says the quantity, and behind it the unit: `x_mm`, `roll_deg`, `x [mm]`, `roll (deg)`. Without a unit the
//! numbers are in metres and radians. Capitals and small letters are the same. Numbers come out in metres and radians,
//! and inside limits that a number in another unit exceeds.

use std::f64::consts::PI;

/// No motion base is larger, m.
pub const MAX_LENGTH_M: f64 = 100.0;
/// π, and what rounding to three decimals adds to it.
const MAX_ANGLE_RAD: f64 = PI + 1e-3;

/// What the numbers of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A position or a length.
    Length,
    /// An angle.
    Angle,
}

/// A column that a table must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Its name, without a unit.
    pub name: &'static str,
    /// What its numbers are.
    pub quantity: Quantity,
}

/// A unit that a name can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Metre,
    Millimetre,
    Radian,
    Degree,
}

/// A wanted column as a table has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// Its place in a row, from 0.
    pub place: usize,
    column: Column,
    unit: Unit,
}

impl Column {
    /// A column of lengths.
    #[must_use]
    pub const fn length(name: &'static str) -> Self {
        let quantity = Quantity::Length;
        Self { name, quantity }
    }

    /// A column of angles.
    #[must_use]
    pub const fn angle(name: &'static str) -> Self {
        let quantity = Quantity::Angle;
        Self { name, quantity }
    }

    /// The column at a place of a table without a header, in metres or radians.
    #[must_use]
    pub fn at(self, place: usize) -> Found {
        let unit = self.quantity.si();
        Found {
            place,
            column: self,
            unit,
        }
    }

    /// Its name in a header that is printed: with the unit, metre or radian.
    #[must_use]
    pub fn printed(self) -> String {
        format!("{}_{}", self.name, self.quantity.si().symbol())
    }

    /// What `cell` of a header says of this column: nothing, its unit, or a unit that is none.
    fn unit_in(self, cell: &str) -> Option<Result<Unit, String>> {
        let cell = cell.trim().to_lowercase();
        let rest = cell.strip_prefix(self.name)?.trim();
        let unit = match rest.chars().next() {
            None => return Some(Ok(self.quantity.si())),
            Some('_') => &rest[1..],
            Some('[') => rest[1..].strip_suffix(']')?,
            Some('(') => rest[1..].strip_suffix(')')?,
            Some(_) => return None,
        };
        let unit = unit.trim();
        let units = self.quantity.units();
        let known = units.into_iter().find(|known| known.is_called(unit));
        Some(known.ok_or_else(|| cell.clone()))
    }
}

/// Finds the `wanted` columns among the cells of a header.
///
/// # Errors
/// In words: a column that is missing, in a unit that is not known, or there twice.
pub fn find<const N: usize>(header: &[&str], wanted: &[Column; N]) -> Result<[Found; N], String> {
    let mut found = wanted.map(|column| column.at(0));
    for found in &mut found {
        *found = find_one(header, found.column, wanted)?;
    }
    Ok(found)
}

fn find_one(header: &[&str], column: Column, all: &[Column]) -> Result<Found, String> {
    let name = column.name;
    let mut found: Option<Found> = None;
    let mut strange = None;
    for (place, cell) in header.iter().enumerate() {
        match column.unit_in(cell) {
            None => {}
            Some(Err(cell)) => strange = Some(cell),
            Some(Ok(unit)) => {
                if let Some(first) = found {
                    let (first, second) = (first.place + 1, place + 1);
                    return Err(format!(
                        "the header has {name} twice, as column {first} and column {second}; keep one of them"
                    ));
                }
                found = Some(Found {
                    place,
                    column,
                    unit,
                });
            }
        }
    }
    let [si, other] = column.quantity.units().map(Unit::symbol);
    match (found, strange) {
        (Some(found), _) => Ok(found),
        (None, Some(cell)) => Err(format!(
            "the header has {cell:?}, whose unit is not known; give {name}_{si} or {name}_{other}"
        )),
        (None, None) => {
            let all: Vec<&str> = all.iter().map(|column| column.name).collect();
            Err(format!(
                "the header has no {name}; it must have {}, with or without a unit ({name}_{si}, {name}_{other})",
                all.join(",")
            ))
        }
    }
}

impl Found {
    /// A number of this column in metres or radians.
    ///
    /// # Errors
    /// In words: a number outside what a motion base can have, with the unit that it may be in.
    pub fn si(self, number: f64) -> Result<f64, String> {
        let value = self.unit.si(number);
        let (limit, limit_text) = match self.column.quantity {
            Quantity::Length => (MAX_LENGTH_M, "100 m"),
            Quantity::Angle => (MAX_ANGLE_RAD, "π rad (180°)"),
        };
        if value.abs() <= limit {
            return Ok(value);
        }
        let (name, symbol) = (self.column.name, self.unit.symbol());
        let hint = match self.unit {
            Unit::Metre => {
                format!("; if it is in millimetres, name its column {name}_mm in the header")
            }
            Unit::Radian => {
                format!("; if it is in degrees, name its column {name}_deg in the header")
            }
            Unit::Millimetre | Unit::Degree => String::new(),
        };
        Err(format!(
            "{name} is {number:?} {symbol}, beyond ±{limit_text}{hint}"
        ))
    }
}

impl Quantity {
    fn si(self) -> Unit {
        self.units()[0]
    }

    /// The units of this quantity, that of the SI first.
    fn units(self) -> [Unit; 2] {
        match self {
            Self::Length => [Unit::Metre, Unit::Millimetre],
            Self::Angle => [Unit::Radian, Unit::Degree],
        }
    }
}

impl Unit {
    fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Millimetre => "mm",
            Self::Radian => "rad",
            Self::Degree => "deg",
        }
    }

    fn is_called(self, text: &str) -> bool {
        text == self.symbol() || (self == Self::Degree && text == "°")
    }

    fn si(self, number: f64) -> f64 {
        match self {
            Self::Metre | Self::Radian => number,
            Self::Millimetre => number / 1000.0,
            Self::Degree => number.to_radians(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: [Column; 2] = [Column::length("x"), Column::angle("roll")];

    fn places(header: &[&str]) -> Result<[usize; 2], String> {
        Ok(find(header, &WANTED)?.map(|found| found.place))
    }

    #[test]
    fn names_are_found_with_and_without_their_units() {
        for header in [
            ["note", "roll", "x"],
            ["x_residual", "roll_deg", "x_mm"],
            ["rolling", "Roll (deg)", "X [mm]"],
            ["", "roll[°]", "x_m"],
        ] {
            assert_eq!(places(&header), Ok([2, 1]), "{header:?}");
        }
    }

    #[test]
    fn numbers_come_out_in_metres_and_radians() {
        let [x, roll] = find(&["x_mm", "roll_deg"], &WANTED).unwrap();
        assert_eq!(x.si(1900.0), Ok(1.9));
        assert_eq!(roll.si(180.0), Ok(PI));
        let [x, roll] = find(&["x", "roll_rad"], &WANTED).unwrap();
        assert_eq!(x.si(1.9), Ok(1.9));
        let rounded_up = PI + 5e-4;
        assert_eq!(roll.si(-rounded_up), Ok(-rounded_up));
    }

    #[test]
    fn a_number_in_another_unit_is_refused_with_the_name_that_is_right() {
        let [x, roll] = WANTED.map(|column| column.at(0));
        let far = x.si(1900.0).unwrap_err();
        assert!(far.contains("x is 1900.0 m, beyond ±100 m") && far.contains("x_mm"));
        let wide = roll.si(-10.0).unwrap_err();
        assert!(wide.contains("roll is -10.0 rad, beyond ±π rad") && wide.contains("roll_deg"));
        let [_, roll] = find(&["x", "roll_deg"], &WANTED).unwrap();
        let wide = roll.si(190.0).unwrap_err();
        assert_eq!(wide, "roll is 190.0 deg, beyond ±π rad (180°)");
    }

    #[test]
    fn a_header_that_leaves_a_doubt_is_refused() {
        for (header, expected) in [
            (["x", "pitch"], "no roll"),
            (["x_mm", "x"], "x twice, as column 1 and column 2"),
            (
                ["x_inch", "roll"],
                "\"x_inch\", whose unit is not known; give x_m or x_mm",
            ),
        ] {
            let said = places(&header).unwrap_err();
            assert!(said.contains(expected), "{said}");
        }
    }
}
