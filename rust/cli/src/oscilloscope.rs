// SPDX-License-Identifier: Apache-2.0
//! `lfz run --vcd`: what the pins of all federates did, in one file.
//!
//! Each federate writes a file of its own, whose times are since the start of the federation by the federation's clock
//! (see `lf_linux`). So the files agree on time, as the channels of one oscilloscope do.

use std::fs::File;
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};

use lf_compiler::plan::{Federate, Plan};
use lf_linux::devices::recording::{self, Recording};

use crate::failure::Failure;

/// The file into which a federate writes what its pins do.
pub(crate) fn file(folder: &Path, federate: &Federate) -> PathBuf {
    folder.join(format!("{}.vcd", federate.name))
}

/// Takes away what an earlier run has left.
pub(crate) fn clear(plan: &Plan, folder: &Path) {
    for federate in &plan.federates {
        // What cannot be removed cannot be written either, and that is told.
        let _ = std::fs::remove_file(file(folder, federate));
    }
}

/// Makes one file of those that the federates have written; says how many pins there are. A federate that was ended
/// before it could write has none.
///
/// # Errors
/// When one is not understood, or the result cannot be written.
pub(crate) fn merge(plan: &Plan, folder: &Path, to: &Path) -> Result<usize, Failure> {
    let mut parts = Vec::new();
    for federate in &plan.federates {
        let path = file(folder, federate);
        match File::open(&path).and_then(|part| Recording::read(&federate.name, BufReader::new(part))) {
            Ok(part) => parts.push(part),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(Failure::message(format!("cannot use {}: {error}", path.display()))),
        }
    }
    File::create(to)
        .and_then(|file| recording::write(BufWriter::new(file), &parts))
        .map_err(|error| Failure::message(format!("cannot write {}: {error}", to.display())))?;
    Ok(parts.iter().map(|part| part.pins.len()).sum())
}
