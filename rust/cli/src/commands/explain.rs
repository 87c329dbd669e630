// SPDX-License-Identifier: Apache-2.0
//! `lfz explain-errors`

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::compile;
use crate::failure::Failure;
use crate::terminal;

/// Prints rustc's diagnostics about generated crates as diagnostics about the LF program.
pub(super) fn explain(messages: &[PathBuf]) -> Result<ExitCode, Failure> {
    let text = compile::explain(messages)?;
    terminal::output().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
