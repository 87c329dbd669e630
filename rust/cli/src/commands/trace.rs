// SPDX-License-Identifier: Apache-2.0
//! `lfz trace`

use std::path::PathBuf;
use std::process::ExitCode;

use crate::args::TraceArgs;
use crate::failure::Failure;
use crate::terminal;
use crate::trace::{Table, TableFormat, convert, write_bounds, write_tables};

/// Writes the requested files from the traces of a folder; by default, merges them, and prints a table of times.
pub(super) fn trace(arguments: &TraceArgs) -> Result<ExitCode, Failure> {
    let TraceArgs { folder, names, output, lft, csv, bounds } = arguments;
    let table = |file: &Option<PathBuf>, format| file.clone().map(|file| Table { file, format });
    let tables: Vec<_> = table(lft, TableFormat::Lft).into_iter().chain(table(csv, TableFormat::Csv)).collect();
    if !tables.is_empty() {
        write_tables(folder, &tables)?;
    }
    if let Some(file) = bounds {
        let messages = write_bounds(folder, names.as_deref(), file)?;
        terminal::inform(format_args!("{messages} messages measured: {}", file.display()));
    }
    if output.is_none() && (bounds.is_some() || !tables.is_empty()) {
        return Ok(ExitCode::SUCCESS);
    }
    let output = arguments.output.clone().unwrap_or_else(|| arguments.folder.join("trace.perfetto-trace"));
    let outcome = convert(&arguments.folder, arguments.names.as_deref(), &output)?;
    terminal::print(outcome.table.trim_end())?;
    terminal::inform(format_args!(
        "{} participants and {} arrows in {}: open it at https://ui.perfetto.dev",
        outcome.participants,
        outcome.arrows,
        output.display()
    ));
    Ok(ExitCode::SUCCESS)
}
