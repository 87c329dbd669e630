// SPDX-License-Identifier: Apache-2.0
//! `lfz trace`

use std::process::ExitCode;

use crate::args::TraceArgs;
use crate::failure::Failure;
use crate::terminal;
use crate::trace::convert;

/// Puts the traces of a folder together, and says where time went.
pub(super) fn trace(arguments: &TraceArgs) -> Result<ExitCode, Failure> {
    let output = arguments.output.clone().unwrap_or_else(|| arguments.folder.join("trace.perfetto-trace"));
    let outcome = convert(&arguments.folder, arguments.names.as_deref(), &output)?;
    terminal::print(outcome.table.trim_end())?;
    terminal::remark(format_args!(
        "{} participants and {} arrows in {}: open it at https://ui.perfetto.dev",
        outcome.participants,
        outcome.arrows,
        output.display()
    ));
    Ok(ExitCode::SUCCESS)
}
