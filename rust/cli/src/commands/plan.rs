// SPDX-License-Identifier: Apache-2.0
//! `lfz plan`

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use lf_compiler::maxwait::{Bounds, Offsets};
use lf_compiler::plan::Plan;
use serde::Serialize;

use crate::args::PlanArgs;
use crate::compile::{Program, read_text};
use crate::failure::Failure;
use crate::terminal;

/// Prints the results of the compiler's analysis.
pub(super) fn plan(arguments: &PlanArgs) -> Result<ExitCode, Failure> {
    let plan = Program::load(&arguments.file)?.plan;
    if arguments.wants_offsets() {
        print(&offsets(&plan, arguments)?, arguments.json)?;
    } else {
        print(&plan, arguments.json)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn print(what: &(impl Serialize + ToString), json: bool) -> Result<(), Failure> {
    let mut output = terminal::output();
    if json {
        serde_json::to_writer_pretty(&mut output, what).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        writeln!(output, "{}", what.to_string().trim_end())?;
    }
    Ok(())
}

/// Returns the offsets of a program, from a file of bounds and options.
fn offsets(plan: &Plan, arguments: &PlanArgs) -> Result<Offsets, Failure> {
    if !plan.is_federated() {
        return Err(Failure::message(format!("{} is not federated, so nobody waits for messages", plan.name)));
    }
    let mut bounds = match &arguments.stp {
        None => Bounds::default(),
        Some(file) => read(file, plan)?,
    };
    bounds.latency_ns = arguments.latency.or(bounds.latency_ns);
    bounds.clock_error_ns = arguments.clock_error.or(bounds.clock_error_ns);
    bounds.execution_ns = arguments.execution.or(bounds.execution_ns);
    Offsets::of(plan, &bounds).map_err(|missing| {
        for bound in missing {
            terminal::report(format_args!("error: {bound}"));
        }
        Failure::Reported
    })
}

fn read(file: &Path, plan: &Plan) -> Result<Bounds, Failure> {
    let text = read_text(file).map_err(|error| Failure::message(format!("cannot read {}: {error}", file.display())))?;
    Bounds::parse(&file.display().to_string(), &text, plan).map_err(|errors| {
        errors.iter().for_each(terminal::report);
        Failure::Reported
    })
}
