// SPDX-License-Identifier: Apache-2.0
//! Sections of an executable whose contents are replaced.

use std::io;

use gimli::{RunTimeEndian, SectionId};
use object::elf::{FileHeader32, FileHeader64, SHF_COMPRESSED, SectionHeader32, SectionHeader64};
use object::read::elf::FileHeader;
use object::{BinaryFormat, Endianness, File, Object, ObjectKind, ObjectSection, Pod, SectionFlags, pod};

/// An executable in the format ELF.
pub(super) struct Elf {
    bytes: Vec<u8>,
    endian: RunTimeEndian,
    is_64: bool,
}

impl Elf {
    /// Returns the executable; `None` when this is another kind of file.
    pub(super) fn read(bytes: Vec<u8>) -> Option<Self> {
        let file = File::parse(&*bytes).ok()?;
        let is_linked = matches!(file.kind(), ObjectKind::Executable | ObjectKind::Dynamic);
        if file.format() != BinaryFormat::Elf || !is_linked {
            return None;
        }
        let endian = if file.is_little_endian() { RunTimeEndian::Little } else { RunTimeEndian::Big };
        let is_64 = file.is_64();
        Some(Self { bytes, endian, is_64 })
    }

    pub(super) fn endian(&self) -> RunTimeEndian {
        self.endian
    }

    /// Returns the contents of a section. One that does not exist is empty, and so is one that is compressed, which
    /// nobody asks the compiler for by default.
    pub(super) fn section(&self, id: SectionId) -> &[u8] {
        let is_plain =
            |flags| matches!(flags, SectionFlags::Elf { sh_flags, .. } if !sh_flags.contains(SHF_COMPRESSED));
        let file = File::parse(&*self.bytes).ok();
        let contents = file.and_then(|file| {
            let section = file.section_by_name(id.name()).filter(|section| is_plain(section.flags()))?;
            section.data().ok()
        });
        contents.unwrap_or_default()
    }

    /// Replaces the contents of a section: the new ones stand at the end of the file, since no other section may move.
    ///
    /// # Errors
    /// When the file has no such section.
    pub(super) fn replace(&mut self, id: SectionId, contents: &[u8]) -> io::Result<()> {
        let (endian, place) = {
            let file = File::parse(&*self.bytes).map_err(damaged)?;
            let section = file.section_by_name(id.name());
            (file.endianness(), section.map_or(0, |section| section.index().0))
        };
        let (offset, size) = (self.bytes.len(), contents.len());
        self.bytes.extend_from_slice(contents);
        let bytes = &mut *self.bytes;
        // A file of 32 bits has room for no more either.
        let number = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        if self.is_64 {
            let table = FileHeader64::<Endianness>::parse(&*bytes).map_err(damaged)?.e_shoff(endian);
            let header = entry::<SectionHeader64<Endianness>>(bytes, table, place)?;
            header.sh_offset.set(endian, offset as u64);
            header.sh_size.set(endian, size as u64);
        } else {
            let table = FileHeader32::<Endianness>::parse(&*bytes).map_err(damaged)?.e_shoff(endian);
            let header = entry::<SectionHeader32<Endianness>>(bytes, table.into(), place)?;
            header.sh_offset.set(endian, number(offset));
            header.sh_size.set(endian, number(size));
        }
        Ok(())
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

fn damaged(error: object::Error) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, error)
}

/// Returns an entry of the table of sections.
fn entry<T: Pod>(bytes: &mut [u8], table: u64, index: usize) -> io::Result<&mut T> {
    let missing = || io::Error::new(io::ErrorKind::InvalidData, "a table of sections that does not exist");
    let table = usize::try_from(table).ok().and_then(|table| bytes.get_mut(table..)).ok_or_else(missing)?;
    let place = table.get_mut(index * size_of::<T>()..).ok_or_else(missing)?;
    pod::from_bytes_mut(place).map(|(entry, _)| entry).map_err(|()| missing())
}
