// SPDX-License-Identifier: Apache-2.0
//! `lfz supervise`

use std::io;
use std::path::Path;
use std::process::ExitCode;

use crate::failure::Failure;
use crate::federation::Federation;
use crate::supervisor::Interrupts;

/// Runs the processes of a description, from a file or from standard input (`-`), to their end.
pub(super) fn supervise(file: &Path) -> Result<ExitCode, Failure> {
    let interrupts = Interrupts::of_this_process()?;
    let text = if file == Path::new("-") { io::read_to_string(io::stdin()) } else { std::fs::read_to_string(file) };
    let federation = text.map_err(|error| error.to_string()).and_then(|text| Federation::read(&text));
    let federation = federation.map_err(|error| Failure::message(format!("{}: {error}", file.display())))?;
    Ok(ExitCode::from(federation.run(interrupts)?.exit_code()))
}
