// SPDX-License-Identifier: Apache-2.0
//! `lfz completions` and `lfz man`

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::ExitCode;

use clap::CommandFactory as _;
use clap_complete::Shell;

use crate::args::Cli;
use crate::failure::Failure;
use crate::terminal;

/// Prints the script by which a shell completes command lines.
pub(super) fn completions(shell: Shell) -> Result<ExitCode, Failure> {
    let (all, mut script) = (Cli::command(), Vec::new());
    // The crate would complete the commands that only other programs use, too.
    let visible = all.get_subcommands().filter(|command| !command.is_hide_set()).cloned();
    let options = all.get_arguments().cloned();
    let mut command = clap::Command::new("lfz").version(env!("CARGO_PKG_VERSION")).args(options).subcommands(visible);
    clap_complete::generate(shell, &mut command, "lfz", &mut script);
    terminal::output().write_all(&script)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the manual pages of this program and of its commands into a folder.
pub(super) fn man(folder: &Path) -> Result<ExitCode, Failure> {
    write_pages(folder)
        .map_err(|error| Failure::message(format!("no page is written in {}: {error}", folder.display())))?;
    Ok(ExitCode::SUCCESS)
}

fn write_pages(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    clap_mangen::generate_to(Cli::command(), folder)
}
