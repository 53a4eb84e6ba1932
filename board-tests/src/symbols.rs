//! Where the firmware keeps what: addresses of its symbols.

use std::fs;

use anyhow::Context;
use object::{Object, ObjectSymbol};

use crate::programs::Program;

/// Address of the symbol whose name, as the compiler writes it, has this part.
pub fn address(part: &str) -> anyhow::Result<u64> {
    let path = Program::Firmware.path()?;
    let bytes = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let elf = object::File::parse(&*bytes)?;
    let found = elf
        .symbols()
        .find(|symbol| symbol.name().is_ok_and(|name| name.contains(part)));
    let symbol = found.with_context(|| format!("the firmware has no symbol with {part}"))?;
    Ok(symbol.address())
}
