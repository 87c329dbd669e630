// SPDX-License-Identifier: Apache-2.0
//! `lfz`: see `lfz --help`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    lfz::execute(lfz::args::Cli::read(std::env::args_os()).unwrap_or_else(|error| error.exit()))
}
