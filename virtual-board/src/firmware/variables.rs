//! Finds variables of the firmware by name, with the debugging information of its ELF: where a member of a static lies in
//! RAM, and how large it is.
//!
//! A member is given by its path through the types, such as `period.v.value`. Types of the standard library are part of
//! the path, because the firmware's statics lie in cells.

use gimli::{AttributeValue, DebugInfoOffset, Dwarf, EndianSlice, LittleEndian, Unit, UnitOffset};
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use rustc_demangle::demangle;

use super::elf::Firmware;

type Reader<'a> = EndianSlice<'a, LittleEndian>;

/// A variable in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Address of its first byte.
    pub address: u32,
    /// Its size, bytes.
    pub size: u64,
}

/// A type: the unit that describes it, and where in that unit.
struct Type<'a> {
    unit: Unit<Reader<'a>>,
    offset: UnitOffset,
}

impl Firmware {
    /// Where `member` of the static `variable` lies.
    ///
    /// # Errors
    /// What of the path there is not.
    pub fn variable(&self, variable: &str, member: &str) -> Result<Place, String> {
        let elf = ElfFile32::<Endianness>::parse(self.file.as_slice())
            .map_err(|error| error.to_string())?;
        let (symbol, address) = elf
            .symbols()
            .filter_map(|symbol| Some((symbol.name().ok()?, symbol.address() as u32)))
            .find(|(symbol, _)| format!("{:#}", demangle(symbol)) == variable)
            .ok_or_else(|| format!("the firmware has no variable {variable}"))?;
        let load = |section: gimli::SectionId| {
            let section = elf.section_by_name(section.name());
            let bytes = section.and_then(|section| section.data().ok());
            Ok(EndianSlice::new(bytes.unwrap_or_default(), LittleEndian))
        };
        let place = Dwarf::load(load).and_then(|dwarf| {
            let Some(mut found) = type_of(&dwarf, symbol)? else {
                return Ok(None);
            };
            let mut at = u64::from(address);
            for name in member.split('.') {
                let Some((offset, next)) = found.member(&dwarf, name)? else {
                    return Ok(None);
                };
                (at, found) = (at + offset, next);
            }
            let size = found.size()?;
            Ok(size.map(|size| Place {
                address: at as u32,
                size,
            }))
        });
        place
            .map_err(|error: gimli::Error| format!("the debugging information: {error}"))?
            .ok_or_else(|| format!("{variable} has no member {member}"))
    }
}

/// The type of the variable with this symbol.
fn type_of<'a>(dwarf: &Dwarf<Reader<'a>>, symbol: &str) -> Result<Option<Type<'a>>, gimli::Error> {
    let mut headers = dwarf.units();
    while let Some(header) = headers.next()? {
        let unit = dwarf.unit(header)?;
        let mut entries = unit.entries();
        while let Some((_, entry)) = entries.next_dfs()? {
            let Some(name) = entry.attr_value(gimli::DW_AT_linkage_name)? else {
                continue;
            };
            let is_it = dwarf.attr_string(&unit, name)?.slice() == symbol.as_bytes();
            if entry.tag() == gimli::DW_TAG_variable && is_it {
                let found = entry.attr_value(gimli::DW_AT_type)?;
                return found.map_or(Ok(None), |value| Type::at(dwarf, unit, value));
            }
        }
    }
    Ok(None)
}

impl<'a> Type<'a> {
    /// The type that an attribute in `unit` refers to.
    fn at(
        dwarf: &Dwarf<Reader<'a>>,
        unit: Unit<Reader<'a>>,
        value: AttributeValue<Reader<'a>>,
    ) -> Result<Option<Self>, gimli::Error> {
        match value {
            AttributeValue::UnitRef(offset) => Ok(Some(Self { unit, offset })),
            AttributeValue::DebugInfoRef(offset) => Self::elsewhere(dwarf, offset),
            _ => Ok(None),
        }
    }

    /// The type at this place of the whole information.
    fn elsewhere(
        dwarf: &Dwarf<Reader<'a>>,
        at: DebugInfoOffset,
    ) -> Result<Option<Self>, gimli::Error> {
        let mut headers = dwarf.units();
        while let Some(header) = headers.next()? {
            if let Some(offset) = at.to_unit_offset(&header) {
                let unit = dwarf.unit(header)?;
                return Ok(Some(Self { unit, offset }));
            }
        }
        Ok(None)
    }

    /// Offset and type of the member called `name`.
    fn member(
        self,
        dwarf: &Dwarf<Reader<'a>>,
        name: &str,
    ) -> Result<Option<(u64, Self)>, gimli::Error> {
        let mut tree = self.unit.entries_tree(Some(self.offset))?;
        let mut members = tree.root()?.children();
        let mut found = None;
        while let Some(member) = members.next()? {
            let entry = member.entry();
            let Some(called) = entry.attr_value(gimli::DW_AT_name)? else {
                continue;
            };
            if entry.tag() == gimli::DW_TAG_member
                && dwarf.attr_string(&self.unit, called)?.slice() == name.as_bytes()
            {
                let offset = entry.attr_value(gimli::DW_AT_data_member_location)?;
                let offset = offset.and_then(|offset| offset.udata_value());
                found = offset.zip(entry.attr_value(gimli::DW_AT_type)?);
            }
        }
        let Some((offset, value)) = found else {
            return Ok(None);
        };
        let next = Self::at(dwarf, self.unit, value)?;
        Ok(next.map(|next| (offset, next)))
    }

    fn size(&self) -> Result<Option<u64>, gimli::Error> {
        let entry = self.unit.entry(self.offset)?;
        let size = entry.attr_value(gimli::DW_AT_byte_size)?;
        Ok(size.and_then(|size| size.udata_value()))
    }
}
