// SPDX-License-Identifier: Apache-2.0
//! `lf-bench`: measures RTIs and clock synchronization on this computer, and prints a line of JSON for each value.
//! `cargo xtask evaluate` builds it and makes tables and a page from its output.
#![forbid(unsafe_code)]

mod arguments;
mod clocks;
mod rti;

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use arguments::{Arguments, Part};
use clap::Parser;
use lf_bench::{Measured, Result, Waiting, ping};

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    match arguments.part {
        Part::Latency => rti::latency(arguments),
        Part::Throughput => rti::throughput(arguments),
        Part::Encryption => rti::encryption(arguments),
        Part::Growth => rti::growth(arguments),
        Part::Large => rti::large(arguments),
        Part::Clock => clocks::clock(arguments.rounds),
        Part::Initial => clocks::initial(arguments),
        Part::Raw => {
            let samples = ping(arguments.exchanges, Duration::from_millis(arguments.period_ms))?;
            Measured::samples("raw", "delay", "raw TCP", "µs", &samples).print()
        }
        Part::ForwardAsleep => lf_bench::forward(Waiting::Asleep, |port| print_number(port.into())),
        Part::ForwardAwake => lf_bench::forward(Waiting::Awake, |port| print_number(port.into())),
        Part::Answer => lf_bench::answer_pings(print_number),
    }
}

/// Prints a number for the process that started this one.
fn print_number(number: u64) {
    println!("{number}");
    // A parent that does not read the port will not connect either.
    let _ = std::io::stdout().flush();
}
