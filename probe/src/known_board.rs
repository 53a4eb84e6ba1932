//! The board that hexsense assumes where it cannot ask one: in a plan before the first connection, and in a campaign that
//! was recorded before boards sent their facts (wire version 4 and older).
//!
//! A board that answers overrides all of it: its facts are noted in `board.json` of the campaign.

use hexsense_core::facts::{BoardFacts, FlashLayout};

/// The facts of the NUCLEO-G474RE with this release's firmware.
pub const FACTS: BoardFacts = BoardFacts {
    rates_hz: [1_000, 2_000, 4_000],
    rank_ns: 25_600,
    counts_at_supply: 65_536,
    nominal_supply_v: 3.3,
    baud: 2_000_000,
    flash: FlashLayout {
        page_bytes: 2_048,
        pages: 128,
    },
};

/// [`FACTS`], where a file gives none.
#[must_use]
pub fn facts() -> BoardFacts {
    FACTS
}
