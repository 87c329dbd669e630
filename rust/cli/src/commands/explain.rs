// SPDX-License-Identifier: Apache-2.0
//! `lfz explain-errors`

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::compile;
use crate::failure::Failure;

/// Prints what rustc has said about generated crates as said about the LF program.
pub(super) fn explain(messages: &[PathBuf]) -> Result<ExitCode, Failure> {
    let text = compile::explain(messages)?;
    io::stdout().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
