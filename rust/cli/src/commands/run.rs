// SPDX-License-Identifier: Apache-2.0
//! `lfz run`

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

use lf_compiler::plan::{ClockSync, Plan, Rti};

use super::rti::listening_port;
use crate::args::{PORT_DEFAULT, Platform, RunArgs};
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::guard;
use crate::measure;
use crate::supervisor::{Ending, Interrupts, Limits, Output, Role, Supervisor};
use crate::terminal;

/// The name under which the RTI speaks.
const RTI_NAME: &str = "RTI";

/// Builds all participants for this computer and runs them to their end.
pub(super) fn run(arguments: &RunArgs) -> Result<ExitCode, Failure> {
    let request = Request {
        file: &arguments.file,
        platform: Some(Platform::Host),
        board: None,
        federates: &[],
        deployment: None,
        places: &arguments.places,
    };
    let built = request.build()?;
    if arguments.measure.is_some() && !built.plan.is_decentralized() {
        let name = &built.plan.name;
        return Err(Failure::message(format!(
            "{name} does not ask for decentralized coordination: nobody waits there"
        )));
    }
    let interrupts = Interrupts::of_this_process()?;
    let limits = Limits { run: arguments.timeout, ..Limits::default() };
    let ending = match &built.plan.rti {
        None => alone(&built, arguments, limits, interrupts)?,
        Some(rti) => federation(&built, rti, arguments, limits, interrupts)?,
    };
    if let Some(bounds) = &arguments.measure {
        let measured = measure::read(&built.plan, &built.out)?;
        std::fs::write(bounds, measured.to_yaml(&built.plan))
            .map_err(|error| Failure::message(format!("cannot write {}: {error}", bounds.display())))?;
        terminal::remark(format_args!("{} messages measured: {}", measured.messages, bounds.display()));
    }
    Ok(ExitCode::from(ending.exit_code()))
}

/// A program that is not federated: its output is its own, and so is its exit status.
fn alone(built: &Built, arguments: &RunArgs, limits: Limits, interrupts: Interrupts) -> Result<Ending, Failure> {
    let mut supervisor = Supervisor::new(limits, interrupts, Output::of_this_process([]));
    for (name, program) in &built.programs {
        let mut command = guard::command(program)?;
        command.args(&arguments.arguments);
        supervisor.start(name, Role::Federate, &mut command)?;
    }
    Ok(supervisor.finish()?)
}

/// The RTI, then the federates.
fn federation(
    built: &Built,
    rti: &Rti,
    arguments: &RunArgs,
    limits: Limits,
    interrupts: Interrupts,
) -> Result<Ending, Failure> {
    let names = built.plan.federates.iter().map(|federate| federate.name.as_str());
    let output = Output::of_this_process(std::iter::once(RTI_NAME).chain(names));
    let mut supervisor = Supervisor::new(limits, interrupts, output);
    let id = federation_id(&rti.federation_id);
    let port = match &arguments.rti {
        None => {
            // A program that names no port of its own gets any free one, so that several may run at once.
            let port = if rti.port == PORT_DEFAULT { 0 } else { rti.port };
            let mut command = guard::command(std::env::current_exe()?)?;
            command.arg("rti");
            if let Some(ns) = built.plan.target.log_waits_ns {
                command.args(["--log-waits", &format!("{ns} ns")]);
            }
            supervisor.start(RTI_NAME, Role::Rti, command.args(rti_options(&built.plan, port, &id)))?;
            supervisor.wait_for_line(listening_port)?
        }
        Some(program) => {
            // Another RTI neither chooses a port nor says where it listens; the federates try until it does.
            let port = if rti.port == PORT_DEFAULT { free_port()? } else { rti.port };
            let mut command = guard::command(program)?;
            supervisor.start(RTI_NAME, Role::Rti, command.args(rti_options(&built.plan, port, &id)))?;
            Some(port)
        }
    };
    if let Some(port) = port {
        for federate in &built.plan.federates {
            let program =
                built.programs.get(&federate.name).map(Path::new).ok_or_else(|| {
                    Failure::message(format!("there is no program for the federate {}", federate.name))
                })?;
            let mut command = guard::command(program)?;
            command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", &id]).args(&arguments.arguments);
            if arguments.measure.is_some() {
                command.arg("--observations").arg(measure::file(&built.out, federate));
            }
            supervisor.start(&federate.name, Role::Federate, &mut command)?;
        }
    }
    Ok(match supervisor.finish()? {
        // Which participant failed how has been said; a single number cannot say more than that one did.
        Ending::Failed(_) => Ending::Failed(1),
        ending => ending,
    })
}

/// What the program asks of its RTI, in the stock RTI's words.
fn rti_options(plan: &Plan, port: u16, id: &str) -> Vec<String> {
    let (port, count) = (port.to_string(), plan.federates.len().to_string());
    let mut options = vec!["--id", id, "--port", &port, "--number_of_federates", &count];
    if !plan.target.dnet {
        options.push("--dnet_disabled");
    }
    if plan.target.authentication {
        options.push("--auth");
    }
    // These come last, because the stock RTI does not read the word behind them.
    let (trials, period) = (plan.target.clock_sync_trials.to_string(), plan.target.clock_sync_period_ns.to_string());
    match plan.target.clock_sync {
        ClockSync::Off => options.extend(["--clock_sync", "off"]),
        ClockSync::Init => options.extend(["--clock_sync", "init", "exchanges-per-interval", &trials]),
        ClockSync::On => {
            options.extend(["--clock_sync", "on", "period", &period, "exchanges-per-interval", &trials]);
        }
    }
    options.into_iter().map(str::to_owned).collect()
}

/// A port that nothing listens on now.
fn free_port() -> Result<u16, Failure> {
    Ok(TcpListener::bind((Ipv4Addr::UNSPECIFIED, 0))?.local_addr()?.port())
}

/// An id that no other run has, so that a federate which outlives its federation cannot join another one.
fn federation_id(name: &str) -> String {
    let name: String = name.chars().take(40).collect();
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    format!("{name} {}-{now:x}", std::process::id())
}

#[cfg(test)]
mod tests {
    use super::federation_id;

    #[test]
    fn federation_ids_differ_and_are_short_enough_for_the_wire() {
        let name = "é".repeat(300);
        assert_ne!(federation_id(&name), federation_id(&name));
        assert!(federation_id(&name).len() <= 255);
        assert!(federation_id("Grid").starts_with("Grid "));
    }
}
