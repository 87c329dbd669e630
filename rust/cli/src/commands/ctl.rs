// SPDX-License-Identifier: Apache-2.0
//! `lfz ctl`

use std::process::ExitCode;

use crate::args::{CtlArgs, CtlVerb};
use crate::control::{self, ControlRequest};
use crate::failure::Failure;
use crate::terminal;

/// Asks a run of this user for something, and prints its answer; without a verb, prints all runs.
pub(super) fn ctl(arguments: &CtlArgs) -> Result<ExitCode, Failure> {
    let runs = control::runs()?;
    let request = match &arguments.verb {
        None => {
            let chosen = runs.into_iter().filter(|run| arguments.run.is_none_or(|chosen| chosen == *run));
            for run in chosen {
                terminal::print(control::ask(run, &ControlRequest::List)?)?;
            }
            return Ok(ExitCode::SUCCESS);
        }
        Some(CtlVerb::Start { federate }) => ControlRequest::Start(federate.clone()),
        Some(CtlVerb::Stop { federate }) => ControlRequest::Stop(federate.clone()),
        Some(CtlVerb::Swap { federate }) => ControlRequest::Swap(federate.clone()),
    };
    let run = match (arguments.run, runs.as_slice()) {
        (Some(run), runs) if runs.contains(&run) => run,
        (Some(run), _) => {
            return Err(Failure::message(format!("there is no run {run}; `lfz ctl` shows those there are")));
        }
        (None, [run]) => *run,
        (None, []) => return Err(Failure::message("no federation of yours runs: start one with `lfz run`")),
        (None, _) => {
            return Err(Failure::message("several federations run: choose one with --run, as `lfz ctl` shows them"));
        }
    };
    let answer = control::ask(run, &request)?;
    match answer.strip_prefix("error: ") {
        Some(error) => Err(Failure::message(error)),
        None => Ok(terminal::print(answer).map(|()| ExitCode::SUCCESS)?),
    }
}
