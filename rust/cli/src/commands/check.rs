// SPDX-License-Identifier: Apache-2.0
//! `lfz check`

use std::path::Path;
use std::process::ExitCode;

use crate::compile::{Program, count};
use crate::failure::Failure;
use crate::terminal;

/// Says what is wrong with a program, or that nothing is.
pub(super) fn check(file: &Path) -> Result<ExitCode, Failure> {
    let program = Program::load(file)?;
    let (errors, warnings) = program.diagnostics.counts();
    terminal::print(format_args!("{}: {}", file.display(), count(errors, warnings)))?;
    Ok(ExitCode::SUCCESS)
}
