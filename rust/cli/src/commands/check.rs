// SPDX-License-Identifier: Apache-2.0
//! `lfz check`

use std::process::ExitCode;

use crate::args::{CheckArgs, Platform};
use crate::compile::{Program, Request, count};
use crate::failure::Failure;
use crate::terminal;

/// Prints the errors of a program, or that it has none.
pub(super) fn check(arguments: &CheckArgs) -> Result<ExitCode, Failure> {
    let file = &arguments.file;
    let (errors, warnings) = if arguments.bodies {
        let platform = Some(Platform::Host);
        let request = Request { platform, checks_only: true, ..Request::new(file, &arguments.places) };
        request.build()?.counts
    } else {
        Program::load(file)?.diagnostics.counts()
    };
    terminal::print(format_args!("{}: {}", file.display(), count(errors, warnings)))?;
    Ok(ExitCode::SUCCESS)
}
