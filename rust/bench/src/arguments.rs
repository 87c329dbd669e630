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
    /// The part to measure.
    pub(crate) part: Part,
    /// The program `lfz`, built for release.
    #[arg(long, value_name = "PATH", default_value = "lfz")]
    pub(crate) lfz: PathBuf,
    /// The stock RTI, to be measured beside ours.
    #[arg(long, value_name = "PATH")]
    pub(crate) stock_rti: Option<PathBuf>,
    /// The number of rounds; in each round, every RTI is measured once.
    #[arg(long, value_name = "N", default_value = "3")]
    pub(crate) rounds: u32,
    /// The number of exchanges or messages in a round.
    #[arg(long, value_name = "N", default_value = "1000")]
    pub(crate) exchanges: u32,
    /// The number of seconds that a federation runs.
    #[arg(long, value_name = "SECONDS", default_value = "2")]
    pub(crate) seconds: u64,
    /// The number of federates in the large federation.
    #[arg(long, value_name = "N", default_value = "500")]
    pub(crate) federates: u16,
    /// The period of the messages over the raw connection.
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

/// The parts that can be measured; this program starts itself as the last three.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Part {
    /// The latency of grants and messages.
    Latency,
    /// Messages per second, processor time for each, and memory.
    Throughput,
    /// Latency and throughput of our RTI, encrypted beside plain.
    Encryption,
    /// The cost of a grant as the federation grows.
    Growth,
    /// One large federation from its start to its end.
    Large,
    /// The error of clocks, in virtual time; a round is a seed that decides the delays of the network.
    Clock,
    /// The variation of an RTI's answers in the exchanges of clock synchronization before the start.
    Initial,
    /// The latency of bytes between two processes over a raw connection.
    Raw,
    /// A forwarder that sleeps until bytes arrive.
    #[value(hide = true)]
    ForwardAsleep,
    /// A forwarder that polls without sleeping.
    #[value(hide = true)]
    ForwardAwake,
    /// The process that receives the messages over a raw connection.
    #[value(hide = true)]
    Answer,
}
