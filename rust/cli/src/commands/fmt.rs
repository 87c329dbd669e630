// SPDX-License-Identifier: Apache-2.0
//! `lfz fmt`

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use similar::TextDiff;

use crate::args::FmtArgs;
use crate::compile::{STANDARD_INPUT, count, read_text, standard_input};
use crate::failure::Failure;
use crate::replace::replace;
use crate::terminal;

/// Formats files, or with `--check` tells which are not formatted. All files are looked at, whatever is wrong with one.
pub(super) fn fmt(arguments: &FmtArgs) -> ExitCode {
    let mut is_well = true;
    for file in &arguments.files {
        match format(file, arguments.check) {
            Ok(is_formatted) => is_well &= is_formatted || !arguments.check,
            Err(Failure::Message(text)) => {
                terminal::report(format_args!("error: {text}"));
                is_well = false;
            }
            Err(Failure::Reported) => is_well = false,
        }
    }
    if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Formats one file, or shows the difference; returns whether it was formatted already.
fn format(file: &Path, only_checks: bool) -> Result<bool, Failure> {
    let is_input = file == Path::new(STANDARD_INPUT);
    let name = if is_input { "standard input".to_owned() } else { file.display().to_string() };
    let unreadable = |error| Failure::message(format!("{name} cannot be read: {error}"));
    let text = if is_input { standard_input() } else { read_text(file) }.map_err(unreadable)?;
    let formatted = lf_compiler::format(&name, &text).map_err(|diagnostics| {
        terminal::report(diagnostics.render(terminal::style()));
        let (errors, warnings) = diagnostics.counts();
        terminal::report(format_args!("{name}: {}, so it stays as it is", count(errors, warnings)));
        Failure::Reported
    })?;
    let is_formatted = formatted == text;
    if only_checks {
        if !is_formatted {
            let difference = TextDiff::from_lines(&text, &formatted);
            let (old, new) = (name.clone(), format!("{name}, formatted"));
            terminal::print(difference.unified_diff().header(&old, &new).to_string().trim_end())?;
        }
    } else if is_input {
        terminal::output().write_all(formatted.as_bytes())?;
    } else if !is_formatted {
        replace(file, formatted.as_bytes())
            .map_err(|error| Failure::message(format!("{name} cannot be written: {error}")))?;
    }
    Ok(is_formatted)
}
