// SPDX-License-Identifier: Apache-2.0
//! `lfz`: see `lfz --help`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// The compiler makes and drops many small things.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    lfz::execute(lfz::args::Cli::read(std::env::args_os()))
}
