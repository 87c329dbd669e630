// SPDX-License-Identifier: Apache-2.0
//! Converts recordings of participants: to a timeline with a table of times, to an RTI's messages for LF's tools or
//! spreadsheets, and to bounds for decentralized coordination.

mod arrows;
mod bounds;
mod clock;
mod messages;
mod names;
mod perfetto;
mod read;
mod table;
mod timeline;
mod words;

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use lf_compiler::plan::Plan;
use lf_linux::runtime::trace::Role;

use crate::failure::Failure;
use arrows::Arrows;
pub(crate) use messages::{Table, TableFormat};
use names::TraceNames;
use perfetto::Writer;
use table::Sums;
use timeline::{Timeline, TimelineElement};

/// The results of converting a folder.
#[derive(Debug)]
pub(crate) struct TraceSummary {
    /// The table of times, for users.
    pub(crate) table: String,
    /// The number of participants.
    pub(crate) participants: usize,
    /// The number of messages that were seen at both ends.
    pub(crate) arrows: usize,
}

/// The folder, beside the generated files, of the traces from which a run is measured.
pub(crate) const MEASURED: &str = "measured";

/// Returns the path of a participant's file in a folder.
pub(crate) fn file(folder: &Path, participant: &str) -> PathBuf {
    folder.join(format!("{participant}.{}", read::EXTENSION))
}

/// Writes the table of names of a program into a folder.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn write_names(plan: &Plan, folder: &Path) -> Result<(), Failure> {
    names::write(&TraceNames::of(plan), folder).map(drop)
}

/// Prepares a folder for the traces of a run: removes those of an earlier run.
///
/// # Errors
/// When it cannot be made or written.
pub(crate) fn prepare(plan: &Plan, folder: &Path) -> Result<(), Failure> {
    let wrong = |error| Failure::message(format!("cannot use the folder {}: {error}", folder.display()));
    fs::create_dir_all(folder).map_err(wrong)?;
    for entry in fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_some_and(|extension| extension == read::EXTENSION) {
            fs::remove_file(&path).map_err(wrong)?;
        }
    }
    write_names(plan, folder)
}

/// Writes the recorded messages of the RTI in a folder into files.
///
/// # Errors
/// When there is no trace of an RTI, it is damaged, or a file cannot be written.
pub(crate) fn write_tables(folder: &Path, tables: &[Table]) -> Result<(), Failure> {
    let all = read::read(folder)?;
    let rti = all.iter().find(|recorded| recorded.is_rti());
    let missing = || Failure::message(format!("there is no trace of an RTI in {}", folder.display()));
    let rti = rti.ok_or_else(missing)?;
    tables.iter().try_for_each(|table| table.write(rti))
}

/// Writes the recorded messages of an RTI from one file into others.
///
/// # Errors
/// When it is damaged, or a file cannot be written.
pub(crate) fn convert_rti(trace: &Path, tables: &[Table]) -> Result<(), Failure> {
    let rti = read::read_one(trace)?;
    tables.iter().try_for_each(|table| table.write(&rti))
}

/// Writes the measured bounds of a decentralized program into a file; returns the number of messages behind them.
///
/// # Errors
/// When there is no trace in the folder, one is damaged or of another program, or the file cannot be written.
pub(crate) fn write_bounds(folder: &Path, names: Option<&Path>, file: &Path) -> Result<usize, Failure> {
    let all = read::read(folder)?;
    let names = names::read(names.unwrap_or(&folder.join(names::FILE)))?;
    let measured = bounds::measure(&all, &names)?;
    fs::write(file, measured.to_yaml(&names))
        .map_err(|error| Failure::message(format!("cannot write {}: {error}", file.display())))?;
    Ok(measured.messages)
}

/// Merges the traces of a folder, and writes the file for Perfetto.
///
/// # Errors
/// When there is no trace, one is damaged or of another program, or the file cannot be written.
pub(crate) fn convert(folder: &Path, names: Option<&Path>, output: &Path) -> Result<TraceSummary, Failure> {
    let all = read::read(folder)?;
    let names = names::read(names.unwrap_or(&folder.join(names::FILE)))?;
    let mut timelines = Vec::new();
    for recorded in &all {
        let role = recorded.header.role;
        let id = match role {
            Role::Federate(id) => Some(id),
            Role::Rti | Role::Program => None,
        };
        let participant = names::of_participant(&names, &recorded.header).map_err(|reason| recorded.wrong(&reason))?;
        timelines.push(Timeline::of(recorded, names::name(&names, role), id, participant)?);
    }
    // The RTI has no start time of its own.
    let start = timelines.iter().find_map(|timeline| timeline.start);
    for timeline in &mut timelines {
        timeline.start = timeline.start.or(start);
    }
    let wrong = |error| Failure::message(format!("cannot write {}: {error}", output.display()));
    let mut file = BufWriter::new(File::create(output).map_err(wrong)?);
    let (mut arrows, mut tables) = (Arrows::between(&timelines), Vec::new());
    for (number, timeline) in (1..).zip(&timelines) {
        let mut writer = Writer { timeline, names: &names, number, output: &mut file };
        let mut written = writer.begin();
        let mut sums = Sums::default();
        timeline.for_each(&mut |element| {
            let mut write = |writer: &mut Writer<'_, _>| match &element {
                TimelineElement::Slice(slice) => {
                    sums.add(slice, timeline, &names);
                    writer.slice(slice)
                }
                TimelineElement::Message(mark) => writer.mark(mark, arrows.at(timeline, mark)),
            };
            if written.is_ok() {
                written = write(&mut writer);
            }
        })?;
        written.map_err(wrong)?;
        tables.push(sums.table(timeline));
    }
    file.flush().map_err(wrong)?;
    Ok(TraceSummary { table: tables.join("\n"), participants: timelines.len(), arrows: arrows.count() })
}
