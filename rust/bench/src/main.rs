// SPDX-License-Identifier: Apache-2.0
//! `lf-bench`: measures RTIs and the applications of this repository on this computer; `cargo xtask evaluate` builds
//! and runs it.
#![forbid(unsafe_code)]

mod arguments;
mod suite;

use std::io::Write;
use std::process::ExitCode;

use arguments::{Arguments, Command};
use clap::Parser;
use lf_bench::Waiting;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match arguments.command {
        Some(Command::Forward { awake }) => {
            let waiting = if awake { Waiting::Awake } else { Waiting::Asleep };
            lf_bench::forward(waiting, |port| tell(port.into()))
        }
        Some(Command::Ping) => lf_bench::applications::answer_pings(tell),
        None => suite::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints a number for the process that started this one.
fn tell(number: u64) {
    println!("{number}");
    // Whoever does not read the port will not connect either.
    let _ = std::io::stdout().flush();
}
