// SPDX-License-Identifier: Apache-2.0
//! `lfz run --vcd` and similar commands: a recording of the pins of all federates, in one file.
//!
//! Each federate writes a file of its own, whose times are by the clock of the computer that all of them run on, and
//! which contains the start time of the federate. So the files agree on time, as the channels of one oscilloscope do.

mod qemu;

use std::fs::File;
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lf_compiler::plan::Plan;
use lf_linux::devices::moves::{AcceptedMoves, Reader, check, moves};
use lf_linux::devices::recording::{self, Recording};
use serde::Deserialize;

use crate::failure::Failure;
use crate::terminal;

/// The recording of pins in a run.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PinRecording {
    /// The merged file of all parts.
    pub(crate) file: PathBuf,
    /// The file of each participant.
    pub(crate) parts: Vec<Part>,
}

/// The file of a participant.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Part {
    /// Its name.
    pub(crate) name: String,
    /// The file.
    pub(crate) file: PathBuf,
    /// Whether it is QEMU's trace of a board, and not VCD.
    #[serde(default)]
    pub(crate) is_trace: bool,
}

impl PinRecording {
    /// Returns the recording of a program whose federates all run on this computer, with files of their own in a
    /// folder.
    pub(crate) fn of(plan: &Plan, folder: &Path, file: &Path) -> Self {
        let part =
            |name: &String| Part { name: name.clone(), file: folder.join(format!("{name}.vcd")), is_trace: false };
        let parts = plan.federates.iter().map(|federate| part(&federate.name)).collect();
        Self { file: file.to_owned(), parts }
    }

    /// Returns the file into which a participant records its pins.
    pub(crate) fn file_of(&self, name: &str) -> Option<&Path> {
        self.parts.iter().find(|part| part.name == name).map(|part| part.file.as_path())
    }

    /// Removes the files of an earlier run.
    pub(crate) fn clear(&self) {
        for part in &self.parts {
            // A file that cannot be removed cannot be written either, which is an error then.
            let _ = std::fs::remove_file(&part.file);
        }
    }

    /// Merges the files of the participants, and prints the result's path. A participant that was ended before it could
    /// write has no file.
    ///
    /// # Errors
    /// When one is invalid, or the result cannot be written.
    pub(crate) fn merge(&self) -> Result<(), Failure> {
        let mut recordings = Vec::new();
        // QEMU's traces lack the start of the program; so that of the others counts.
        let (traces, parts): (Vec<&Part>, Vec<&Part>) = self.parts.iter().partition(|part| part.is_trace);
        for Part { name, file, is_trace } in parts.into_iter().chain(traces) {
            let start = recordings.iter().filter_map(|recording: &Recording| recording.start).min();
            let recording = if *is_trace {
                std::fs::read_to_string(file).map(|trace| qemu::recording(name, &trace, start))
            } else {
                File::open(file).and_then(|part| Recording::read(name, BufReader::new(part)))
            };
            match recording {
                Ok(recording) => recordings.push(recording),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(Failure::message(format!("cannot use {}: {error}", file.display()))),
            }
        }
        let to = self.file.display();
        File::create(&self.file)
            .and_then(|file| recording::write(BufWriter::new(file), &recordings))
            .map_err(|error| Failure::message(format!("cannot write {to}: {error}")))?;
        let pins: usize = recordings.iter().map(|recording| recording.pins.len()).sum();
        terminal::inform(format_args!("{pins} pins recorded: {to}"));
        Ok(())
    }
}

/// Executes `lfz moves`.
///
/// # Errors
/// When the script cannot be read, is invalid, or has lines that no participant can use.
pub(crate) fn print_moves(script: &Path, federate: &str, readers: &[Reader]) -> Result<ExitCode, Failure> {
    let name = script.display();
    let text = std::fs::read_to_string(script).map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let moves = moves(&text, federate, readers).map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let lines: Vec<String> = moves.iter().map(ToString::to_string).collect();
    terminal::print(lines.join("\n"))?;
    Ok(ExitCode::SUCCESS)
}

/// Checks the script of a run on this computer, before anything runs.
///
/// # Errors
/// When it cannot be read, is invalid, or has lines that no participant can use.
pub(crate) fn check_script(script: &Path, plan: &Plan) -> Result<(), Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::message(format!("{}: {error}", script.display()));
    let text = std::fs::read_to_string(script).map_err(|error| wrong(&error))?;
    let readers: Vec<_> = plan
        .federates
        .iter()
        .map(|federate| Reader { name: federate.name.clone(), takes: AcceptedMoves::All })
        .collect();
    check(&text, &readers).map_err(|error| wrong(&error))
}

/// Parses `NAME=all`, `NAME=pins` or `NAME=nothing`.
pub(crate) fn reader(text: &str) -> Result<Reader, String> {
    let (name, takes) = text.split_once('=').ok_or("a federate has `=` behind its name, and what it takes")?;
    let takes = match takes {
        "all" => AcceptedMoves::All,
        "pins" => AcceptedMoves::Pins,
        "nothing" => AcceptedMoves::Nothing,
        _ => return Err("a federate takes all, pins or nothing".to_owned()),
    };
    Ok(Reader { name: name.to_owned(), takes })
}
