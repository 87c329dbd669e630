// SPDX-License-Identifier: Apache-2.0
//! `lfz explain-errors` and `lfz name-lines`

use std::io::Write;
use std::path::{Path, PathBuf};
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

/// Makes the debugging information of an image name the LF program.
pub(super) fn name_lines(image: &Path, folder: &Path) -> Result<ExitCode, Failure> {
    compile::name_lf_lines(image, folder).map(|()| ExitCode::SUCCESS)
}
