// SPDX-License-Identifier: Apache-2.0
//! One run of a program that is built.

use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;

use lf_compiler::emit::rti_name;
use lf_compiler::plan::{ClockSync, Rti};
use lf_linux::rti::TRACE_UNLIMITED;

use crate::args::{PORT_DEFAULT, Platform, RunArgs};
use crate::commands::rti::options_for;
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::federation::{Argument, Federation, FederationId, LateValue, Process, Version};
use crate::guard;
use crate::keys::{HandedOut, KeySource};
use crate::pins::{self, PinRecording};
use crate::supervisor::{Ending, Interrupts, Streams};
use crate::terminal;
use crate::trace;
use crate::virtual_network::VirtualNetwork;

/// Returns the request to build the program for this computer.
pub(super) fn request(arguments: &RunArgs) -> Request<'_> {
    Request { platform: Some(Platform::Host), ..Request::new(&arguments.file, &arguments.places) }
}

/// Runs a program to its end.
pub(super) fn run_once(
    built: &Built,
    arguments: &RunArgs,
    interrupts: impl FnOnce() -> io::Result<Interrupts>,
) -> Result<Ending, Failure> {
    if arguments.measure.is_some() && !built.plan.is_decentralized() {
        let name = &built.plan.name;
        return Err(Failure::message(format!(
            "{name} does not ask for decentralized coordination: nobody waits there"
        )));
    }
    if let Some(script) = &arguments.devices {
        pins::check_script(script, &built.plan)?;
    }
    let recording = Recording::of(built, arguments);
    if let Some(recording) = &recording {
        trace::prepare(&built.plan, &recording.folder)?;
    }
    let keys = keys(built, arguments)?;
    let network = arguments.seed.map(|seed| network(built, seed)).transpose()?.flatten();
    let interrupts = interrupts()?;
    let mut federation = federation(built, arguments, recording.as_ref(), keys.as_ref())?;
    if let Some(network) = &network {
        take_part(&mut federation, network);
    }
    let ending = federation.run(interrupts)?;
    if let Some(violation) = network.as_ref().and_then(VirtualNetwork::violation) {
        terminal::report(format_args!("error: {violation}"));
    }
    if let (Some(bounds), Some(Recording { folder, .. })) = (&arguments.measure, &recording) {
        let messages = trace::write_bounds(folder, None, bounds)?;
        terminal::inform(format_args!("{messages} messages measured: {}", bounds.display()));
    }
    if let Some(folder) = &arguments.trace {
        let folder = folder.display();
        terminal::inform(format_args!("recorded in {folder}: see it with `lfz trace {folder}`"));
    }
    Ok(ending)
}

/// Returns the virtual network of a federation; a program that is not federated needs none.
fn network(built: &Built, seed: u64) -> Result<Option<VirtualNetwork>, Failure> {
    let plan = &built.plan;
    if plan.rti.is_none() {
        return Ok(None);
    }
    let refused = |reason: &str| Err(Failure::message(format!("--seed: {reason}")));
    if plan.transients() > 0 {
        return refused("transient federates come when the user starts them, which is not possible in virtual time");
    }
    if plan.target.security.is_tls() {
        return refused("a virtual network has no TLS: write `security: noise` instead of `comm-type: TLS`");
    }
    let participants = 1 + plan.federates.len();
    if participants > VirtualNetwork::PARTICIPANTS_MAX {
        return refused("a virtual network has addresses for 253 federates");
    }
    Ok(Some(VirtualNetwork::begin(seed, participants, plan.target.clock_sync != ClockSync::Off)?))
}

/// Makes the RTI and the federates participants of a virtual network.
fn take_part(federation: &mut Federation, network: &VirtualNetwork) {
    // A run is to be the same each time, and nobody else reaches its RTI.
    if let FederationId::BeginsWith(name) = &federation.id {
        federation.id = FederationId::Exactly(name.clone());
    }
    for (number, process) in federation.rti.iter_mut().chain(&mut federation.federates).enumerate() {
        process.environment.extend([network.variable(number)]);
    }
}

/// Hands out the keys of a federation that asks for encryption: those of its folder, or else new ones.
fn keys(built: &Built, arguments: &RunArgs) -> Result<Option<HandedOut>, Failure> {
    let source = KeySource { file: &arguments.file, given: arguments.keys.as_deref(), deployment: None };
    let rti = rti_name(&built.plan);
    let names = std::iter::once(rti.as_str()).chain(built.programs.keys().map(String::as_str));
    let keys = source.hand_out(&built.plan, &built.out, &names.collect::<Vec<_>>(), true)?;
    match &keys {
        Some(HandedOut { is_of_run: true, .. }) => {
            terminal::report("connections are encrypted with keys for this run; `lfz keys new` makes lasting ones");
        }
        Some(HandedOut { strangers, .. }) if !strangers.is_empty() => {
            terminal::report(format_args!("warning: nobody trusts {}, which has no key", strangers.join(", ")));
        }
        _ => {}
    }
    Ok(keys)
}

/// The folder of recordings, and their options.
struct Recording {
    folder: PathBuf,
    limit_mib: u32,
    values: bool,
}

impl Recording {
    /// Returns the recording that the user asks for, or that measuring needs.
    fn of(built: &Built, arguments: &RunArgs) -> Option<Self> {
        if let Some(folder) = arguments.trace.clone() {
            return Some(Self { folder, limit_mib: arguments.trace_limit, values: arguments.trace_values });
        }
        let measures = arguments.measure.is_some();
        measures.then(|| Self { folder: built.out.join(trace::MEASURED), limit_mib: TRACE_UNLIMITED, values: false })
    }

    /// Returns the options with which a participant records.
    fn options(&self, participant: &str) -> impl Iterator<Item = Argument> {
        let file = trace::file(&self.folder, participant);
        let limit = ["--trace-limit".into(), self.limit_mib.to_string().into()];
        let values = self.values.then(|| "--trace-values".into());
        ["--trace".into(), file.into()].into_iter().chain(limit).chain(values)
    }
}

/// Returns the RTI and the federates; for a program that is not federated only itself, whose output is its own.
fn federation(
    built: &Built,
    arguments: &RunArgs,
    recording: Option<&Recording>,
    keys: Option<&HandedOut>,
) -> Result<Federation, Failure> {
    let planned = built.plan.rti.as_ref();
    let name = planned.map_or(&built.plan.name, |rti| &rti.federation_id);
    let rti = planned.map(|rti| rti_process(built, rti, arguments, recording, keys)).transpose()?;
    if let Some(unknown) =
        arguments.without.iter().find(|name| planned.is_none() || !built.programs.contains_key(*name))
    {
        let known = planned.map(|_| built.programs.keys().cloned().collect::<Vec<_>>().join(", "));
        let known = known.unwrap_or_else(|| "no federates, as it is not federated".to_owned());
        return Err(Failure::message(format!("--without: there is no federate `{unknown}`; {name} has {known}")));
    }
    let pins = arguments.vcd.as_ref().map(|file| PinRecording::of(&built.plan, &built.out, file));
    let (mut federates, mut left_out) = (Vec::new(), Vec::new());
    for federate in &built.plan.federates {
        let name = &federate.name;
        let program = built.programs.get(name);
        let program =
            program.ok_or_else(|| Failure::message(format!("there is no program for the federate {name}")))?;
        let mut words = vec![Argument::from(program)];
        if let Some(planned) = planned {
            let address = rti_address(planned, arguments);
            words.extend(["--rti".into(), Argument::known(address, LateValue::RtiPort)]);
            words.extend(["--id".into(), Argument::known("", LateValue::FederationId)]);
        }
        if let Some(keys) = keys {
            words.extend(keys.options(name, true)?.into_iter().map(Argument::from));
        }
        words.extend((planned.is_none() && arguments.seed.is_some()).then(|| "--virtual-time".into()));
        words.extend(arguments.arguments.iter().map(Argument::from));
        words.extend(recording.into_iter().flat_map(|recording| recording.options(name)));
        if let Some(script) = &arguments.devices {
            words.extend(["--devices".into(), script.into()]);
        }
        if let Some(file) = pins.as_ref().and_then(|pins| pins.file_of(name)) {
            words.extend(["--vcd".into(), file.into()]);
        }
        // The only one gets the input of this program.
        let streams = if planned.is_none() { Streams::Own } else { Streams::Lines };
        let transient = federate.transient;
        let process = Process { name: name.clone(), words, transient, streams, ..Process::default() };
        if arguments.without.contains(name) { left_out.push(process) } else { federates.push(process) }
    }
    let (rti, rti_port) = rti.unzip();
    Ok(Federation {
        version: Version,
        speaker: planned.map(|_| "lfz".to_owned()),
        id: FederationId::BeginsWith(name.clone()),
        user: None,
        timeout_ns: arguments.timeout.map(|timeout| u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX)),
        grace_ns: None,
        terminate_ns: None,
        rti,
        rti_port: rti_port.flatten(),
        federates,
        left_out,
        oscilloscope: pins,
    })
}

/// Returns the RTI that runs beside the federates, and its port if it does not print that itself.
fn rti_process(
    built: &Built,
    rti: &Rti,
    arguments: &RunArgs,
    recording: Option<&Recording>,
    keys: Option<&HandedOut>,
) -> Result<(Process, Option<u16>), Failure> {
    let is_any = rti.port == PORT_DEFAULT && arguments.seed.is_none();
    let (mut words, port, is_told) = match &arguments.rti {
        // It listens when all have come, so the federates have to know its port before.
        None if arguments.seed.is_some() => (vec![guard::THIS_PROGRAM.into(), "rti".into()], rti.port, Some(rti.port)),
        // A program without a port of its own gets any free one, so that several may run at once.
        None => (vec![guard::THIS_PROGRAM.into(), "rti".into()], if is_any { 0 } else { rti.port }, None),
        // Another RTI neither chooses a port nor prints it; the federates try until it listens.
        Some(program) => {
            let port = if is_any { free_port()? } else { rti.port };
            (vec![program.into()], port, Some(port))
        }
    };
    words.extend([
        "--id".into(),
        Argument::known("", LateValue::FederationId),
        "--port".into(),
        port.to_string().into(),
    ]);
    if let Some(recording) = recording.filter(|_| arguments.rti.is_none()) {
        words.extend(recording.options("RTI"));
    }
    if let Some(keys) = keys {
        let options = keys.options(&rti_name(&built.plan), arguments.rti.is_none())?;
        words.extend(options.into_iter().map(Argument::from));
    }
    words.extend(options_for(&built.plan, arguments.rti.is_none()).into_iter().map(Argument::from));
    Ok((Process { name: "RTI".to_owned(), words, ..Process::default() }, is_told))
}

/// Returns the address of the RTI: on this computer, of the family of the one that the program names. Another RTI may
/// have no IPv6, as the stock one.
fn rti_address(rti: &Rti, arguments: &RunArgs) -> &'static str {
    if arguments.seed.is_some() {
        return "10.0.0.1:";
    }
    if rti.host.contains(':') && arguments.rti.is_none() { "[::1]:" } else { "127.0.0.1:" }
}

/// Returns a port without a listener.
fn free_port() -> io::Result<u16> {
    Ok(TcpListener::bind((Ipv4Addr::UNSPECIFIED, 0))?.local_addr()?.port())
}
