// SPDX-License-Identifier: Apache-2.0
//! The options of `lfz scope`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use crate::time;

/// `lfz scope`
#[derive(Debug, Args)]
pub struct ScopeArgs {
    /// Recordings of `lfz run --vcd`, or of a logic analyser.
    #[arg(required = true, value_name = "FILE.vcd")]
    pub files: Vec<PathBuf>,
    /// The signal to compare the others with: `a.led0`. Without it, the command lists the signals.
    #[arg(short, long, value_name = "SIGNAL")]
    pub reference: Option<String>,
    /// The signals to compare with it; default: all others.
    #[arg(short, long, value_name = "SIGNAL", num_args = 1.., requires = "reference")]
    pub compare: Vec<String>,
    /// The edges that count.
    #[arg(long, value_enum, default_value_t = EdgeKind::Both)]
    pub edges: EdgeKind,
    /// The maximum distance of edges that belong together: `5ms`; default: half of the usual distance from one edge of
    /// the reference to the next one of its kind.
    #[arg(long, value_name = "TIME", value_parser = time::parse)]
    pub window: Option<Duration>,
    /// The number of intervals in the histogram.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = bins)]
    pub bins: usize,
    /// Draw delays with their regression lines, the histogram and the first edges into this file.
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub svg: Option<PathBuf>,
    /// Print JSON, for other programs.
    #[arg(long)]
    pub json: bool,
}

/// The edges that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EdgeKind {
    /// All edges; each is compared with those of its own kind.
    Both,
    /// From low to high.
    Rising,
    /// From high to low.
    Falling,
}

fn bins(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| (1..=1000).contains(number));
    number.ok_or_else(|| "it is a number from 1 to 1000".to_owned())
}
