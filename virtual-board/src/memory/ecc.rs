//! Error correction of the flash memory (RM0440 3.3.4): the double words that do not match their code.
//!
//! The codes themselves are not modelled, only the words that do not match. A file beside the one of the flash memory
//! keeps them, one line a double word, so that a torn word is still torn after the next power-on:
//!
//! ```text
//! 0x040010 torn
//! ```

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// How a double word and its code differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flaw {
    /// In one bit, which a read corrects.
    OneBit,
    /// In more bits: a read gives a wrong value.
    Torn,
}

const NAMES: [(&str, Flaw); 2] = [("one-bit", Flaw::OneBit), ("torn", Flaw::Torn)];

/// The double words with flaws, by offset.
#[derive(Debug)]
pub struct Flaws {
    path: PathBuf,
    found: BTreeMap<usize, Flaw>,
}

impl Flaws {
    /// The flaws of the flash memory that is kept in `flash`; none without a file of them.
    pub fn beside(flash: &Path) -> io::Result<Self> {
        let mut name = flash.as_os_str().to_owned();
        name.push(".ecc");
        let path = PathBuf::from(name);
        let text = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text?,
        };
        let found = text.lines().map(parse).collect::<Option<_>>();
        let found = found.ok_or_else(|| {
            let problem = format!("{} is no list of torn words", path.display());
            io::Error::new(io::ErrorKind::InvalidData, problem)
        })?;
        Ok(Self { path, found })
    }

    /// The flaw of the double word at `offset`.
    pub fn get(&self, offset: usize) -> Option<Flaw> {
        self.found.get(&offset).copied()
    }

    /// Whether this range of offsets has a flaw.
    pub fn any_in(&self, range: Range<usize>) -> bool {
        self.found.range(range).next().is_some()
    }

    /// Gives the double word at `offset` this flaw.
    pub fn set(&mut self, offset: usize, flaw: Flaw) -> io::Result<()> {
        self.found.insert(offset, flaw);
        self.save()
    }

    /// The range was programmed or erased: data and code fit again.
    pub fn mend(&mut self, range: Range<usize>) -> io::Result<()> {
        if !self.any_in(range.clone()) {
            return Ok(());
        }
        self.found.retain(|offset, _| !range.contains(offset));
        self.save()
    }

    fn save(&self) -> io::Result<()> {
        let name = |flaw| NAMES.iter().find(|(_, named)| *named == flaw);
        let lines = self.found.iter().filter_map(|(offset, flaw)| {
            let (name, _) = name(*flaw)?;
            Some(format!("{offset:#08x} {name}\n"))
        });
        std::fs::write(&self.path, lines.collect::<String>())
    }
}

fn parse(line: &str) -> Option<(usize, Flaw)> {
    let (offset, name) = line.strip_prefix("0x")?.split_once(' ')?;
    let offset = usize::from_str_radix(offset, 16).ok()?;
    let (_, flaw) = NAMES.iter().find(|(known, _)| *known == name)?;
    Some((offset, *flaw))
}
