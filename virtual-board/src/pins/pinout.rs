//! The inputs of the converters: those on pins of the package (data sheet DS12288, table "STM32G474xB/xC/xE pin
//! definition", LQFP64), and those inside of the chip (RM0440, table "ADC interconnection").

use std::fmt;

/// A pin by port (0 is A) and number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Pin {
    /// 0 to 6: port A to G.
    pub port: u8,
    /// 0 to 15.
    pub number: u8,
}

impl Pin {
    /// Parses a name such as `PB12`.
    pub fn parse(name: &str) -> Option<Self> {
        let mut characters = name.strip_prefix('P')?.chars();
        let port = characters
            .next()
            .filter(|port| ('A'..='G').contains(port))?;
        let number: u8 = characters
            .as_str()
            .parse()
            .ok()
            .filter(|number| *number < 16)?;
        Some(Self {
            port: port as u8 - b'A',
            number,
        })
    }
}

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{}{}", char::from(b'A' + self.port), self.number)
    }
}

/// The connection of a converter's input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// A pin of the package.
    Pin(Pin),
    /// The temperature sensor.
    Temperature,
    /// A third of the backup supply.
    BackupThird,
    /// The internal reference.
    Reference,
    /// An operational amplifier or a pin that this package lacks.
    Unconnected,
}

const fn pin(port: char, number: u8) -> Input {
    Input::Pin(Pin {
        port: port as u8 - b'A',
        number,
    })
}

/// Input `channel` of converter `adc` (0 is ADC1).
pub fn input(adc: usize, channel: u8) -> Input {
    match (adc, channel) {
        (0 | 1, 1) => pin('A', 0),
        (0 | 1, 2) => pin('A', 1),
        (0, 3) => pin('A', 2),
        (0, 4) => pin('A', 3),
        (0, 5) => pin('B', 14),
        (1, 3) => pin('A', 6),
        (1, 4) => pin('A', 7),
        (1, 5) => pin('C', 4),
        (0 | 1, 6) => pin('C', 0),
        (0 | 1, 7) => pin('C', 1),
        (0 | 1, 8) => pin('C', 2),
        (0 | 1, 9) => pin('C', 3),
        (0, 10) => pin('F', 0),
        (1, 10) => pin('F', 1),
        (0, 11) => pin('B', 12),
        (1, 11) => pin('C', 5),
        (0, 12) => pin('B', 1),
        (1, 12) => pin('B', 2),
        (1, 13) => pin('A', 5),
        (0 | 1, 14) => pin('B', 11),
        (0, 15) => pin('B', 0),
        (1, 15) => pin('B', 15),
        (1, 17) => pin('A', 4),
        (2, 1) => pin('B', 1),
        (2, 5) => pin('B', 13),
        (2, 12) => pin('B', 0),
        (3, 3) => pin('B', 12),
        (3, 4) => pin('B', 14),
        (3, 5) => pin('B', 15),
        (4, 1) => pin('A', 8),
        (4, 2) => pin('A', 9),
        (0, 16) | (4, 4) => Input::Temperature,
        (0 | 2 | 4, 17) => Input::BackupThird,
        (0 | 2 | 3 | 4, 18) => Input::Reference,
        _ => Input::Unconnected,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_package() {
        assert_eq!(
            Pin::parse("PB12"),
            Some(Pin {
                port: 1,
                number: 12
            })
        );
        assert_eq!(Pin::parse("PB12").unwrap().to_string(), "PB12");
        for wrong in ["", "P", "B12", "PB16", "PH1", "PB-1", "PB1x"] {
            assert_eq!(Pin::parse(wrong), None, "{wrong}");
        }
    }
}
