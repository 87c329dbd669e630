// SPDX-License-Identifier: Apache-2.0
//! `lfz`: see `lfz --help`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    lfz::execute(lfz::args::Cli::parse())
}
