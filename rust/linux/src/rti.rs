// SPDX-License-Identifier: Apache-2.0
//! The RTI as a program of this computer.

use std::fmt;
use std::path::PathBuf;

use lf_coordination::heap::{Growing, Memory, Sizes};
use lf_coordination::rti::{AfterLoss, Config, START_REPORT};
pub use lf_coordination::rti::{CLOCK_SYNC_TRIALS, ClockSync, Outcome};
use lf_model::time::Interval;
use lf_runtime::trace::Recording;
use lf_runtime::{AUTHENTICATOR, Inlet, Outgoing, RtiLoop, RtiPorts, RtiSetup, Turn, log_rti_event};

use crate::credentials::{Credentials, CredentialsError};
use crate::noise::NoiseMemory;
use crate::platform::Linux;
use crate::rti_commands::{RtiCommand, RtiCommands};
use crate::trace_file::TraceFile;
pub use crate::trace_file::{TRACE_MIB, TRACE_UNLIMITED};

/// Connections beyond one per federate, so that a rejected peer can learn the reason.
const SPARE_CONNECTIONS: usize = 16;
/// The length of a buffer that has not had to hold more: twice the length of a read, so that the rest of a message
/// takes no room from the next one.
const BUFFER_BYTES_IDLE: usize = 1 << 17;
/// The number of bytes that may wait for a receiver before its senders have to, unless a single message is longer.
const BUFFER_BYTES_USUAL: usize = 1 << 21;
/// The default limit of a message is this part of the computer's memory: it lies in the buffers of its sender and its
/// receiver, which grow by doubling, and there is more than one of each.
const MEMORY_PART: usize = 8;
/// The bounds for the number of different tags of messages in transit to one federate that are stored exactly. In
/// between, the tags of all federates together take 2 MB.
const IN_TRANSIT_MAX: usize = 1024;
const IN_TRANSIT_MIN: usize = 128;
const IN_TRANSIT_ALL: usize = 1 << 17;

/// A recording of events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// Where it is; a file that is there already is replaced.
    pub file: PathBuf,
    /// Its limit, in MiB; then the newest records take the place of the oldest.
    pub limit_mib: u32,
    /// Whether it has the values of messages.
    pub values: bool,
}

/// The user's options for the RTI.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches of a command line")]
pub struct Options {
    /// The number of federates of the federation, at least 1.
    pub federates: u16,
    /// The number of those that may come and go while the federation runs, fewer than all.
    pub transients: u16,
    /// The federation's id.
    pub federation_id: String,
    /// Whether federates have to prove that they know the federation id.
    pub authentication: bool,
    /// The TCP port; 0 lets the system choose.
    pub port: u16,
    /// Clock synchronization.
    pub clock_sync: ClockSync,
    /// Rounds the start time up to a multiple of this.
    pub start_time_multiple: Option<Interval>,
    /// Whether to send DNETs.
    pub dnet: bool,
    /// Whether the others go on when a federate is lost; otherwise the federation is stopped.
    pub go_on_after_loss: bool,
    /// While the federation runs, the RTI logs each participant that waits for longer than this, and what it waits for.
    pub log_waits: Option<Interval>,
    /// The time that the start waits for a federate that was there and has left; `None`: without end.
    pub start_barrier_time_out: Option<Interval>,
    /// A file for events, in the format of federates' recordings.
    pub trace: Option<Trace>,
    /// The longest message payload that is forwarded, in bytes.
    pub payload_bytes_max: usize,
    /// The encryption of its connections.
    pub credentials: Credentials,
    /// Whether it takes commands from standard input: `stop FEDERATE` tells a transient federate with this id to leave.
    pub commands: bool,
}

impl Options {
    /// Returns the default maximum payload in bytes: an eighth of this computer's memory, and at most the protocol's
    /// limit.
    pub fn payload_bytes_max_default() -> usize {
        let system = rustix::system::sysinfo();
        let units = usize::try_from(system.totalram).unwrap_or(usize::MAX);
        let bytes = units.saturating_mul(usize::try_from(system.mem_unit).unwrap_or(1));
        (bytes / MEMORY_PART).min(usize::try_from(u32::MAX).unwrap_or(usize::MAX))
    }

    /// Returns the options of an RTI without clock synchronization for this federation, on a port that the system
    /// chooses.
    pub fn new(federates: u16, federation_id: &str) -> Self {
        let payload_bytes_max = Self::payload_bytes_max_default();
        let Config { start_barrier_time_out, .. } = Config::new(federation_id.as_bytes(), payload_bytes_max);
        Self {
            federates,
            transients: 0,
            start_barrier_time_out,
            log_waits: None,
            trace: None,
            federation_id: federation_id.to_owned(),
            authentication: false,
            port: 0,
            clock_sync: ClockSync::Off,
            start_time_multiple: None,
            dnet: true,
            go_on_after_loss: false,
            payload_bytes_max,
            credentials: Credentials::None,
            commands: false,
        }
    }
}

/// An error that ends the RTI.
#[derive(Debug)]
pub enum RtiError {
    /// A call of the system that every program needs has failed.
    System(std::io::Error),
    /// The trace cannot be written.
    Trace {
        /// The file.
        file: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// Its connections cannot be encrypted.
    Credentials(CredentialsError),
    /// Any error that RTIs of boards have, too.
    Rti(lf_runtime::RtiError),
}

impl fmt::Display for RtiError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => write!(f, "the system has no resources for the RTI: {error}"),
            Self::Trace { file, error } => write!(f, "the trace {} cannot be written: {error}", file.display()),
            Self::Credentials(error) => error.fmt(f),
            Self::Rti(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RtiError {}

/// Runs the RTI of one federation until it is over. Calls `listening` with the port once federates can connect.
///
/// # Errors
/// The reason why there is no RTI.
pub fn serve(options: &Options, listening: impl FnOnce(u16)) -> Result<Outcome, RtiError> {
    let mut host = Linux::new().map_err(RtiError::System)?;
    let keys = options.credentials.encrypt(&mut host).map_err(RtiError::Credentials)?;
    let count = usize::from(options.federates);
    let connections = count + SPARE_CONNECTIONS;
    let mut noise = NoiseMemory::new(keys, connections);
    let mut host = noise.platform(host);
    let create = |trace: &Trace| {
        TraceFile::create(&trace.file, trace.limit_mib)
            .map_err(|error| RtiError::Trace { file: trace.file.clone(), error })
    };
    let mut trace = options.trace.as_ref().map(create).transpose()?;
    let ports = RtiPorts::open(&mut host, options.port, options.clock_sync).map_err(RtiError::Rti)?;
    listening(ports.tcp);

    let in_transit = (IN_TRANSIT_ALL / count.max(1)).clamp(IN_TRANSIT_MIN, IN_TRANSIT_MAX);
    let config = Config {
        authentication: options.authentication.then_some(AUTHENTICATOR),
        clock_sync: options.clock_sync,
        start_time_multiple: options.start_time_multiple,
        dnet: options.dnet,
        after_loss: if options.go_on_after_loss { AfterLoss::GoOn } else { AfterLoss::StopAll },
        start_barrier_time_out: options.start_barrier_time_out,
        start_report: Some(START_REPORT),
        log_waits: options.log_waits,
        transients: options.transients,
        ..Config::new(options.federation_id.as_bytes(), options.payload_bytes_max)
    };
    let buffer = || Growing::new(BUFFER_BYTES_IDLE, BUFFER_BYTES_USUAL, config.message_bytes_max(count));
    let (mut inlets, mut outgoings): (Vec<_>, Vec<_>) =
        (0..connections).map(|_| (Inlet::new(buffer()), Outgoing::new(buffer()))).unzip();
    let mut memory = Memory::new(Sizes { federates: count, connections, upstream: count, in_transit });
    let (inlets, outgoings) = (&mut inlets[..], &mut outgoings[..]);
    let setup = RtiSetup { config, storage: memory.storage(), inlets, outgoings, datagrams: ports.datagrams };
    let mut log = log_rti_event;
    let mut rti = RtiLoop::new(&mut host, setup, ports.listener, &mut log)
        .map_err(|error| RtiError::Rti(lf_runtime::RtiError::Setup(error)))?;
    if let (Some(trace), Some(Trace { values, .. })) = (&mut trace, &options.trace) {
        rti.record(Recording::new(trace, *values));
    }
    let commands = options.commands.then(RtiCommands::of_standard_input).transpose().map_err(RtiError::System)?;
    loop {
        match rti.turn() {
            Turn::Wait(until) => rti.wait(until),
            Turn::Ended(outcome) => return Ok(outcome),
        }
        for RtiCommand::Stop(federate) in commands.iter().flat_map(RtiCommands::pending) {
            if !rti.dismiss(federate) {
                log::warn!("federate {federate} is not there, or not transient: nobody is told to leave");
            }
        }
    }
}
