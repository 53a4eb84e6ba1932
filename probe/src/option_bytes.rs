//! The option bytes of the board's chip, in words and in JSON. A debug probe sets them, and the firmware only reads them.

use hexsense_core::wire::status::OptionBytes;
use serde_json::{Value, json};

/// Names of the areas that can be protected from writing, in the board's order.
const AREAS: [&str; 4] = ["WRP1A", "WRP1B", "WRP2A", "WRP2B"];

/// Levels of the supply below which the chip resets, V (data sheet DS12288).
const BROWN_OUT_V: [f32; 5] = [1.7, 2.0, 2.2, 2.5, 2.8];

/// All of them, and what to do where they keep the board from taking changes.
#[must_use]
pub fn text(bytes: &OptionBytes) -> String {
    let OptionBytes {
        readout_protection,
        brown_out_level,
        ..
    } = *bytes;
    let banks = if bytes.dual_bank {
        "two banks of flash"
    } else {
        "a SINGLE bank of flash"
    };
    let brown_out = BROWN_OUT_V.get(usize::from(brown_out_level));
    let brown_out = brown_out.map_or(String::new(), |volt| format!(" ({volt:.1} V)"));
    format!(
        "{banks}, readout protection level {readout_protection}, {}, brown-out level {brown_out_level}{brown_out}{}",
        protection(bytes),
        remedy(bytes)
    )
}

fn protection(bytes: &OptionBytes) -> String {
    let areas: Vec<String> = areas(bytes)
        .map(|(name, first, last)| format!("{name} pages {first} to {last}"))
        .collect();
    match areas.is_empty() {
        true => "no page protected from writing".to_owned(),
        false => format!("protected from writing: {}", areas.join(", ")),
    }
}

/// Name, first and last page of each area that is protected.
fn areas(bytes: &OptionBytes) -> impl Iterator<Item = (&'static str, u8, u8)> {
    let protected = AREAS.into_iter().zip(bytes.write_protected);
    protected.filter_map(|(name, pages)| pages.map(|(first, last)| (name, first, last)))
}

/// What to do where the board takes no changes.
fn remedy(bytes: &OptionBytes) -> &'static str {
    if !bytes.dual_bank {
        "; the board measures and takes NO CHANGES, because they would erase its firmware: set the option byte DBANK to 1 with STM32CubeProgrammer (STM32_Programmer_CLI -c port=SWD -ob DBANK=1), then flash the firmware again"
    } else if !bytes.allow_changes() {
        "; the board measures and takes NO CHANGES, because pages of bank 2 are protected: remove WRP2A and WRP2B with STM32CubeProgrammer"
    } else {
        ""
    }
}

/// All of them.
#[must_use]
pub fn to_json(bytes: &OptionBytes) -> Value {
    let protected = areas(bytes)
        .map(|(area, first, last)| json!({"area": area, "first_page": first, "last_page": last}));
    json!({
        "dual_bank": bytes.dual_bank,
        "readout_protection": bytes.readout_protection,
        "brown_out_level": bytes.brown_out_level,
        "write_protected": protected.collect::<Vec<_>>(),
        "changes_allowed": bytes.allow_changes(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_from_the_factory_has_nothing_to_do() {
        assert_eq!(
            text(&OptionBytes::FACTORY),
            "two banks of flash, readout protection level 0, no page protected from writing, brown-out level 0 (1.7 V)"
        );
    }

    #[test]
    fn a_single_bank_says_what_it_prevents_and_what_to_do() {
        let text = text(&OptionBytes {
            dual_bank: false,
            readout_protection: 1,
            brown_out_level: 4,
            ..OptionBytes::FACTORY
        });
        assert!(
            text.starts_with("a SINGLE bank of flash, readout protection level 1, "),
            "{text}"
        );
        for part in [
            "level 4 (2.8 V)",
            "NO CHANGES",
            "-ob DBANK=1",
            "flash the firmware again",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn protected_pages_are_named_and_only_those_of_bank_2_prevent_changes() {
        let mut bytes = OptionBytes::FACTORY;
        bytes.write_protected[0] = Some((3, 61));
        let code = text(&bytes);
        assert!(
            code.contains("protected from writing: WRP1A pages 3 to 61,"),
            "{code}"
        );
        assert!(!code.contains("NO CHANGES"), "{code}");
        bytes.write_protected[3] = Some((0, 9));
        let stored = text(&bytes);
        assert!(
            stored.contains("WRP1A pages 3 to 61, WRP2B pages 0 to 9"),
            "{stored}"
        );
        assert!(stored.contains("remove WRP2A and WRP2B"), "{stored}");
    }
}
