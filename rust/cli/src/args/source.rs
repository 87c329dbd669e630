// SPDX-License-Identifier: Apache-2.0
//! The options of the commands that read programs and build none: `lfz check`, `lfz plan` and `lfz fmt`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use lf_compiler::maxwait::parse_time;

/// `lfz check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The main LF files; `-` is the standard input, whose imports are in the current folder.
    #[arg(value_name = "FILE.lf", required = true)]
    pub files: Vec<PathBuf>,
    /// Let rustc check bodies, preambles and values.
    #[arg(long)]
    pub bodies: bool,
    /// Print the diagnostics as a list in JSON, for other programs.
    #[arg(long, conflicts_with_all = ["bodies", "deployment"])]
    pub json: bool,
    /// Check the deployment of the program, too (deployment.yaml).
    #[arg(long, value_name = "FILE")]
    pub deployment: Option<PathBuf>,
    /// The folders for generated and compiled files, with --bodies.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz plan`
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Print JSON, for other programs.
    #[arg(long)]
    pub json: bool,
    /// Print the smallest safe offsets for the bounds in this file (bounds.yaml).
    #[arg(long, value_name = "BOUNDS")]
    pub stp: Option<PathBuf>,
    /// A bound of the time from sending a message to its arrival: `5ms`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub latency: Option<i64>,
    /// A bound of the difference between any two clocks: `100us`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub clock_error: Option<i64>,
    /// A bound of the time that a reaction takes: `200us`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub execution: Option<i64>,
}

impl PlanArgs {
    /// Returns whether the user asks for offsets instead of the plan.
    pub fn wants_offsets(&self) -> bool {
        self.stp.is_some() || self.latency.is_some() || self.clock_error.is_some() || self.execution.is_some()
    }
}

/// The platform of the generated programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Platform {
    /// Programs for this computer.
    Host,
    /// Zephyr images: crates, Kconfig fragments and overlays, which the west commands compile.
    Zephyr,
}

/// `lfz fmt`
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// The files; `-` reads the standard input, and writes the standard output.
    #[arg(value_name = "FILE.lf", required = true)]
    pub files: Vec<PathBuf>,
    /// Print the differences, and change nothing.
    #[arg(long)]
    pub check: bool,
}

/// The folders for generated and compiled files, and the mode of compilation.
#[derive(Clone, Debug, Default, Args)]
pub struct Places {
    /// Compile with optimizations.
    #[arg(long)]
    pub release: bool,
    /// The folder for generated crates, instead of `build/lfz/PROGRAM/PLATFORM` beside the program's `src` folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The folder for cargo's compiled files, shared by all programs.
    #[arg(long, value_name = "DIR", env = "LFZ_TARGET_DIR")]
    pub target_dir: Option<PathBuf>,
    /// The lf-zephyr-rs repository with the runtime crates.
    #[arg(long, value_name = "DIR", env = "LFZ_HOME")]
    pub home: Option<PathBuf>,
}
