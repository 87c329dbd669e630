// SPDX-License-Identifier: Apache-2.0
//! A folder of traces: files of participants, and logs of consoles on which boards have printed theirs.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use lf_linux::runtime::trace::{Damage, Event, Header, RECORD_BYTES, Record, Role};

use crate::failure::Failure;
use crate::terminal;

/// The extension of a participant's file.
pub(crate) const EXTENSION: &str = "lftrace";

/// The marker in a console's line, before the participant's number and 32 bytes in hexadecimal.
const MARKER: &str = "lf-trace ";

/// The content of the last line of a trace, instead of bytes.
const END: &str = "end";

/// The maximum number of records that are recorded later than records of later events: the events of workers are
/// recorded when all reactions of a level have ended, and a level has 65535 at most, each of which begins and ends.
const LATE_MAX: usize = 2 * 65_535;

/// The recording of one participant.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub(crate) header: Header,
    /// The file from which it was read.
    pub(crate) source: PathBuf,
    blocks: Blocks,
}

/// The location of the records.
#[derive(Debug)]
enum Blocks {
    /// In a file, whose size only the user limits, so every pass reads it again: the number of records, and of those
    /// that are newer than all others, in a file that has wrapped around.
    File { count: u64, newer: u64 },
    /// In lines of a console. A board has kept them in its memory, so they are few.
    Printed(Vec<[u8; RECORD_BYTES]>),
}

/// Reads the trace of one participant.
///
/// # Errors
/// When it is damaged.
pub(crate) fn read_one(path: &Path) -> Result<Recorded, Failure> {
    let recorded = said(File::open(path).map(BufReader::new)).and_then(|file| of_file(file, path));
    recorded.map_err(|reason| Failure::message(format!("{}: {reason}", path.display())))
}

/// Reads all traces of a folder.
///
/// # Errors
/// When there is none, when one is damaged, or there are two of one participant.
pub(crate) fn read(folder: &Path) -> Result<Vec<Recorded>, Failure> {
    let wrong = |error| Failure::message(format!("cannot read {}: {error}", folder.display()));
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    let mut all: Vec<Recorded> = Vec::new();
    for path in paths {
        let found = read_file(&path).map_err(|reason| Failure::message(format!("{}: {reason}", path.display())))?;
        for recorded in found {
            if let Some(other) = all.iter().find(|other| other.header.role == recorded.header.role) {
                return Err(Failure::message(format!(
                    "{} and {} are of the same participant: keep the files of one run in a folder",
                    other.source.display(),
                    recorded.source.display()
                )));
            }
            all.push(recorded);
        }
    }
    if all.is_empty() {
        return Err(Failure::message(format!(
            "there is no trace in {}: neither a file `*.{EXTENSION}`, which `lfz run --trace {}` and the option \
             --trace of programs write, nor the log of a console (`*.log` or `*.txt`) with the lines `{MARKER}…` of \
             an image with CONFIG_LF_TRACE=y",
            folder.display(),
            folder.display()
        )));
    }
    all.sort_by_key(|recorded| recorded.header.role);
    Ok(all)
}

/// Returns the traces in a file; none for a file of another kind.
fn read_file(path: &Path) -> Result<Vec<Recorded>, String> {
    let extension = path.extension().unwrap_or_default();
    let open = || said(File::open(path).map(BufReader::new));
    if extension == EXTENSION {
        Ok(vec![of_file(open()?, path)?])
    } else if extension == "log" || extension == "txt" {
        of_console(open()?, path)
    } else {
        Ok(Vec::new())
    }
}

/// Converts an error of reading to its message.
fn said<T>(result: io::Result<T>) -> Result<T, String> {
    result.map_err(|error| error.to_string())
}

/// Returns the trace of a binary file.
fn of_file(mut file: BufReader<File>, path: &Path) -> Result<Recorded, String> {
    let bytes = said(file.get_ref().metadata())?.len();
    let Some(header) = said(next_block(&mut file))? else {
        return Err(format!(
            "it is too short for a trace ({bytes} bytes): the program was ended before it began, or the copy is not \
             complete; remove it, or record again"
        ));
    };
    let header = Header::from_bytes(&header).map_err(wrong)?;
    let (mut count, mut newer) = (0, 0);
    while let Some(block) = said(next_block(&mut file))? {
        count += 1;
        if Record::from_bytes(&block).map_err(wrong)?.event == Event::Seam {
            newer = count;
        }
    }
    if bytes % RECORD_BYTES as u64 != 0 {
        terminal::report(format_args!(
            "warning: {}: the last record is cut off: the disk was full, or the copy is not complete",
            path.display()
        ));
    }
    Ok(Recorded { header, source: path.to_owned(), blocks: Blocks::File { count, newer } })
}

/// Reads the next whole block.
fn next_block(from: &mut impl Read) -> io::Result<Option<[u8; RECORD_BYTES]>> {
    let mut block = [0; RECORD_BYTES];
    match from.read_exact(&mut block) {
        Ok(()) => Ok(Some(block)),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}

fn wrong(damage: Damage) -> String {
    format!("{damage}; record again with the programs of this lfz, or remove it")
}

/// A trace on a console: its blocks, and whether it is complete.
#[derive(Default)]
struct Printed {
    blocks: Vec<[u8; RECORD_BYTES]>,
    ended: bool,
}

/// Returns the traces on a console, whatever stands before the marker in a line.
fn of_console(file: impl BufRead, path: &Path) -> Result<Vec<Recorded>, String> {
    let mut printed: BTreeMap<String, Printed> = BTreeMap::new();
    for (number, line) in (1..).zip(file.split(b'\n')) {
        let line = said(line)?;
        let line = String::from_utf8_lossy(&line);
        let Some((_, words)) = line.split_once(MARKER) else { continue };
        let Some((who, what)) = words.trim().split_once(' ') else { continue };
        let one = printed.entry(who.to_owned()).or_default();
        if what == END {
            one.ended = true;
            continue;
        }
        let block = block(what).ok_or_else(|| {
            format!("line {number} is damaged: 64 hexadecimal digits are expected after `{MARKER}{who}`; record again")
        })?;
        // After a restart the system prints a new recording.
        if block.starts_with(&lf_linux::runtime::trace::MAGIC) {
            *one = Printed::default();
        }
        one.blocks.push(block);
    }
    let mut all = Vec::new();
    for (who, Printed { blocks, ended }) in printed {
        let Some((header, records)) = blocks.split_first() else { continue };
        let header = Header::from_bytes(header).map_err(wrong)?;
        for record in records {
            Record::from_bytes(record).map_err(wrong)?;
        }
        if !ended {
            terminal::report(format_args!(
                "warning: {}: the trace of {who} has no line `{MARKER}{who} {END}`: its newest records are missing",
                path.display()
            ));
        }
        all.push(Recorded { header, source: path.to_owned(), blocks: Blocks::Printed(records.to_vec()) });
    }
    Ok(all)
}

fn block(text: &str) -> Option<[u8; RECORD_BYTES]> {
    let digits = text.as_bytes();
    if digits.len() != 2 * RECORD_BYTES {
        return None;
    }
    let mut block = [0; RECORD_BYTES];
    for (byte, pair) in block.iter_mut().zip(digits.as_chunks::<2>().0) {
        let value = |digit: u8| char::from(digit).to_digit(16).and_then(|value| u8::try_from(value).ok());
        *byte = value(pair[0])? << 4 | value(pair[1])?;
    }
    Some(block)
}

impl Recorded {
    /// Calls `take` with all records, the oldest first.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn for_each(&self, mut take: impl FnMut(Record)) -> Result<(), Failure> {
        self.try_for_each(&mut take).map_err(|reason| self.wrong(&reason))
    }

    fn try_for_each(&self, take: &mut dyn FnMut(Record)) -> Result<(), String> {
        let (count, newer) = match &self.blocks {
            Blocks::File { count, newer } => (*count, *newer),
            Blocks::Printed(blocks) => {
                return blocks.iter().try_for_each(|block| Record::from_bytes(block).map(&mut *take).map_err(wrong));
            }
        };
        let mut file = BufReader::new(said(File::open(&self.source))?);
        for (from, to) in [(newer, count), (0, newer)] {
            // The records begin after the header.
            said(file.seek(SeekFrom::Start((1 + from) * RECORD_BYTES as u64)))?;
            for _ in from..to {
                let Some(block) = said(next_block(&mut file))? else { break };
                take(Record::from_bytes(&block).map_err(wrong)?);
            }
        }
        Ok(())
    }

    /// Calls `take` with all events in the order of their times, as `time` converts them.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn in_order(
        &self,
        time: impl Fn(&Record) -> i64,
        mut take: impl FnMut(i64, Event),
    ) -> Result<(), Failure> {
        // Events of one time keep the order in which they were recorded.
        let (mut waiting, mut count) = (BTreeMap::new(), 0_u64);
        self.for_each(|record| {
            waiting.insert((time(&record), count), record.event);
            count += 1;
            if waiting.len() > LATE_MAX
                && let Some(((at, _), event)) = waiting.pop_first()
            {
                take(at, event);
            }
        })?;
        for ((at, _), event) in waiting {
            take(at, event);
        }
        Ok(())
    }

    /// Returns the number of records that newer ones have overwritten in a file that has wrapped around.
    pub(crate) fn overwritten(&self) -> u64 {
        match self.blocks {
            Blocks::File { newer, .. } => newer,
            Blocks::Printed(_) => 0,
        }
    }

    /// Returns the failure to use it, for this reason.
    pub(crate) fn wrong(&self, reason: &str) -> Failure {
        Failure::message(format!("{}: {reason}", self.source.display()))
    }

    /// Returns whether it is the trace of an RTI.
    pub(crate) fn is_rti(&self) -> bool {
        self.header.role == Role::Rti
    }
}

#[cfg(test)]
mod tests {
    use lf_linux::model::time::Instant;

    use super::*;

    fn blocks() -> Vec<[u8; RECORD_BYTES]> {
        let header = Header { role: Role::Federate(3), sizes: [1, 2, 3] };
        let record = Record { at: Instant::from_nanos(7), event: Event::WaitEnds };
        vec![header.to_bytes(), record.to_bytes()]
    }

    fn hex(block: &[u8]) -> String {
        let digits = block.iter().flat_map(|byte| [byte >> 4, byte & 15]);
        digits.filter_map(|digit| char::from_digit(digit.into(), 16)).collect()
    }

    fn in_folder(name: &str, content: &[u8]) -> Result<Vec<(Header, Vec<Record>)>, String> {
        let folder = tempfile::tempdir().expect("there is room");
        fs::write(folder.path().join(name), content).expect("it can be written");
        let found = read(folder.path()).map_err(|failure| failure.to_string())?;
        let records = found.iter().map(|recorded| {
            let mut records = Vec::new();
            recorded.for_each(|record| records.push(record)).expect("it can be read");
            (recorded.header, records)
        });
        Ok(records.collect())
    }

    #[test]
    fn a_file_and_a_console_have_the_same_trace() {
        let file = in_folder("a.lftrace", &blocks().concat()).expect("it is right");
        let lines: Vec<_> = blocks().iter().map(|block| format!("[x] lf-trace 3 {}\r\n", hex(block))).collect();
        let log = format!("boot\n{}[x] lf-trace 3 end\nbye\n", lines.concat());
        let console = in_folder("a.log", log.as_bytes()).expect("it is right");
        assert_eq!((file[0].0, &file[0].1), (console[0].0, &console[0].1));
        assert_eq!(file[0].1.len(), 1);
    }

    /// A file that has wrapped around is read from its seam on, and a truncated one up to the cut.
    #[test]
    fn records_come_oldest_first() {
        let at = |at, event| Record { at: Instant::from_nanos(at), event }.to_bytes();
        let mut ring = vec![blocks()[0], at(7, Event::Lost(3)), at(8, Event::WaitEnds), at(8, Event::Seam)];
        ring.extend([at(5, Event::WaitEnds), at(6, Event::WaitEnds)]);
        let mut bytes = ring.concat();
        bytes.truncate(bytes.len() - 5);
        let found = in_folder("a.lftrace", &bytes).expect("it is right");
        assert_eq!(found[0].1.iter().map(|record| record.at.as_nanos()).collect::<Vec<_>>(), [5, 7, 8, 8]);
    }

    #[test]
    fn a_file_that_is_no_trace_is_refused_with_advice() {
        let mut foreign = blocks().concat();
        foreign[0] = b'x';
        let mut newer = blocks().concat();
        newer[8] = 9;
        for (name, content, words) in [
            ("a.lftrace", &b"short"[..], "too short for a trace (5 bytes)"),
            ("a.lftrace", &foreign, "does not begin as a trace does"),
            ("a.lftrace", &newer, "version 9 of the format"),
            ("a.dat", b"", "there is no trace in"),
            ("a.log", b"lf-trace 3 zz\n", "line 1 is damaged"),
        ] {
            let error = in_folder(name, content).expect_err(words);
            assert!(error.contains(words), "{error}");
        }
    }
}
