//! `cargo xtask size`: what the firmware takes of flash and static RAM, module by module, against its budget.
//!
//! A symbol belongs to the first path in its name: a crate, and for our own code the room in it. Where the compiler has
//! put one function into another, its bytes count with that other; the body of each task is under
//! `embassy_executor`. What no symbol covers, such as text and padding, stands in a line of its own.
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

use crate::build::{self, Parts};
use crate::process::checked;
use crate::setup;

/// What the firmware is meant to take at most, bytes.
const FLASH_TARGET: u64 = 64 * 1024;
/// What it is meant to have of RAM besides the stack, bytes.
const RAM_TARGET: u64 = 16 * 1024;
/// Bytes of flash and RAM at the last time that growth was accepted. Raised on purpose only.
const FLASH_BUDGET: u64 = 123_684;
/// See [`FLASH_BUDGET`].
const RAM_BUDGET: u64 = 26_392;
/// Growth over the budget that passes, percent.
const GROWTH_PERCENT: u64 = 5;
/// First address of RAM; flash lies below.
const RAM_BASE: u64 = 0x2000_0000;
const UNNAMED: &str = "(no symbol)";
const OWN: [&str; 2] = ["hexsense", "firmware"];

/// `cargo xtask size`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Bytes of a module, or of all.
#[derive(Debug, Default, Clone, Copy, Serialize)]
struct Bytes {
    flash: u64,
    ram: u64,
}

#[derive(Debug, Serialize)]
struct Figures {
    modules: BTreeMap<String, Bytes>,
    total: Bytes,
    budget: Bytes,
    target: Bytes,
}

/// Builds the firmware and prints its figures; fails when they are over budget.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let figures = measure()?;
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&figures)?);
    } else {
        print_table(&figures);
    }
    figures.check()
}

/// Fails when the firmware is over budget.
pub fn check() -> anyhow::Result<()> {
    measure()?.check()
}

fn measure() -> anyhow::Result<Figures> {
    setup::board_target()?;
    checked(&mut build::firmware("build"))?;
    read(&Parts::find()?.firmware)
}

fn read(path: &Path) -> anyhow::Result<Figures> {
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
    Ok(Figures {
        modules,
        total,
        budget: Bytes {
            flash: FLASH_BUDGET,
            ram: RAM_BUDGET,
        },
        target: Bytes {
            flash: FLASH_TARGET,
            ram: RAM_TARGET,
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
        let [of, room, rest @ ..] = path.as_slice() else {
            continue;
        };
        return match rest.first() {
            _ if !OWN.contains(of) => (*of).to_owned(),
            Some(inner) if *room == "board" => format!("{of}::{room}::{inner}"),
            _ => format!("{of}::{room}"),
        };
    }
    if name.starts_with('.') {
        UNNAMED.to_owned()
    } else {
        "(interrupts, runtime)".to_owned()
    }
}

impl Figures {
    fn check(&self) -> anyhow::Result<()> {
        let Self {
            total,
            budget,
            target,
            ..
        } = self;
        within("flash", total.flash, budget.flash, target.flash)?;
        within("RAM", total.ram, budget.ram, target.ram)
    }
}

fn within(what: &str, used: u64, budget: u64, target: u64) -> anyhow::Result<()> {
    let limit = budget + budget * GROWTH_PERCENT / 100;
    ensure!(
        used <= limit,
        "the firmware takes {used} bytes of {what}, more than {GROWTH_PERCENT} % over the budget of {budget}: make it \
         smaller, or raise the budget in xtask/src/size.rs on purpose"
    );
    ensure!(
        used <= target || budget > target,
        "the firmware takes {used} bytes of {what}, over the target of {target}"
    );
    Ok(())
}

fn print_table(figures: &Figures) {
    let row = |name: &str, bytes: &Bytes| println!("{:>8} {:>8}  {name}", bytes.flash, bytes.ram);
    println!("{:>8} {:>8}  module", "flash", "RAM");
    let mut modules: Vec<_> = figures.modules.iter().collect();
    modules.sort_by_key(|(_, bytes)| std::cmp::Reverse(bytes.flash + bytes.ram));
    for (name, bytes) in modules {
        row(name, bytes);
    }
    row("total", &figures.total);
    row("budget", &figures.budget);
    row("target", &figures.target);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_go_to_the_first_path_in_their_name() {
        for (name, expected) in [
            ("hexsense_core::wire::frame::encode", "hexsense_core::wire"),
            ("firmware::board::pose::find::POOL", "firmware::board::pose"),
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
    fn growth_over_five_percent_and_over_the_target_fails() {
        assert!(within("flash", 1_050, 1_000, 2_000).is_ok());
        assert!(within("flash", 1_051, 1_000, 2_000).is_err());
        assert!(within("flash", 2_001, 2_000, 2_000).is_err());
        assert!(within("flash", 2_090, 2_000, 1_000).is_ok());
    }
}
