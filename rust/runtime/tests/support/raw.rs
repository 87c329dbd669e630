// SPDX-License-Identifier: Apache-2.0
//! An RTI whose federates one tester plays, message by message: for behavior that our federates do not show.

use std::sync::Mutex;

use lf_coordination::Deadline;
use lf_coordination::heap::{Memory, Sizes};
use lf_coordination::rti::{ClockSync, Config, Outcome, RtiEvent, SetupError};
use lf_model::time::{Instant, Interval};
use lf_runtime::platform::{Endpoint, Interest, Platform as _, SocketId, Transfer};
use lf_runtime::{Inlet, Outgoing, RtiLoop, RtiSetup};
use lf_testkit::messages::{encoded, introduction};
use lf_testkit::network::address_of;
use lf_wire::{Decoded, Limits, Message, MessageType, Tag, UDP_PORT_CLOCK_SYNC_OFF, decode};

use super::federation::{PORT, RTI};
use lf_testkit::world::{Blocking, Conditions, LivenessViolation, Move, Threads, Virtual};

const ID: &[u8] = b"raw";
/// The longest payload that the RTI accepts.
pub(crate) const PAYLOAD_BYTES_MAX: usize = 100;

/// Returns a configuration without clock synchronization.
pub(crate) fn config() -> Config<'static> {
    Config { clock_sync: ClockSync::Off, ..Config::new(ID, PAYLOAD_BYTES_MAX) }
}

/// The RTI's outcome and log events.
#[derive(Debug)]
pub(crate) struct Ended {
    pub outcome: Result<Outcome, SetupError>,
    pub log_events: Vec<String>,
    pub violation: Option<LivenessViolation>,
    /// The writes and reads of the RTI, in order.
    pub moves: Vec<Move>,
}

/// All federates of an RTI, and all other programs that connect to it.
pub(crate) struct Tester {
    me: Blocking,
    /// The connections, and the received bytes of each that are not read yet.
    connections: Vec<(SocketId, Vec<u8>)>,
    start: i64,
}

/// Runs an RTI for this number of federates, with some connections to spare, to its end; `act` plays all others.
pub(crate) fn with_rti(
    config: Config<'static>,
    federates: usize,
    conditions: Conditions,
    act: impl FnOnce(&mut Tester) + Send,
) -> Ended {
    let world = Threads::new(conditions);
    let rti = world.join(Interval::ZERO, Interval::ZERO);
    // By then the RTI listens.
    let tester = world.join(Interval::from_millis(1), Interval::ZERO);
    let log_events = Mutex::new(Vec::new());
    let outcome = std::thread::scope(|scope| {
        let log_events = &log_events;
        let outcome = scope.spawn(move || {
            let mut platform = rti;
            platform.begin();
            run(&mut platform, config, federates, log_events)
        });
        scope.spawn(move || {
            act(&mut Tester { me: Blocking::new(tester), connections: Vec::new(), start: 0 });
        });
        world.start();
        outcome.join().unwrap()
    });
    Ended { outcome, log_events: log_events.into_inner().unwrap(), violation: world.violation(), moves: world.moves() }
}

fn run(
    platform: &mut Virtual,
    config: Config<'static>,
    federates: usize,
    log_events: &Mutex<Vec<String>>,
) -> Result<Outcome, SetupError> {
    let listener = platform.listen(PORT).unwrap();
    let (connections, bytes) = (federates + 2, config.message_bytes_max(federates));
    let mut buffers: Vec<_> = (0..connections).map(|_| (vec![0; bytes], vec![0; bytes])).collect();
    let (mut inlets, mut outgoings): (Vec<_>, Vec<_>) =
        buffers.iter_mut().map(|(input, output)| (Inlet::new(&mut input[..]), Outgoing::new(&mut output[..]))).unzip();
    let mut memory = Memory::new(Sizes { federates, connections, upstream: federates, in_transit: 64 });
    let setup =
        RtiSetup { config, storage: memory.storage(), inlets: &mut inlets, outgoings: &mut outgoings, datagrams: None };
    let mut log = |event: RtiEvent<'_>| log_events.lock().unwrap().push(event.to_string());
    RtiLoop::new(platform, setup, listener, &mut log).map(|mut rti| rti.run())
}

impl Tester {
    /// Opens a connection, and returns its number.
    pub(crate) fn connect(&mut self) -> usize {
        let socket = self.me.connect(Endpoint::new(address_of(RTI), PORT));
        self.connections.push((socket, Vec::new()));
        self.connections.len() - 1
    }

    /// Performs the handshake up to the exchanges of clock synchronization.
    pub(crate) fn introduce(&mut self, connection: usize, id: u16, upstream: &[(u16, i64)], udp_port: u16) {
        let [ids, neighbors, _] = introduction(id, ID, upstream, &[]);
        for message in [ids, neighbors, Message::UdpPort(udp_port)] {
            self.say(connection, &message);
        }
        self.hear(connection, |message| *message == Message::Ack);
    }

    /// Joins federates with these upstream federates and delays, up to the start; returns their connections.
    pub(crate) fn start(&mut self, upstream: &[&[(u16, i64)]]) -> Vec<usize> {
        let join = |(upstream, id): (&&[(u16, i64)], u16)| {
            let connection = self.connect();
            self.introduce(connection, id, upstream, UDP_PORT_CLOCK_SYNC_OFF);
            connection
        };
        let connections: Vec<_> = upstream.iter().zip(0..).map(join).collect();
        for connection in &connections {
            self.say(*connection, &Message::Timestamp(0));
        }
        let mut start = 0;
        for connection in &connections {
            self.hear(*connection, |message| match message {
                Message::Timestamp(time) => {
                    start = *time;
                    true
                }
                _ => false,
            });
        }
        self.start = start;
        connections
    }

    /// Returns the tag this number of nanoseconds after the start.
    pub(crate) fn at(&self, ns: i64) -> Tag {
        Tag::new(self.start + ns, 0)
    }

    /// Sends a message, and waits until the network has taken it.
    pub(crate) fn say(&mut self, connection: usize, message: &Message<'_>) {
        self.say_bytes(connection, &encoded(message));
    }

    pub(crate) fn say_bytes(&mut self, connection: usize, bytes: &[u8]) {
        self.me.say_bytes(self.connections[connection].0, bytes);
    }

    /// Takes messages of a connection until one is `enough`, or the RTI has closed it. Returns whether one was.
    pub(crate) fn hear(&mut self, connection: usize, mut enough: impl FnMut(&Message<'_>) -> bool) -> bool {
        loop {
            let (socket, bytes) = &mut self.connections[connection];
            while let Ok(Decoded::Complete { message, len }) = decode(bytes, &Limits::NONE) {
                let is_enough = enough(&message);
                bytes.drain(..len);
                if is_enough {
                    return true;
                }
            }
            let more = self.me.hear_some(*socket, 64);
            if more.is_empty() {
                return false;
            }
            self.connections[connection].1.extend(more);
        }
    }

    /// Ends this direction of a connection. Closing could reset it and lose messages in transit.
    pub(crate) fn end(&mut self, connection: usize) {
        self.me.platform.shut_down_writing(self.connections[connection].0);
    }

    /// Waits until messages arrive on some of these connections, and takes them.
    pub(crate) fn hear_any(&mut self, connections: &[usize]) -> Vec<(usize, MessageType)> {
        let until = self.now() + Interval::from_secs(120);
        loop {
            let mut heard = Vec::new();
            for index in connections {
                let (socket, bytes) = &mut self.connections[*index];
                let mut buffer = [0; 64];
                if let Ok(Transfer::Bytes(count)) = self.me.platform.read(*socket, &mut buffer) {
                    bytes.extend(&buffer[..count]);
                }
                while let Ok(Decoded::Complete { message, len }) = decode(bytes, &Limits::NONE) {
                    heard.push((*index, message.message_type()));
                    bytes.drain(..len);
                }
                let interest = if heard.is_empty() { Interest::READ } else { Interest::NONE };
                self.me.platform.set_interest(*socket, interest);
            }
            if !heard.is_empty() {
                return heard;
            }
            assert!(!self.me.platform.interrupted() && self.now() < until, "the RTI does nothing");
            self.me.platform.wait(Deadline::At(until), &mut |_, _| {});
        }
    }

    pub(crate) fn now(&mut self) -> Instant {
        self.me.now()
    }
}
