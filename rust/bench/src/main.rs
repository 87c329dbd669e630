// SPDX-License-Identifier: Apache-2.0
//! `lf-bench`: measures RTIs and clock synchronization on this computer, and prints a line of JSON for each value.
//! `cargo xtask evaluate` builds it and makes tables and a page of what it prints.
#![forbid(unsafe_code)]

mod clocks;
mod rti;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, ValueEnum};
use lf_bench::{Measured, Program, Result, Waiting, ping};

/// Measures RTIs side by side on this computer.
#[derive(Debug, Parser)]
#[command(name = "lf-bench")]
struct Arguments {
    /// What is measured.
    part: Part,
    /// The program `lfz`, built for release.
    #[arg(long, value_name = "PATH", default_value = "lfz")]
    lfz: PathBuf,
    /// The stock RTI, to be measured beside ours.
    #[arg(long, value_name = "PATH")]
    stock_rti: Option<PathBuf>,
    /// How often each measurement is made, in turns.
    #[arg(long, value_name = "N", default_value = "3")]
    rounds: u32,
    /// How many exchanges or messages a round has.
    #[arg(long, value_name = "N", default_value = "1000")]
    exchanges: u32,
    /// How long a federation runs.
    #[arg(long, value_name = "SECONDS", default_value = "2")]
    seconds: u64,
    /// How many federates the large federation has.
    #[arg(long, value_name = "N", default_value = "500")]
    federates: u16,
    /// How far messages over the raw connection are apart.
    #[arg(long, value_name = "MILLISECONDS", default_value = "10")]
    period_ms: u64,
}

impl Arguments {
    fn programs(&self) -> Vec<Program> {
        let stock = self.stock_rti.iter().cloned().map(Program::Stock);
        [Program::Ours(self.lfz.clone())].into_iter().chain(stock).collect()
    }

    fn time(&self) -> Duration {
        Duration::from_secs(self.seconds)
    }
}

/// What can be measured; the last three are what this program starts itself as.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Part {
    /// How long grants and messages are on their way.
    Latency,
    /// Messages per second, processor time for each, and memory.
    Throughput,
    /// What a grant takes as the federation grows.
    Growth,
    /// One large federation from its start to its end.
    Large,
    /// How far clocks are apart, in virtual time; a round is a seed that decides the delays of the network.
    Clock,
    /// How evenly an RTI answers in the exchanges of clock synchronization before the start.
    Initial,
    /// How long bytes take from one process to another over a raw connection.
    Raw,
    /// A forwarder that sleeps until something comes.
    #[value(hide = true)]
    ForwardAsleep,
    /// A forwarder that looks all the time.
    #[value(hide = true)]
    ForwardAwake,
    /// The process that messages over a raw connection go to.
    #[value(hide = true)]
    Answer,
}

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
        Part::Growth => rti::growth(arguments),
        Part::Large => rti::large(arguments),
        Part::Clock => clocks::clock(arguments.rounds),
        Part::Initial => clocks::initial(arguments),
        Part::Raw => {
            let samples = ping(arguments.exchanges, Duration::from_millis(arguments.period_ms))?;
            Measured::samples("raw", "delay", "raw TCP", "µs", &samples).print()
        }
        Part::ForwardAsleep => lf_bench::forward(Waiting::Asleep, |port| tell(port.into())),
        Part::ForwardAwake => lf_bench::forward(Waiting::Awake, |port| tell(port.into())),
        Part::Answer => lf_bench::answer_pings(tell),
    }
}

/// Prints a number for the process that started this one.
fn tell(number: u64) {
    println!("{number}");
    // Whoever does not read the port will not connect either.
    let _ = std::io::stdout().flush();
}
