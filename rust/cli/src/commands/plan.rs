// SPDX-License-Identifier: Apache-2.0
//! `lfz plan`

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use crate::compile::Program;
use crate::failure::Failure;

/// Prints what the compiler worked out.
pub(super) fn plan(file: &Path, json: bool) -> Result<ExitCode, Failure> {
    let plan = Program::load(file)?.plan;
    let mut output = io::stdout().lock();
    if json {
        serde_json::to_writer_pretty(&mut output, &plan).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        writeln!(output, "{}", plan.to_string().trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}
