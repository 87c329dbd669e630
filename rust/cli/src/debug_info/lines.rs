// SPDX-License-Identifier: Apache-2.0
//! Tables of lines in the format DWARF, which say for each instruction from which line it comes.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use gimli::write::{
    Address, ConvertLineRow, ConvertResult, DebugLine, DebugLineStr, EndianVec, FileId, LineProgram, LineString, Writer,
};
use gimli::{
    DW_AT_stmt_list, DebugLineOffset, Dwarf, EndianSlice, IncompleteLineProgram, RunTimeEndian, SectionId, Unit, write,
};

use super::elf::Elf;
use super::origins::Origins;

type Reader<'a> = EndianSlice<'a, RunTimeEndian>;
/// Sections and their contents.
type Sections = Vec<(SectionId, Vec<u8>)>;
type LineTable<'a> = IncompleteLineProgram<Reader<'a>>;

/// Returns the sections that change, with their new contents; `None` when no instruction is from a line of the program.
///
/// # Errors
/// When the debugging information cannot be read.
pub(super) fn convert(elf: &Elf, origins: &mut Origins<'_>) -> ConvertResult<Option<Sections>> {
    let section = |id| -> gimli::Result<Reader<'_>> { Ok(EndianSlice::new(elf.section(id), elf.endian())) };
    let dwarf = Dwarf::load(section)?;
    let mut info = EndianVec::new(elf.endian());
    info.write(elf.section(SectionId::DebugInfo))?;
    let mut tables = Tables::new(elf)?;
    let mut units = dwarf.units();
    while let Some(header) = units.next()? {
        let unit = dwarf.unit(header)?;
        let Some(table) = unit.line_program.clone() else { continue };
        if let Some(DebugLineOffset(offset)) = tables.converted(&dwarf, &unit, &table, origins)? {
            let size = unit.encoding().format.word_size();
            info.write_udata_at(place_of_reference(&unit)?, offset as u64, size)?;
        }
    }
    Ok(tables.finish()?.map(|mut sections| {
        sections.push((SectionId::DebugInfo, info.into_vec()));
        sections
    }))
}

/// Returns the place in the section at which a unit says where its table is.
fn place_of_reference(unit: &Unit<Reader<'_>>) -> gimli::Result<usize> {
    let mut entries = unit.entries_raw(None)?;
    for &attribute in entries.read_abbreviation()?.into_iter().flat_map(gimli::Abbreviation::attributes) {
        let place = entries.next_offset();
        entries.read_attribute(attribute)?;
        if attribute.name() == DW_AT_stmt_list {
            return Ok(unit.header.debug_info_offset().map_or(0, |unit| unit.0) + place.0);
        }
    }
    // The unit has this table.
    Err(gimli::Error::MissingUnitDie)
}

/// The tables of an executable, to which converted ones are added.
struct Tables {
    lines: DebugLine<Section>,
    strings: DebugLineStr<Section>,
    out: write::Dwarf,
    /// Where the converted table is, by the place of the old one, which several units may share.
    known: HashMap<usize, Option<DebugLineOffset>>,
}

impl Tables {
    fn new(elf: &Elf) -> write::Result<Self> {
        let strings = Section::new(elf, SectionId::DebugLineStr, 0)?;
        let lines = Section::new(elf, SectionId::DebugLine, strings.len())?;
        let (lines, strings) = (DebugLine(lines), DebugLineStr(strings));
        Ok(Self { lines, strings, out: write::Dwarf::new(), known: HashMap::new() })
    }

    /// Converts a table, and returns where the new one is; `None` when nothing of it is from the program.
    fn converted(
        &mut self,
        dwarf: &Dwarf<Reader<'_>>,
        unit: &Unit<Reader<'_>>,
        table: &LineTable<'_>,
        origins: &mut Origins<'_>,
    ) -> ConvertResult<Option<DebugLineOffset>> {
        let DebugLineOffset(offset) = table.header().offset();
        if let Some(known) = self.known.get(&offset) {
            return Ok(*known);
        }
        let generated = generated_files(dwarf, unit, table, origins)?;
        let new = if generated.is_empty() { None } else { self.add(dwarf, table, &generated, origins)? };
        self.known.insert(offset, new);
        Ok(new)
    }

    fn add(
        &mut self,
        dwarf: &Dwarf<Reader<'_>>,
        table: &LineTable<'_>,
        generated: &HashMap<usize, String>,
        origins: &mut Origins<'_>,
    ) -> ConvertResult<Option<DebugLineOffset>> {
        let mut reading = self.out.read_line_program(dwarf, table.clone(), None, None)?;
        let mut rows = Vec::new();
        while let Some(row) = reading.read_row()? {
            rows.push(row);
        }
        let (mut program, files) = reading.program();
        let first = usize::from(program.version() <= 4);
        let files = &files[first.min(files.len())..];
        // Functions and variables refer to files by their numbers, which have to stay.
        if files.iter().collect::<HashSet<_>>().len() < files.len() {
            return Ok(None);
        }
        let generated: HashMap<FileId, &str> =
            generated.iter().filter_map(|(index, path)| Some((*files.get(index - first)?, path.as_str()))).collect();
        let mut has_changed = false;
        for row in &mut rows {
            let ConvertLineRow::Row(row) = row else { continue };
            let Some(path) = generated.get(&row.file) else { continue };
            if let Some(place) = origins.place(path, row.line, row.column) {
                row.file = self.file(&mut program, &place.file);
                (row.line, row.column) = (place.line, place.column);
                has_changed = true;
            }
        }
        if !has_changed {
            return Ok(None);
        }
        for row in rows {
            match row {
                ConvertLineRow::SetAddress(address) => program.set_address(Address::Constant(address)),
                ConvertLineRow::Row(row) => {
                    *program.row() = row;
                    program.generate_row();
                }
                ConvertLineRow::EndSequence(length) => program.end_sequence(length),
            }
        }
        let write::Dwarf { line_strings, strings, .. } = &mut self.out;
        Ok(Some(program.write(&mut self.lines, program.encoding(), line_strings, strings)?))
    }

    /// Returns the number of a file of the program in a table.
    fn file(&mut self, program: &mut LineProgram, path: &Path) -> FileId {
        let encoding = program.encoding();
        let strings = &mut self.out.line_strings;
        let mut text = |text: &OsStr| LineString::new(text.as_bytes(), encoding, strings);
        let folder = path.parent().unwrap_or(Path::new("/"));
        let folder = program.add_directory(text(folder.as_os_str()));
        program.add_file(text(path.file_name().unwrap_or_default()), folder, None)
    }

    /// Returns the new sections; `None` when no table was converted.
    fn finish(mut self) -> write::Result<Option<Sections>> {
        if self.known.values().all(Option::is_none) {
            return Ok(None);
        }
        let mut sections = vec![(SectionId::DebugLine, self.lines.0.bytes.into_vec())];
        let strings = std::mem::take(&mut self.out.line_strings);
        if strings.count() > 0 {
            strings.write(&mut self.strings)?;
            sections.push((SectionId::DebugLineStr, self.strings.0.bytes.into_vec()));
        }
        Ok(Some(sections))
    }
}

/// Returns the generated files of a table, by their numbers.
fn generated_files(
    dwarf: &Dwarf<Reader<'_>>,
    unit: &Unit<Reader<'_>>,
    table: &LineTable<'_>,
    origins: &mut Origins<'_>,
) -> gimli::Result<HashMap<usize, String>> {
    let header = table.header();
    let path = |bytes: Reader<'_>| PathBuf::from(OsStr::from_bytes(bytes.slice()));
    let current = unit.comp_dir.map(path).unwrap_or_default();
    let first = usize::from(header.version() <= 4);
    let mut found = HashMap::new();
    for (index, file) in (first..).zip(header.file_names()) {
        let folder = match header.directory(file.directory_index()) {
            Some(folder) => path(dwarf.attr_string(unit, folder)?),
            None => PathBuf::new(),
        };
        let file = current.join(folder).join(path(dwarf.attr_string(unit, file.path_name())?));
        if let Some(path) = origins.generated(&file) {
            found.insert(index, path);
        }
    }
    Ok(found)
}

/// A section that grows: what is written stands behind what was there.
struct Section {
    bytes: EndianVec<RunTimeEndian>,
    /// The length of the strings that were there, from which the new ones count.
    strings: usize,
}

impl Section {
    fn new(elf: &Elf, id: SectionId, strings: usize) -> write::Result<Self> {
        let mut bytes = EndianVec::new(elf.endian());
        bytes.write(elf.section(id))?;
        Ok(Self { bytes, strings })
    }
}

impl Writer for Section {
    type Endian = RunTimeEndian;

    fn endian(&self) -> RunTimeEndian {
        self.bytes.endian()
    }

    fn len(&self) -> usize {
        self.bytes.len()
    }

    fn write(&mut self, bytes: &[u8]) -> write::Result<()> {
        self.bytes.write(bytes)
    }

    fn write_at(&mut self, offset: usize, bytes: &[u8]) -> write::Result<()> {
        self.bytes.write_at(offset, bytes)
    }

    fn write_offset(&mut self, offset: usize, section: SectionId, size: u8) -> write::Result<()> {
        let before = if section == SectionId::DebugLineStr { self.strings } else { 0 };
        self.write_udata((before + offset) as u64, size)
    }
}
