// SPDX-License-Identifier: Apache-2.0
//! `lfz rti`

use std::fs::{self, File};
use std::process::ExitCode;

use lf_compiler::plan::{ClockSync, Plan};
use lf_linux::log::LevelFilter;
use lf_linux::rti::{Outcome, serve};

use crate::args::RtiArgs;
use crate::failure::Failure;
use crate::terminal;
use crate::trace::{self, Table};

/// The text before the port in the line that announces the RTI's port, which the supervisor reads.
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
        terminal::report(format_args!("warning: {warning}"));
    }
    // A connection never touches most of its buffers, and small pages suffice for the rest. The call may fail: an RTI
    // with huge pages only takes more memory.
    let _ = rustix::thread::disable_transparent_huge_pages(true);
    // `lfz run` starts it by a path that does not end with its name.
    let _ = rustix::thread::set_name(c"lfz");
    lf_linux::install_logger(LevelFilter::Info);
    let tables = arguments.tables();
    for Table { file, .. } in &tables {
        // An unwritable file is to be reported now.
        File::create(file)
            .map_err(|error| Failure::message(format!("the trace {} cannot be written: {error}", file.display())))?;
    }
    let outcome = serve(&options, |port| {
        // An RTI whose output is not read serves its federates all the same.
        let _ = terminal::print(format_args!("{LISTENING}{port}"));
    });
    let converted = match &options.trace {
        Some(trace) if !tables.is_empty() => trace::convert_rti(&trace.file, &tables),
        _ => Ok(()),
    };
    if let Some(trace) = options.trace.filter(|_| !arguments.keeps_trace() && (converted.is_ok() || outcome.is_err())) {
        fs::remove_file(&trace.file)?;
    }
    let outcome = outcome.map_err(|error| Failure::message(error.to_string()))?;
    converted?;
    match outcome {
        Outcome::Complete => Ok(ExitCode::SUCCESS),
        outcome @ Outcome::Lost { .. } => Err(Failure::message(outcome.to_string())),
        outcome @ Outcome::NotStarted { .. } => Err(Failure::message(format!(
            "{outcome}; start all federates again, or give them more time with --start-time-out"
        ))),
        outcome @ Outcome::Aborted => {
            terminal::report(format_args!("error: {outcome}"));
            Ok(ExitCode::from(lf_linux::interruption_status()))
        }
    }
}

/// Returns a program's options for its RTI, in the stock RTI's words, and for ours also those that the stock RTI lacks.
pub(super) fn options_for(plan: &Plan, is_ours: bool) -> Vec<String> {
    let target = &plan.target;
    let mut options = vec!["--number_of_federates".to_owned(), plan.federates.len().to_string()];
    if plan.transients() > 0 {
        options.extend(["--number_of_transient_federates".to_owned(), plan.transients().to_string()]);
    }
    if let Some(ns) = target.log_waits_ns.filter(|_| is_ours) {
        options.extend(["--log-waits".to_owned(), format!("{ns} ns")]);
    }
    options.extend((!target.dnet).then(|| "--dnet_disabled".to_owned()));
    options.extend(target.authentication.then(|| "--auth".to_owned()));
    // These come last, because the stock RTI does not read the word behind them.
    let (trials, period) = (target.clock_sync_trials.to_string(), target.clock_sync_period_ns.to_string());
    let clock_sync: &[&str] = match target.clock_sync {
        ClockSync::Off => &["off"],
        ClockSync::Init => &["init", "exchanges-per-interval", &trials],
        ClockSync::On => &["on", "period", &period, "exchanges-per-interval", &trials],
    };
    options.extend(["--clock_sync"].iter().chain(clock_sync).map(|word| (*word).to_owned()));
    options
}

/// Returns the port in the line that announces the RTI's port.
pub(crate) fn listening_port(line: &str) -> Option<u16> {
    line.strip_prefix(LISTENING)?.parse().ok()
}
