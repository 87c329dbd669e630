// SPDX-License-Identifier: Apache-2.0
//! The `main` of a generated program.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::PathBuf;
use std::process::ExitCode;
use std::thread::{self, JoinHandle};
use std::{fmt, io};

use lf_model::time::{Interval, Tag};
use lf_model::{Engine, EngineStorage, Program};
use lf_runtime::platform::{Endpoint, IpAddress};
use lf_runtime::trace::Recording;
use lf_runtime::{
    All, Buffers, ClockSync, Description, FederateLoop, Federation, Inbound, Join, Outbound, RunError, UnfederatedLoop,
};

use crate::arguments::{Arguments, Invocation, usage};
use crate::credentials::{Credentials, CredentialsError};
use crate::devices::Simulation;
use crate::noise::NoiseMemory;
use crate::outside::HostOutside;
use crate::parameters::Parameters;
use crate::platform::Linux;
use crate::trace_file::{TRACE_MIB, TraceFile};
use crate::virtual_network;

/// The environment variable with the RTI's address, for programs whose command line does not name one: those that a
/// federate starts.
pub const RTI_VARIABLE: &str = "LF_RTI";

/// The exit status for a wrong command line.
const USAGE: u8 = 2;

/// The minimum size of the receive buffer. Memory is plentiful here, and a larger buffer holds a longer burst of
/// messages before the grant of the first.
const INPUT_BYTES: usize = 1 << 18;
/// The minimum size of the send buffer. A write takes longer than many messages, which a larger buffer collects.
const OUTPUT_BYTES: usize = 1 << 16;
/// The minimum size of a buffer of a connection with another federate.
const PEER_BYTES: usize = 1 << 14;

/// Connections beyond those with other federates: that with the RTI, and those of peers without an id.
const SPARE_CONNECTIONS: usize = 8;

/// Programs of more bytes than this get a stack of their own, on which they are made and live.
const SMALL: usize = 1 << 19;
/// The minimum stack of bodies, the usual one of a process.
const STACK: usize = 8 << 20;
/// Copies of the program that may be on the stack during construction, or of its largest value while a body sets it;
/// without optimization each step makes a copy.
const COPIES: usize = 16;

/// Runs a generated program with this process's command line, which can set the parameters of its main reactor.
pub fn main<P: Program + 'static, S: EngineStorage>(
    parameters: Parameters,
    description: &'static Description,
    program: fn() -> P,
) -> ExitCode {
    let size = size_of::<P>() + size_of::<S>();
    if size <= SMALL {
        return start::<P, S>(&parameters, description, program);
    }
    let stack = size.saturating_mul(COPIES).saturating_add(STACK);
    let thread = thread::Builder::new().name("main".to_owned()).stack_size(stack);
    match thread.spawn(move || start::<P, S>(&parameters, description, program)).map(JoinHandle::join) {
        Ok(Ok(status)) => status,
        Ok(Err(panic)) => std::panic::resume_unwind(panic),
        Err(error) => {
            eprintln!("error: the program needs a stack of {stack} bytes: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Starts the program. Its frame holds all state and all queues.
#[inline(never)]
fn start<P: Program, S: EngineStorage>(
    parameters: &Parameters,
    description: &'static Description,
    program: fn() -> P,
) -> ExitCode {
    let arguments = match Arguments::parse(std::env::args_os(), description.federation.is_some(), parameters) {
        Ok(Invocation::Run(mut arguments)) => {
            if let Some(Err(error)) = std::env::var(RTI_VARIABLE).ok().map(|rti| arguments.inherit_rti(&rti)) {
                eprintln!("error: {RTI_VARIABLE}: {error}");
                return ExitCode::from(USAGE);
            }
            arguments
        }
        Ok(Invocation::Help) => {
            println!("{}{}", usage(description), parameters.usage());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            eprintln!("error: {error}; see --help");
            return ExitCode::from(USAGE);
        }
    };
    if arguments.virtual_time || virtual_network::is_asked_for() {
        HostOutside::begin_virtual_time();
    }
    crate::logger::install(description.logging);
    let script = match arguments.script() {
        Ok(script) => script,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(USAGE);
        }
    };
    // It ends last, however the program ends.
    let _devices = Simulation::begin(description.name, description.federation.is_none(), script, arguments.vcd.clone());
    let (mut program, mut storage) = (program(), S::new());
    let tables = program.tables();
    let engine = Engine::new(tables, &mut storage, arguments.settings(description.settings()));
    match run(description, &arguments, &mut program, engine) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if error.is_interruption() { crate::interruption_status() } else { 1 })
        }
    }
}

fn run(
    description: &Description,
    arguments: &Arguments,
    program: &mut dyn Program,
    engine: Engine<'_>,
) -> Result<(), MainError> {
    let Some(federation) = &description.federation else {
        let mut host = Linux::new().map_err(MainError::System)?;
        let mut trace = arguments.create_trace()?;
        let mut alone = UnfederatedLoop::new(&mut host, program, engine);
        if let Some(trace) = &mut trace {
            alone.record(Recording::new(trace, arguments.trace_values));
        }
        return alone.run().map_err(MainError::Run);
    };
    // A host name may take its time, and ^C ends that while the signals have not been taken over.
    let addresses = rti_addresses(arguments, federation)?;
    let (&rti, others) = addresses.split_first().expect("a host without an address is unknown");
    let mut host = Linux::new().map_err(MainError::System)?;
    if cfg!(feature = "encrypted") && arguments.credentials == Credentials::None {
        return Err(MainError::Credentials(CredentialsError::Missing));
    }
    let keys = arguments.credentials.encrypt(&mut host).map_err(MainError::Credentials)?;
    let is_virtual = host.is_virtual();
    let mut noise = NoiseMemory::new(keys, federation.peers_in.len() + federation.peers_out.len() + SPARE_CONNECTIONS);
    let mut host = noise.platform(host);
    let is_elsewhere = || is_virtual || !addresses.iter().any(|address| is_own_address(*address));
    let input_bytes = federation.input_bytes.max(INPUT_BYTES);
    let mut federation = Federation { window: federation.window_of(engine.tables(), input_bytes), ..*federation };
    if !federation.local_clock_sync && !is_elsewhere() {
        (federation.clock_sync, federation.test_offset) = (ClockSync::Off, Interval::ZERO);
    }
    let federation = &federation;
    let mut trace = arguments.create_trace()?;
    let federation_id = arguments.federation_id.as_deref().unwrap_or(federation.federation_id);
    description.check_key(federation_id.as_bytes());
    HostOutside::of_program().set_federation_id(federation_id);
    let mut input = vec![0; input_bytes];
    let mut output = vec![0; federation.output_bytes.max(OUTPUT_BYTES)];
    let mut peer_inputs = vec![vec![0; federation.peer_input_bytes.max(PEER_BYTES)]; federation.peers_in.len()];
    let mut peer_outputs = vec![vec![0; federation.peer_output_bytes.max(PEER_BYTES)]; federation.peers_out.len()];
    let mut inbound: Vec<_> = peer_inputs.iter_mut().map(|bytes| Inbound::new(bytes)).collect();
    let mut outbound: Vec<_> = peer_outputs.iter_mut().map(|bytes| Outbound::new(bytes)).collect();
    let buffers = Buffers::new(&mut input, &mut output).with_peers(&mut outbound, &mut inbound);
    let join = Join { federation_id: federation_id.as_bytes(), rti, others };
    let mut known = vec![Tag::NEVER; federation.awaited.len()];
    let mut federate = FederateLoop::<_, All>::new(&mut host, program, engine, federation, &join, buffers, &mut known)
        .map_err(MainError::Run)?;
    if let Some(trace) = &mut trace {
        federate.record(Recording::new(trace, arguments.trace_values));
    }
    federate.run().map_err(MainError::Run)
}

impl Arguments {
    /// Creates the file of what happens, if the user wants one.
    fn create_trace(&self) -> Result<Option<TraceFile>, MainError> {
        let Some(path) = &self.trace else { return Ok(None) };
        let created = TraceFile::create(path, self.trace_limit.unwrap_or(TRACE_MIB));
        created.map(Some).map_err(|error| MainError::Trace { path: path.clone(), error })
    }
}

/// Returns the addresses of the RTI's host, from the command line or else from the program: at least one. Those of IPv4
/// come first, because the stock programs of a federation have no others, and federates find each other in one family.
fn rti_addresses(arguments: &Arguments, federation: &Federation) -> Result<Vec<Endpoint>, MainError> {
    let host = arguments.rti_host.as_deref().unwrap_or(federation.rti_host);
    let port = arguments.rti_port.unwrap_or(federation.rti_port);
    let unknown = |reason: String| MainError::Resolve { host: host.to_owned(), reason };
    let found = (host, port).to_socket_addrs().map_err(|error| unknown(error.to_string()))?;
    let addresses = in_order(found);
    if addresses.is_empty() { Err(unknown("it has no address".to_owned())) } else { Ok(addresses) }
}

/// Returns the addresses of a host in the order in which they are tried, each once.
fn in_order(found: impl Iterator<Item = SocketAddr>) -> Vec<Endpoint> {
    let mut addresses = Vec::new();
    for address in found.map(Endpoint::from) {
        if !addresses.contains(&address) {
            addresses.push(address);
        }
    }
    addresses.sort_by_key(|address| !matches!(address.ip, IpAddress::V4(_)));
    addresses
}

/// Returns whether this computer has this address, and with it the clock of the RTI there.
fn is_own_address(address: Endpoint) -> bool {
    let address = SocketAddr::from(address);
    let any: IpAddr = if address.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
    // Connecting a UDP socket sends nothing: it looks up the route, and a route to oneself begins at the same address.
    let begins_there = || -> io::Result<bool> {
        let socket = UdpSocket::bind((any, 0))?;
        socket.connect(address)?;
        Ok(socket.local_addr()?.ip() == address.ip())
    };
    address.ip().is_loopback() || begins_there().unwrap_or(false)
}

/// An error that ends a program early.
#[derive(Debug)]
enum MainError {
    /// A call of the system that every program needs has failed.
    System(io::Error),
    /// The trace cannot be written.
    Trace { path: PathBuf, error: io::Error },
    /// The connections cannot be encrypted.
    Credentials(CredentialsError),
    /// The RTI's host is unknown.
    Resolve { host: String, reason: String },
    /// The event loop ended early.
    Run(RunError),
}

impl MainError {
    fn is_interruption(&self) -> bool {
        matches!(self, Self::Run(RunError::Interrupted))
    }
}

impl fmt::Display for MainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => write!(f, "the system has no resources for this program: {error}"),
            Self::Credentials(error) => error.fmt(f),
            Self::Trace { path, error } => write!(f, "the trace {} cannot be written: {error}", path.display()),
            Self::Resolve { host, reason } => {
                write!(f, "the RTI's host \"{host}\" is unknown ({reason}): name it with --rti HOST:PORT")
            }
            Self::Run(error) => error.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> Endpoint {
        Endpoint::new(text.parse::<IpAddr>().expect("an address"), 15045)
    }

    #[test]
    fn the_addresses_of_this_computer_are_told_from_others() {
        for own in ["127.0.0.1", "127.1.2.3", "::1"] {
            assert!(is_own_address(address(own)), "{own}");
        }
        // Addresses without a host, in blocks for documentation and for multicast.
        for other in ["198.51.100.77", "233.252.0.1", "2001:db8::77"] {
            assert!(!is_own_address(address(other)), "{other}");
        }
    }

    #[test]
    fn all_addresses_of_a_host_are_tried_those_of_ipv4_first() {
        let found = ["::1", "10.0.0.1", "fd00::1", "::ffff:10.0.0.1", "127.0.0.1"];
        let found = found.iter().map(|text| SocketAddr::new(text.parse().expect("an address"), 15045));
        assert_eq!(in_order(found), ["10.0.0.1", "127.0.0.1", "::1", "fd00::1"].map(address));
    }
}
