//! `cargo xtask size`: the flash and static RAM of the firmware, module by module, against the budget.
//!
//! A symbol belongs to the first path in its name: a crate, and in the firmware and the core the room in it. Where the
//! compiler has put one function into another, its bytes count with that other; the body of each task is under
//! `embassy_executor`. Bytes without a symbol, such as texts and padding, stand in a line of their own.
//!
//! ```text
//! flash = vectors + code + constants + initial values     RAM = initialised + zeroed + kept over a reset, no stack
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, ensure};
use object::elf::SHF_ALLOC;
use object::read::elf::ElfFile32;
use object::read::elf::SectionHeader;
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionKind};
use rustc_demangle::demangle;
use serde::Serialize;

use crate::figures::Figures;
use crate::programs::Program;

/// Most bytes of flash that the firmware may take: half of bank 1, so that two images can share it.
const FLASH_BUDGET: u64 = 131_072;
/// Most bytes of static RAM that it may take, the stack not included.
const RAM_BUDGET: u64 = 28_672;
/// First address of RAM; flash lies below.
const RAM_BASE: u64 = 0x2000_0000;
const UNNAMED: &str = "(no symbol)";
/// The crates that are grouped by their rooms: the firmware and the portable core.
const OWN: [&str; 2] = ["firmware", "hexsense_core"];

/// Bytes of a module, or of all.
#[derive(Debug, Default, Clone, Copy, Serialize)]
struct Bytes {
    flash: u64,
    ram: u64,
}

/// What the firmware takes.
#[derive(Debug, Serialize)]
pub struct Size {
    modules: BTreeMap<String, Bytes>,
    total: Bytes,
    budget: Bytes,
}

/// Reads the firmware's ELF.
pub fn measure() -> anyhow::Result<Size> {
    read(&Program::Firmware.path()?)
}

fn read(path: &Path) -> anyhow::Result<Size> {
    let file = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let elf = ElfFile32::<Endianness>::parse(file.as_slice())?;
    let mut total = Bytes::default();
    for section in elf.sections() {
        let flags = section.elf_section_header().sh_flags(Endianness::Little);
        if flags & SHF_ALLOC != SHF_ALLOC {
            continue;
        }
        let in_ram = section.address() >= RAM_BASE;
        let stored = section.kind() != SectionKind::UninitializedData;
        total.ram += if in_ram { section.size() } else { 0 };
        total.flash += if stored { section.size() } else { 0 };
    }
    let mut modules = modules(&elf);
    let named = modules
        .values()
        .fold(Bytes::default(), |sum, module| Bytes {
            flash: sum.flash + module.flash,
            ram: sum.ram + module.ram,
        });
    let rest = Bytes {
        flash: total.flash.saturating_sub(named.flash),
        ram: total.ram.saturating_sub(named.ram),
    };
    modules.insert(UNNAMED.to_owned(), rest);
    Ok(Size {
        modules,
        total,
        budget: Bytes {
            flash: FLASH_BUDGET,
            ram: RAM_BUDGET,
        },
    })
}

/// Bytes of all symbols by module. Of symbols at one address, such as functions found to be the same, one counts.
fn modules(elf: &ElfFile32) -> BTreeMap<String, Bytes> {
    let mut at = BTreeMap::new();
    for symbol in elf.symbols().filter(|symbol| symbol.size() > 0) {
        let section = symbol
            .section_index()
            .and_then(|index| elf.section_by_index(index).ok());
        if let (Some(section), Ok(name)) = (section, symbol.name())
            && section.address() > 0
        {
            let stored = section.kind() != SectionKind::UninitializedData;
            at.insert(symbol.address() & !1, (name, symbol.size(), stored));
        }
    }
    let mut modules = BTreeMap::<String, Bytes>::new();
    for (address, (name, size, stored)) in at {
        let module = modules
            .entry(module(&format!("{:#}", demangle(name))))
            .or_default();
        module.ram += if address >= RAM_BASE { size } else { 0 };
        module.flash += if stored { size } else { 0 };
    }
    modules
}

/// Crate of the first path in a demangled name, and the room when the crate is ours.
fn module(name: &str) -> String {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let starts = name.char_indices().filter(|(at, c)| {
        (c.is_ascii_lowercase() || *c == '_')
            && !name[..*at].ends_with(|c: char| word(c) || c == ':')
    });
    for (at, _) in starts {
        let path: Vec<_> = name[at..]
            .split(|c: char| !word(c) && c != ':')
            .next()
            .unwrap_or_default()
            .split("::")
            .collect();
        let [of, room, ..] = path.as_slice() else {
            continue;
        };
        return if OWN.contains(of) {
            format!("{of}::{room}")
        } else {
            (*of).to_owned()
        };
    }
    if name.starts_with('.') {
        UNNAMED.to_owned()
    } else {
        "(interrupts, runtime)".to_owned()
    }
}

impl Figures for Size {
    fn print_table(&self) {
        let row =
            |name: &str, bytes: &Bytes| println!("{:>8} {:>8}  {name}", bytes.flash, bytes.ram);
        println!("{:>8} {:>8}  module", "flash", "RAM");
        let mut modules: Vec<_> = self.modules.iter().collect();
        modules.sort_by_key(|(_, bytes)| std::cmp::Reverse(bytes.flash + bytes.ram));
        for (name, bytes) in modules {
            row(name, bytes);
        }
        row("total", &self.total);
        row("budget", &self.budget);
    }

    fn check(&self) -> anyhow::Result<()> {
        within("flash", self.total.flash, self.budget.flash)?;
        within("static RAM", self.total.ram, self.budget.ram)
    }
}

fn within(what: &str, used: u64, budget: u64) -> anyhow::Result<()> {
    ensure!(
        used <= budget,
        "the firmware takes {used} bytes of {what}, the budget is {budget}: make it smaller; `cargo xtask size` shows \
         which module takes how much"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_go_to_the_first_path_in_their_name() {
        for (name, expected) in [
            ("hexsense_core::wire::frame::encode", "hexsense_core::wire"),
            ("firmware::pose::find::POOL", "firmware::pose"),
            ("firmware::link::receive::RING", "firmware::link"),
            (
                "<hexsense_core::records::record::SetId as core::fmt::Debug>::fmt",
                "hexsense_core::records",
            ),
            ("<&T as core::fmt::Debug>::fmt", "core"),
            ("_SEGGER_RTT", "(interrupts, runtime)"),
            (".Lanon.d417acc7.136", UNNAMED),
        ] {
            assert_eq!(module(name), expected, "{name}");
        }
    }

    #[test]
    fn a_byte_over_the_budget_is_refused() {
        assert!(within("flash", 1_000, 1_000).is_ok());
        let refused = within("flash", 1_001, 1_000).unwrap_err().to_string();
        assert!(refused.contains("1001 bytes of flash, the budget is 1000"));
    }
}
