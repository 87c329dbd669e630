// SPDX-License-Identifier: Apache-2.0
//! The table of names as a file, and the participant of a recording.

use std::path::{Path, PathBuf};

pub(crate) use lf_compiler::trace_names::{FILE, TraceNames, TracedFederate};
use lf_linux::runtime::trace::{Header, Role};

use crate::failure::Failure;

/// Reads a table.
///
/// # Errors
/// When it cannot be read, or is none.
pub(crate) fn read(file: &Path) -> Result<TraceNames, Failure> {
    let wrong = |reason: &dyn std::fmt::Display| {
        Failure::message(format!(
            "cannot use {}: {reason}; name the {FILE} that `lfz build` has written beside the program with --names",
            file.display()
        ))
    };
    let text = std::fs::read_to_string(file).map_err(|error| wrong(&error))?;
    serde_json::from_str(&text).map_err(|error| wrong(&error))
}

/// Writes the table into a folder.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn write(names: &TraceNames, folder: &Path) -> Result<PathBuf, Failure> {
    let file = folder.join(FILE);
    let text = serde_json::to_string_pretty(names).map_err(std::io::Error::from)?;
    std::fs::write(&file, text)
        .map_err(|error| Failure::message(format!("cannot write {}: {error}", file.display())))?;
    Ok(file)
}

/// Returns the name of the participant with this header.
pub(crate) fn name(names: &TraceNames, role: Role) -> String {
    match role {
        Role::Rti => "RTI".to_owned(),
        Role::Federate(id) => {
            names.federates.get(usize::from(id)).map_or_else(|| format!("federate {id}"), |found| found.name.clone())
        }
        Role::Program => names.program.clone(),
    }
}

/// Returns the participant with this header, which has tables of these sizes: none for an RTI.
///
/// # Errors
/// When the table has no such participant, or another one under its number: the table is of another build.
pub(crate) fn of_participant<'a>(names: &'a TraceNames, header: &Header) -> Result<Option<&'a TracedFederate>, String> {
    let index = match header.role {
        Role::Rti => return Ok(None),
        Role::Federate(id) => usize::from(id),
        Role::Program => 0,
    };
    let size = |count: usize| u16::try_from(count).unwrap_or(u16::MAX);
    let fits = |found: &&TracedFederate| {
        header.sizes == [&found.reactions.len(), &found.inputs.len(), &found.outputs].map(|count| size(*count))
    };
    names.federates.get(index).filter(fits).map(Some).ok_or_else(|| {
        let [reactions, inputs, outputs] = header.sizes;
        format!(
            "it was recorded by another program, or another version of it, than the table of names is for: it has \
             {reactions} reactions, {inputs} inputs and {outputs} outputs; name the {FILE} of that build with \
             --names"
        )
    })
}
