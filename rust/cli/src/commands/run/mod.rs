// SPDX-License-Identifier: Apache-2.0
//! `lfz run`

mod once;
mod watched;

use std::process::ExitCode;

use crate::args::RunArgs;
use crate::failure::Failure;
use crate::supervisor::Interrupts;
use once::{request, run_once};

/// Builds all participants for this computer and runs them to their end, or with `--watch` until ^C.
pub(super) fn run(arguments: &RunArgs) -> Result<ExitCode, Failure> {
    if arguments.watch {
        return watched::run(arguments);
    }
    let built = request(arguments).build()?;
    let ending = run_once(&built, arguments, Interrupts::of_this_process)?;
    Ok(ExitCode::from(ending.exit_code()))
}
