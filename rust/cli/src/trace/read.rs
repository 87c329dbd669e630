// SPDX-License-Identifier: Apache-2.0
//! A folder of traces: files of participants, and logs of consoles on which boards have printed theirs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use lf_linux::runtime::trace::{Header, RECORD_BYTES, Record, Role};

use crate::failure::Failure;
use crate::terminal;

/// How the name of a participant's file ends.
pub(crate) const EXTENSION: &str = "lftrace";

/// What stands in a console's line before the number of who prints it, and 32 bytes in hexadecimal.
const MARKER: &str = "lf-trace ";

/// What a line has in place of bytes when all have been printed.
const END: &str = "end";

/// What one participant has recorded.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub(crate) header: Header,
    pub(crate) records: Vec<Record>,
    /// For people: where it is from.
    pub(crate) source: PathBuf,
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

/// The traces in a file; none in one of another kind.
fn read_file(path: &Path) -> Result<Vec<Recorded>, String> {
    let extension = path.extension().unwrap_or_default();
    let bytes = || fs::read(path).map_err(|error| error.to_string());
    if extension == EXTENSION {
        Ok(vec![of_file(&bytes()?, path)?])
    } else if extension == "log" || extension == "txt" {
        of_console(&String::from_utf8_lossy(&bytes()?), path)
    } else {
        Ok(Vec::new())
    }
}

/// The trace that is a file.
fn of_file(bytes: &[u8], path: &Path) -> Result<Recorded, String> {
    let (blocks, rest) = bytes.as_chunks::<RECORD_BYTES>();
    let Some((header, records)) = blocks.split_first() else {
        return Err(format!(
            "it is too short for a trace ({} bytes): the program was ended before it began, or the copy is not \
             complete; remove it, or record again",
            bytes.len()
        ));
    };
    if !rest.is_empty() {
        terminal::remark(format_args!(
            "warning: {}: the last record is cut off: the disk was full, or the copy is not complete",
            path.display()
        ));
    }
    decode(header, records, path)
}

fn decode(header: &[u8; RECORD_BYTES], records: &[[u8; RECORD_BYTES]], path: &Path) -> Result<Recorded, String> {
    let wrong = |damage| format!("{damage}; record again with the programs of this lfz, or remove it");
    let header = Header::from_bytes(header).map_err(wrong)?;
    let records: Result<Vec<_>, _> = records.iter().map(Record::from_bytes).collect();
    Ok(Recorded { header, records: records.map_err(wrong)?, source: path.to_owned() })
}

/// A trace on a console: its blocks, and whether all of it was printed.
#[derive(Default)]
struct Printed {
    blocks: Vec<[u8; RECORD_BYTES]>,
    ended: bool,
}

/// The traces that participants have printed, whatever stands before the marker in a line.
fn of_console(text: &str, path: &Path) -> Result<Vec<Recorded>, String> {
    let mut printed: BTreeMap<&str, Printed> = BTreeMap::new();
    for (number, line) in (1..).zip(text.lines()) {
        let Some((_, words)) = line.split_once(MARKER) else { continue };
        let Some((who, what)) = words.trim().split_once(' ') else { continue };
        let one = printed.entry(who).or_default();
        if what == END {
            one.ended = true;
            continue;
        }
        let block = block(what).ok_or_else(|| {
            format!("line {number} is damaged: 64 hexadecimal digits are expected after `{MARKER}{who}`; record again")
        })?;
        // After a restart the system prints what it has recorded since.
        if block.starts_with(&lf_linux::runtime::trace::MAGIC) {
            *one = Printed::default();
        }
        one.blocks.push(block);
    }
    let mut all = Vec::new();
    for (who, Printed { blocks, ended }) in printed {
        let Some((header, records)) = blocks.split_first() else { continue };
        if !ended {
            terminal::remark(format_args!(
                "warning: {}: the trace of {who} has no line `{MARKER}{who} {END}`: its newest records are missing",
                path.display()
            ));
        }
        all.push(decode(header, records, path)?);
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
    /// Whether it is the trace of an RTI.
    pub(crate) fn is_rti(&self) -> bool {
        self.header.role == Role::Rti
    }
}

#[cfg(test)]
mod tests {
    use lf_linux::model::time::Instant;
    use lf_linux::runtime::trace::Event;

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

    fn in_folder(name: &str, content: &[u8]) -> Result<Vec<Recorded>, String> {
        let folder = tempfile::tempdir().expect("there is room");
        fs::write(folder.path().join(name), content).expect("it can be written");
        read(folder.path()).map_err(|failure| failure.to_string())
    }

    #[test]
    fn a_file_and_a_console_have_the_same_trace() {
        let file = in_folder("a.lftrace", &blocks().concat()).expect("it is right");
        let lines: Vec<_> = blocks().iter().map(|block| format!("[x] lf-trace 3 {}\r\n", hex(block))).collect();
        let log = format!("boot\n{}[x] lf-trace 3 end\nbye\n", lines.concat());
        let console = in_folder("a.log", log.as_bytes()).expect("it is right");
        assert_eq!((file[0].header, &file[0].records), (console[0].header, &console[0].records));
        assert_eq!(file[0].records.len(), 1);
    }

    #[test]
    fn what_is_no_trace_is_said_with_what_to_do() {
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
