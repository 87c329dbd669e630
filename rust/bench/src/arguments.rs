// SPDX-License-Identifier: Apache-2.0
//! The command line.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, ValueEnum};
use lf_bench::Program;

/// Measures RTIs side by side on this computer.
#[derive(Debug, Parser)]
#[command(name = "lf-bench")]
pub(crate) struct Arguments {
    /// What is measured.
    pub(crate) part: Part,
    /// The program `lfz`, built for release.
    #[arg(long, value_name = "PATH", default_value = "lfz")]
    pub(crate) lfz: PathBuf,
    /// The stock RTI, to be measured beside ours.
    #[arg(long, value_name = "PATH")]
    pub(crate) stock_rti: Option<PathBuf>,
    /// How often each measurement is made, in turns.
    #[arg(long, value_name = "N", default_value = "3")]
    pub(crate) rounds: u32,
    /// How many exchanges or messages a round has.
    #[arg(long, value_name = "N", default_value = "1000")]
    pub(crate) exchanges: u32,
    /// How long a federation runs.
    #[arg(long, value_name = "SECONDS", default_value = "2")]
    pub(crate) seconds: u64,
    /// How many federates the large federation has.
    #[arg(long, value_name = "N", default_value = "500")]
    pub(crate) federates: u16,
    /// How far messages over the raw connection are apart.
    #[arg(long, value_name = "MILLISECONDS", default_value = "10")]
    pub(crate) period_ms: u64,
}

impl Arguments {
    pub(crate) fn programs(&self) -> Vec<Program> {
        let stock = self.stock_rti.iter().cloned().map(Program::Stock);
        [Program::Ours(self.lfz.clone())].into_iter().chain(stock).collect()
    }

    pub(crate) fn time(&self) -> Duration {
        Duration::from_secs(self.seconds)
    }
}

/// What can be measured; the last three are what this program starts itself as.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Part {
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
