//! The build that the board says it is of: the hash of what its ELF puts into flash.

use anyhow::ensure;
use board_tests::programs::Program;
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader};
use sha2::{Digest, Sha256};

use crate::on;

/// First address of flash.
const FLASH: usize = 0x0800_0000;

/// What a programmer writes into flash, from its first address on.
fn image() -> anyhow::Result<Vec<u8>> {
    let file = std::fs::read(Program::Firmware.path()?)?;
    let elf = ElfFile32::<Endianness>::parse(file.as_slice())?;
    let mut image = Vec::new();
    for segment in elf.elf_program_headers() {
        let bytes = segment.data(Endianness::Little, file.as_slice());
        let bytes = bytes.map_err(|()| anyhow::anyhow!("a segment is not in the file"))?;
        if bytes.is_empty() || segment.p_type(Endianness::Little) != object::elf::PT_LOAD {
            continue;
        }
        let start = segment.p_paddr(Endianness::Little) as usize - FLASH;
        let end = start + bytes.len();
        image.resize(image.len().max(end), 0xFF);
        image[start..end].copy_from_slice(bytes);
    }
    Ok(image)
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn the_board_names_the_build_that_is_in_its_flash() -> anyhow::Result<()> {
    let mut board = on("build")?;
    let version = env!("CARGO_PKG_VERSION").split('.');
    let version: Vec<u8> = version.map(str::parse).collect::<Result<_, _>>()?;
    let hash = Sha256::digest([image()?, version].concat());
    let found = board.line.identity()?.build.map(|build| build.0);
    ensure!(
        found.as_ref() == hash.first_chunk(),
        "{found:?} for {hash:?}"
    );
    Ok(())
}
