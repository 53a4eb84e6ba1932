//! No instruction of the sample path takes a time that depends on its operands: this is read in the ELF, not in the source.
//!
//! From the firmware's sample interrupt and the functions of the portable path on, every function that is reached by a
//! branch or call is read, instruction by instruction. Divisions, square roots, calls of software arithmetic, jumps
//! through a pointer and ways into a panic are refused. (That no *branch* depends on data is counted: see [`crate::timing`].)

mod thumb;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, bail};
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SymbolKind};
use rustc_demangle::demangle;

use self::thumb::Effect;
use crate::programs::Program;
use crate::sample_path;

/// The vector in which the firmware has its sample path, first instruction to last.
const SAMPLE_INTERRUPT: &str = "DMA1_CHANNEL1";

/// Reads the sample path of the program that has it for every size of block, and the firmware's interrupt.
pub fn check() -> anyhow::Result<()> {
    let symbols = sample_path::symbols();
    let portable = check_reached(&Program::SamplePathBench.path()?, &symbols)?;
    let whole = check_reached(&Program::Firmware.path()?, &[SAMPLE_INTERRUPT.to_owned()])?;
    println!(
        "{portable} functions of the portable path and {whole} of the firmware's interrupt have a fixed time"
    );
    Ok(())
}

/// Reads all functions that can be reached from `names` and fails with the list of what must not be there; returns how
/// many functions it read.
fn check_reached(elf: &Path, names: &[String]) -> anyhow::Result<usize> {
    let file = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let program = Code::read(&file).with_context(|| format!("in {}", elf.display()))?;
    let mut waiting = names
        .iter()
        .map(|name| program.called(name))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let mut read = BTreeSet::new();
    let mut refused = Vec::new();
    while let Some(start) = waiting.pop() {
        if read.insert(start) {
            program.judge(start, &mut waiting, &mut refused)?;
        }
    }
    if !refused.is_empty() {
        bail!("{}: {}", elf.display(), refused.join("; "));
    }
    Ok(read.len())
}

struct Function {
    name: String,
    end: u32,
}

/// Functions by their first address, and the code around them.
struct Code<'a> {
    functions: BTreeMap<u32, Function>,
    /// From each of these addresses on there is code, or data between code (`$t` and `$d`, ELF for the Arm
    /// Architecture, mapping symbols).
    is_code: BTreeMap<u32, bool>,
    sections: Vec<(u32, &'a [u8])>,
}

impl<'a> Code<'a> {
    fn read(file: &'a [u8]) -> anyhow::Result<Self> {
        let elf = ElfFile32::<Endianness>::parse(file)?;
        let mut this = Self {
            functions: BTreeMap::new(),
            is_code: BTreeMap::new(),
            sections: Vec::new(),
        };
        for section in elf.sections() {
            this.sections
                .push((section.address() as u32, section.data().unwrap_or_default()));
        }
        for symbol in elf.symbols() {
            let (Ok(name), address) = (symbol.name(), symbol.address() as u32) else {
                continue;
            };
            if name.starts_with("$t") || name.starts_with("$d") {
                this.is_code.insert(address, name.starts_with("$t"));
            } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                let function = Function {
                    name: format!("{:#}", demangle(name)),
                    end: (address & !1) + symbol.size() as u32,
                };
                this.functions.insert(address & !1, function);
            }
        }
        Ok(this)
    }

    fn called(&self, name: &str) -> anyhow::Result<u32> {
        let mut found = self
            .functions
            .iter()
            .filter(|(_, function)| function.name == name);
        let (start, _) = found
            .next()
            .with_context(|| format!("there is no function {name}"))?;
        Ok(*start)
    }

    /// Reads one function: what it calls goes to `calls`, what must not be there to `refused`.
    fn judge(
        &self,
        start: u32,
        calls: &mut Vec<u32>,
        refused: &mut Vec<String>,
    ) -> anyhow::Result<()> {
        let function = &self.functions[&start];
        if let Some(reason) = forbidden(&function.name) {
            refused.push(format!("{} ({reason}) can be reached", function.name));
            return Ok(());
        }
        let mut address = start;
        while address < function.end {
            if !self.is_code_at(address) {
                address += 2;
                continue;
            }
            let (length, effect) = self.instruction(address)?;
            match effect {
                Effect::Plain => {}
                Effect::Branch(to) if (start..function.end).contains(&to) => {}
                Effect::Branch(to) => calls.push(self.around(to).with_context(|| {
                    format!("{} goes to {to:#x}, where no function is", function.name)
                })?),
                Effect::ThroughPointer => {
                    refused.push(format!(
                        "{} jumps through a pointer at {address:#x}",
                        function.name
                    ));
                }
                Effect::Slow(what) => {
                    refused.push(format!("{} has a {what} at {address:#x}", function.name));
                }
            }
            address += length;
        }
        Ok(())
    }

    fn is_code_at(&self, address: u32) -> bool {
        let last = self.is_code.range(..=address).next_back();
        last.is_none_or(|(_, is_code)| *is_code)
    }

    /// First address of the function that `address` lies in.
    fn around(&self, address: u32) -> Option<u32> {
        let (start, function) = self.functions.range(..=address).next_back()?;
        (address < function.end).then_some(*start)
    }

    fn instruction(&self, address: u32) -> anyhow::Result<(u32, Effect)> {
        let first = self.half_word(address)?;
        if thumb::is_wide(first) {
            let second = self.half_word(address + 2)?;
            return Ok((4, thumb::wide(address, first, second)));
        }
        Ok((2, thumb::narrow(address, first)))
    }

    fn half_word(&self, address: u32) -> anyhow::Result<u16> {
        let bytes = self.sections.iter().find_map(|(start, bytes)| {
            let offset = address.checked_sub(*start)? as usize;
            bytes.get(offset..)?.first_chunk()
        });
        let bytes = bytes.with_context(|| format!("there is no code at {address:#x}"))?;
        Ok(u16::from_le_bytes(*bytes))
    }
}

/// Why a function by this name must not be reached. Clearing and copying memory takes a time that depends on the size
/// alone.
fn forbidden(name: &str) -> Option<&'static str> {
    let of_memory = name.starts_with("__aeabi_mem") || name.starts_with("compiler_builtins::mem");
    let arithmetic = name.starts_with("__aeabi_") || name.starts_with("compiler_builtins::");
    if arithmetic && !of_memory {
        Some("software arithmetic")
    } else if name.starts_with("core::panicking") || name.contains("unwrap_failed") {
        Some("a panic")
    } else {
        None
    }
}
