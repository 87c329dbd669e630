// SPDX-License-Identifier: Apache-2.0
//! The command line.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};

/// Measures RTIs side by side, and the applications of this repository, on this computer.
#[derive(Debug, Parser)]
#[command(name = "lf-bench", subcommand_negates_reqs = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// The program `lfz`, built for release.
    #[arg(long, value_name = "PATH", required_unless_present = "from")]
    pub(crate) lfz: Option<PathBuf>,
    /// The folder of this repository, with the applications.
    #[arg(long, value_name = "PATH", required_unless_present = "from")]
    pub(crate) repository: Option<PathBuf>,
    /// The stock RTI, to be measured beside ours.
    #[arg(long, value_name = "PATH")]
    pub(crate) stock_rti: Option<PathBuf>,
    /// Write `results.json` and `report.html` to this folder, after each part.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) report: Option<PathBuf>,
    /// Measure nothing, and make the page of results that were written before.
    #[arg(long, value_name = "RESULTS", requires = "report")]
    pub(crate) from: Option<PathBuf>,
    /// Measure everything in short: numbers are rough, and all takes minutes. The smart grid and the rate run on Linux
    /// alone, and of virtual boards and images only the first ones are measured.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What was recorded at two pins that are toggled at the same logical times (VCD), for the thesis's figure 6.3.
    #[arg(long, value_name = "VCD")]
    pub(crate) recording: Option<PathBuf>,
    /// Measure only this; may be repeated.
    #[arg(long, value_enum, value_name = "PART")]
    pub(crate) only: Vec<PartName>,
    /// How often each measurement is made, in turns; the best one counts.
    #[arg(long, value_name = "N", default_value = "3", default_value_if("quick", "true", "2"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) rounds: u32,
    /// How many exchanges a measurement of latency has.
    #[arg(long, value_name = "N", default_value = "5000", default_value_if("quick", "true", "1000"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) exchanges: u32,
    /// How many seconds a measurement of throughput or growth takes.
    #[arg(long, value_name = "SECONDS", default_value = "2", default_value_if("quick", "true", "1"))]
    pub(crate) seconds: u64,
    /// How many federates the large federation has.
    #[arg(long, value_name = "N", default_value = "500", default_value_if("quick", "true", "100"))]
    #[arg(value_parser = clap::value_parser!(u16).range(2..=4096))]
    pub(crate) large: u16,
    /// How many seconds the large federation runs.
    #[arg(long, value_name = "SECONDS", default_value = "60", default_value_if("quick", "true", "5"))]
    pub(crate) large_seconds: u64,
    /// How often the smart grid is run with each setting.
    #[arg(long, value_name = "N", default_value = "10", default_value_if("quick", "true", "3"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) iterations: u32,
    /// How often the smart grid is run without a violation before a delay counts as long enough.
    #[arg(long, value_name = "N", default_value = "100", default_value_if("quick", "true", "5"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) after_runs: u32,
    /// How many seconds the application with the drifting clock runs.
    #[arg(long, value_name = "SECONDS", default_value = "600", default_value_if("quick", "true", "20"))]
    #[arg(value_parser = clap::value_parser!(u64).range(2..))]
    pub(crate) drift_seconds: u64,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Be the forwarder that latencies are compared with.
    #[command(hide = true)]
    Forward {
        /// Look for messages all the time instead of sleeping.
        #[arg(long)]
        awake: bool,
    },
    /// Be the process that messages over a raw connection go to.
    #[command(hide = true)]
    Ping,
}

/// What can be measured. The last seven run applications, on `native_sim` too where there is a Zephyr workspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PartName {
    /// How long grants and messages are on their way.
    Latency,
    /// Messages per second, processor time for each, and memory.
    Throughput,
    /// What a grant takes as the federation grows.
    Growth,
    /// One large federation from its start to its end.
    Large,
    /// How far clocks are apart, in virtual time.
    Clock,
    /// How evenly an RTI answers in the exchanges of clock synchronization before the start.
    Initial,
    /// How far apart two participants toggle their pins, from a `--recording`.
    Pins,
    /// How long a message of the message test takes on Linux, beside a raw connection.
    Delay,
    /// How many messages of the message test get through in a second.
    Rate,
    /// How long the smart grid takes to react with each setting of the thesis; takes minutes.
    Grid,
    /// The smallest delay of the smart grid's connections without a violation; takes up to half an hour.
    After,
    /// A drifting clock, synchronized for ten minutes.
    Drift,
    /// How long a message takes between virtual boards with Zephyr's own network stack, beside a raw connection between
    /// the same images, and how many messages get through in a second.
    Boards,
    /// Flash and RAM of images for a small board, and what of them is this project's.
    Sizes,
}

impl PartName {
    /// Whether it cannot be measured without a Zephyr workspace.
    pub(crate) fn needs_zephyr(self) -> bool {
        matches!(self, Self::Drift | Self::Boards | Self::Sizes)
    }
}
