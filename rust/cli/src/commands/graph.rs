// SPDX-License-Identifier: Apache-2.0
//! `lfz graph`

use std::fs;
use std::io::Write as _;
use std::process::ExitCode;

use lf_compiler::diagram::BankView;

use crate::args::GraphArgs;
use crate::compile::{Program, read_deployment};
use crate::failure::Failure;
use crate::graph::picture;
use crate::terminal;

/// Writes the picture of a program.
pub(super) fn graph(arguments: &GraphArgs) -> Result<ExitCode, Failure> {
    let banks = if arguments.expand_banks { BankView::Expanded } else { BankView::Collapsed };
    let (program, diagram) = Program::drawn(&arguments.file, banks)?;
    let deployment = arguments.deployment.as_ref().map(|path| read_deployment(path, &program.plan)).transpose()?;
    let depth = arguments.depth.unwrap_or(usize::MAX);
    let picture = picture(&diagram, deployment.as_ref(), depth, arguments.theme);
    match &arguments.output {
        None => terminal::output().write_all(picture.as_bytes())?,
        Some(file) => fs::write(file, picture)
            .map_err(|error| Failure::message(format!("{} cannot be written: {error}", file.display())))?,
    }
    Ok(ExitCode::SUCCESS)
}
