// SPDX-License-Identifier: Apache-2.0
//! `cargo xtask`: the single entry point for people and CI.
//!
//! `test` runs every kind of check that this computer can run, keeps going after a failure, says what it skipped,
//! and ends with one line that sums all of them up.
#![forbid(unsafe_code)]

mod bless;
mod book;
mod c;
mod counts;
mod dependencies;
mod dist;
mod editor;
mod evaluate;
mod host;
mod lf_tests;
mod process;
mod python;
mod report;
mod tidy;
mod twister;
mod zephyr;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};

use crate::report::Report;

/// Checks and maintains this repository.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run all tests; ends with the line `N passed, N failed, N skipped`.
    Test {
        /// Leave the Zephyr tests out even when a Zephyr workspace is found.
        #[arg(long)]
        host_only: bool,
        /// Run only this step; may be repeated.
        #[arg(long, value_name = "STEP", value_parser = step_names())]
        only: Vec<String>,
        /// After this many minutes, begin no further Zephyr test; those that are left out count as skipped.
        #[arg(long, value_name = "MINUTES")]
        within: Option<u32>,
    },
    /// Check what no compiler checks: sizes, licence headers, paths in the documentation, stray files.
    Tidy,
    /// Check the RTI's grants in all reachable states of small federations; `--help` after it lists the options.
    ModelCheck {
        /// The arguments for the program that does it.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Run random federations in virtual time and check them; `--help` after it lists the options.
    Simulate {
        /// The arguments for the program that does it.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Rewrite the expected outputs (snapshots) with the programs' present output; read the diff before committing.
    #[command(alias = "golden")]
    Bless {
        /// Run the tests of this crate only.
        #[arg(long, short, value_name = "CRATE")]
        package: Option<String>,
        /// Run tests only whose names contain this.
        filter: Option<String>,
    },
    /// Run all LF programs below a folder, such as LF's own tests, and say of each whether it passes.
    LfTests {
        /// The folder.
        #[arg(value_name = "PATH")]
        folder: PathBuf,
        /// Only programs whose paths contain this.
        #[arg(long, value_name = "TEXT")]
        only: Option<String>,
        /// Check programs of any target as programs in Rust without bodies, and run none: the result is about LF's own
        /// language alone.
        #[arg(long)]
        empty_bodies: bool,
        /// Run them as Zephyr images for this board of `native_sim`, one after the other.
        #[arg(long, value_name = "BOARD", conflicts_with = "empty_bodies")]
        board: Option<String>,
        /// Run federations with this RTI, a program with the stock RTI's options, and not with ours.
        #[arg(long, value_name = "PROGRAM", conflicts_with_all = ["empty_bodies", "board"])]
        rti: Option<PathBuf>,
    },
    /// Make what people install, in `target/dist`: the packages of all crates for cargo, and a wheel for pip.
    Dist,
    /// Make the site of the guide in `target/guide`, with mdBook.
    Book,
    /// Measure RTIs, applications and images on this computer, beside the thesis's numbers and the stock RTI if its
    /// path is given; `--report FOLDER` writes a page of it, and `--help` lists the options.
    #[command(disable_help_flag = true)]
    Evaluate {
        /// The arguments of `scripts/lf_evaluate`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
}

/// The function of a step of `cargo xtask test`, with the repository and the report to fill.
type Step = fn(&Path, &mut Report);

/// The steps, in the order in which they run: the quick ones first.
const STEPS: &[(&str, Step)] = &[
    ("tidy", tidy::step),
    ("fmt", host::fmt),
    ("clippy", host::clippy),
    ("dependencies", dependencies::check),
    ("book", book::step),
    ("c", c::step),
    ("host", host::test),
    ("python", python::step),
    ("editor", editor::step),
    ("dist", dist::step),
    ("twister", twister::run),
    ("federations", zephyr::federations),
];

/// The steps that need a Zephyr workspace.
const ZEPHYR_STEPS: &[&str] = &["twister", "federations"];

fn step_names() -> clap::builder::PossibleValuesParser {
    STEPS.iter().map(|(name, _)| *name).collect::<Vec<_>>().into()
}

fn main() -> ExitCode {
    let repository = repository();
    match Arguments::parse().command {
        Command::Test { host_only, only, within } => {
            let limit = within.map(|minutes| Duration::from_secs(60 * u64::from(minutes)));
            test(&repository, host_only, &only, limit)
        }
        Command::Tidy => {
            let mut report = Report::new(None);
            tidy::step(&repository, &mut report);
            report.finish()
        }
        Command::Dist => match dist::make(&repository, dist::Profile::Release) {
            Ok(made) => {
                println!("{made}");
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        },
        Command::Book => {
            let mut report = Report::new(None);
            book::step(&repository, &mut report);
            report.finish()
        }
        Command::ModelCheck { arguments } => model_check(&repository, &arguments),
        Command::Simulate { arguments } => simulate(&repository, &arguments),
        Command::Bless { package, filter } => bless::run(&repository, package.as_deref(), filter.as_deref()),
        Command::LfTests { folder, only, empty_bodies, board, rti } => {
            let mode = match &board {
                Some(board) => lf_tests::TestMode::Image(board),
                None if empty_bodies => lf_tests::TestMode::EmptyBodies,
                None => lf_tests::TestMode::Run(rti.as_deref()),
            };
            lf_tests::run(&repository, &folder, only.as_deref(), &mode)
        }
        Command::Evaluate { arguments } => evaluate::run(&repository, &arguments),
    }
}

/// Millions of states need the optimizer.
fn model_check(repository: &Path, arguments: &[String]) -> ExitCode {
    let run = ["run", "--quiet", "--release", "--package", "lf-model-check", "--"];
    if process::succeeds(process::cargo(repository).args(run).args(arguments)) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Thousands of federations need the optimizer.
fn simulate(repository: &Path, arguments: &[String]) -> ExitCode {
    let run = ["run", "--quiet", "--release", "--package", "lf-simulator", "--"];
    if process::succeeds(process::cargo(repository).args(run).args(arguments)) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn test(repository: &Path, host_only: bool, only: &[String], limit: Option<Duration>) -> ExitCode {
    let mut report = Report::new(limit);
    for (name, step) in STEPS {
        if !only.is_empty() && !only.iter().any(|wanted| wanted == name) {
            continue;
        }
        if host_only && ZEPHYR_STEPS.contains(name) {
            report.skip(name, "--host-only");
            continue;
        }
        report.begin(name);
        step(repository, &mut report);
    }
    report.finish()
}

/// Returns the top of the repository, two folders above this crate.
fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}
