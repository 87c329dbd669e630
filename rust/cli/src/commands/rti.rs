// SPDX-License-Identifier: Apache-2.0
//! `lfz rti`

use std::process::ExitCode;

use lf_linux::log::LevelFilter;
use lf_linux::rti::{Outcome, serve};

use crate::args::RtiArgs;
use crate::failure::Failure;
use crate::terminal;

/// What stands before the port in the line that says where the RTI listens, which `lfz run` reads.
const LISTENING: &str = "listening on TCP port ";

/// Runs the RTI until its federation is over.
pub(super) fn rti(arguments: &RtiArgs) -> Result<ExitCode, Failure> {
    if arguments.version {
        terminal::print(format_args!("RTI of lfz {}", env!("CARGO_PKG_VERSION")))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut warnings = Vec::new();
    let options = arguments.options(&mut warnings)?;
    for warning in warnings {
        terminal::remark(format_args!("warning: {warning}"));
    }
    lf_linux::install_logger(LevelFilter::Info);
    let outcome = serve(&options, |port| {
        // An RTI whose output nobody reads serves its federates all the same.
        let _ = terminal::print(format_args!("{LISTENING}{port}"));
    });
    match outcome.map_err(|error| Failure::message(error.to_string()))? {
        Outcome::Complete => Ok(ExitCode::SUCCESS),
        outcome @ Outcome::Lost { .. } => Err(Failure::message(outcome.to_string())),
        outcome @ Outcome::NotStarted { .. } => Err(Failure::message(format!(
            "{outcome}; start all federates again, or give them more time with --start-time-out"
        ))),
        outcome @ Outcome::Aborted => {
            terminal::remark(format_args!("error: {outcome}"));
            Ok(ExitCode::from(lf_linux::interruption_status()))
        }
    }
}

/// The port in the line that says where the RTI listens.
pub(super) fn listening_port(line: &str) -> Option<u16> {
    line.strip_prefix(LISTENING)?.parse().ok()
}
