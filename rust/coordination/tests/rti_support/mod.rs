// SPDX-License-Identifier: Apache-2.0
//! An RTI with its connections in memory, for tests.
#![allow(dead_code, unreachable_pub, reason = "every test file uses another part of it")]

pub mod dialogue;
pub mod peer;
pub mod plain;

use std::convert::Infallible;
use std::net::Ipv4Addr;

use lf_coordination::auth::AUTHENTICATOR;
use lf_coordination::heap::Memory;
use lf_coordination::rti::{ClockSync, Config, ConnectionId, Datagram, Outlet, Rti, RtiEvent, Verdict};
use lf_coordination::{Deadline, Endpoint, IpAddress, clock_sync};
use lf_model::time::{Instant, Interval};
use lf_testkit::golden::RtiSetup;
use lf_testkit::golden::replay::{self, Received};
use lf_testkit::messages::encoded;
use lf_wire::Message;

/// One connection: what the RTI has sent and nobody has read yet, and what it has not consumed yet.
#[derive(Default)]
pub struct Wire {
    pub outgoing: Vec<u8>,
    pub incoming: Vec<u8>,
    pub open: bool,
    /// The peer has closed it, and reads and says no more.
    pub closing: bool,
    /// The RTI's direction is closed.
    pub ended: bool,
    /// What the input waits for.
    pub blocked: Option<Awaited>,
}

/// What the input of a connection waits for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Awaited {
    /// Room on this connection.
    Room(ConnectionId),
    /// Input of this connection.
    Input(ConnectionId),
}

impl Awaited {
    fn connection(self) -> ConnectionId {
        match self {
            Self::Room(connection) | Self::Input(connection) => connection,
        }
    }
}

/// The connections, as the RTI sees them.
pub struct Wires {
    pub list: Vec<Wire>,
    pub capacity: usize,
    pub notices: Vec<String>,
}

impl Outlet for Wires {
    fn room(&self, connection: ConnectionId) -> usize {
        self.capacity - self.list[connection.0].outgoing.len()
    }

    fn send(&mut self, connection: ConnectionId, message: &Message<'_>) {
        let wire = &mut self.list[connection.0];
        assert!(wire.open && !wire.ended, "{message:?} is sent on a connection that is closed");
        if !wire.closing {
            wire.outgoing.extend(encoded(message));
        }
        assert!(wire.outgoing.len() <= self.capacity, "{message:?} is sent although there is no room");
    }

    fn half_close(&mut self, connection: ConnectionId) {
        self.list[connection.0].ended = true;
    }

    fn close(&mut self, connection: ConnectionId) {
        let wire = &mut self.list[connection.0];
        (wire.ended, wire.open, wire.blocked) = (true, false, None);
        wire.incoming.clear();
    }

    fn log(&mut self, event: RtiEvent<'_>) {
        self.notices.push(event.to_string());
    }
}

/// How much memory the RTI gets.
#[derive(Clone, Copy)]
pub struct Sizes {
    pub federates: usize,
    pub connections: usize,
    pub upstream: usize,
    pub in_transit: usize,
    /// Bytes of every connection's output.
    pub output: usize,
}

impl Sizes {
    pub fn ample(federates: usize) -> Self {
        Self { federates, connections: federates + 2, upstream: federates, in_transit: 1000, output: 1 << 20 }
    }
}

/// An RTI with its connections.
pub struct World {
    pub rti: Rti<'static>,
    pub outlet: Wires,
    pub now: Instant,
    /// Input is offered in pieces of this many bytes.
    pub piece: usize,
    stopping: bool,
    /// Times are sent as soon as they are due, for which time passes.
    pub tells_times: bool,
    /// How many nonces the RTI has got.
    pub nonces: u64,
}

impl World {
    pub fn new(config: Config<'static>, sizes: Sizes) -> Self {
        let Sizes { federates, connections, upstream, in_transit, output } = sizes;
        let memory = Memory::new(lf_coordination::heap::Sizes { federates, connections, upstream, in_transit });
        // Tests end soon, so their memory may stay.
        let rti = Rti::new(config, Box::leak(Box::new(memory)).storage()).expect("the storage fits");
        let list = (0..connections).map(|_| Wire::default()).collect();
        let outlet = Wires { list, capacity: output, notices: Vec::new() };
        Self {
            rti,
            outlet,
            now: Instant::from_nanos(1_000),
            piece: usize::MAX,
            stopping: false,
            tells_times: true,
            nonces: 0,
        }
    }

    pub fn connect(&mut self) -> ConnectionId {
        self.connect_from(IpAddress::V4(Ipv4Addr::LOCALHOST))
    }

    pub fn connect_from(&mut self, address: IpAddress) -> ConnectionId {
        let free = self.outlet.list.iter().position(|wire| !wire.open && wire.outgoing.is_empty());
        let connection = ConnectionId(free.expect("there are enough connections"));
        self.outlet.list[connection.0] = Wire { open: true, ..Wire::default() };
        // Each connection gets another one, and every run the same ones.
        self.nonces += 1;
        let nonce = self.nonces.to_le_bytes();
        self.rti.handle_connect(self.now, connection, address, nonce, &mut self.outlet);
        connection
    }

    pub fn send(&mut self, connection: ConnectionId, bytes: &[u8]) {
        for piece in bytes.chunks(self.piece.min(bytes.len().max(1))) {
            if self.outlet.list[connection.0].open {
                self.outlet.list[connection.0].incoming.extend(piece);
                self.pump(connection);
            }
        }
        self.resume();
    }

    pub fn message(&mut self, connection: ConnectionId, message: &Message<'_>) {
        self.send(connection, &encoded(message));
    }

    /// Offers what has come on a connection, as far as the RTI takes it.
    pub fn pump(&mut self, connection: ConnectionId) {
        self.offer(connection);
        if self.tells_times {
            self.exchange();
        }
        self.let_go_on(Awaited::Input(connection));
        if !self.stopping && self.rti.stop_tag().is_some() {
            self.stopping = true;
            (0..self.outlet.list.len()).for_each(|index| self.let_go_on(Awaited::Input(ConnectionId(index))));
        }
    }

    /// Lets the times be sent for which nobody has to do anything but wait.
    fn exchange(&mut self) {
        while let due @ (Deadline::Now | Deadline::At(_)) = self.rti.poll_exchange_timeout() {
            if let (Deadline::At(time), None) = (due, self.rti.exchanging()) {
                self.now = self.now.max(time);
            }
            if self.rti.poll_exchange(self.now, &mut self.outlet).is_none() {
                return;
            }
        }
    }

    fn let_go_on(&mut self, awaited: Awaited) {
        let waits = |wire: &Wire| wire.blocked == Some(awaited);
        let waiting: Vec<_> = (0..self.outlet.list.len()).filter(|i| waits(&self.outlet.list[*i])).collect();
        for index in waiting {
            self.pump(ConnectionId(index));
        }
    }

    fn offer(&mut self, connection: ConnectionId) {
        loop {
            let bytes = std::mem::take(&mut self.outlet.list[connection.0].incoming);
            let verdict = self.rti.handle_input(self.now, connection, &bytes, &mut self.outlet);
            let wire = &mut self.outlet.list[connection.0];
            wire.incoming = bytes;
            wire.blocked = None;
            match verdict {
                Verdict::Consumed(len) => {
                    assert!(len > 0 && len <= wire.incoming.len());
                    wire.incoming.drain(..len);
                    continue;
                }
                Verdict::Incomplete(need) => {
                    assert!(need > wire.incoming.len());
                    if wire.closing {
                        wire.open = false;
                        self.rti.handle_disconnect(self.now, connection, &mut self.outlet);
                    }
                }
                Verdict::Blocked(on) => wire.blocked = Some(Awaited::Room(on)),
                Verdict::Held(until) | Verdict::HeldReadOn(until) => wire.blocked = Some(Awaited::Input(until)),
                Verdict::Closed => wire.incoming.clear(),
            }
            return;
        }
    }

    /// Takes what the RTI has sent, up to so many bytes, and lets it go on with the room.
    pub fn take(&mut self, connection: ConnectionId, max: usize) -> Vec<u8> {
        let wire = &mut self.outlet.list[connection.0];
        let taken: Vec<u8> = wire.outgoing.drain(..max.min(wire.outgoing.len())).collect();
        if !taken.is_empty() {
            self.rti.handle_writable(self.now, connection, &mut self.outlet);
            self.let_go_on(Awaited::Room(connection));
        }
        taken
    }

    /// The peer closes a connection. What it has said before still counts.
    pub fn close(&mut self, connection: ConnectionId) {
        let wire = &mut self.outlet.list[connection.0];
        wire.outgoing.clear();
        if wire.open && !std::mem::replace(&mut wire.closing, true) {
            self.rti.handle_end(connection);
            self.pump(connection);
        }
        self.resume();
    }

    /// Offers input again that waits for connections which have been closed.
    fn resume(&mut self) {
        let wires = &self.outlet.list;
        let is_gone = |on: Awaited| wires[on.connection().0].ended || !wires[on.connection().0].open;
        if let Some(index) = wires.iter().position(|wire| wire.blocked.is_some_and(is_gone)) {
            self.pump(ConnectionId(index));
            self.resume();
        }
    }
}

/// The RTI of a recording.
pub struct Recorded {
    pub world: World,
    /// Connections by their numbers in the recording.
    connections: std::collections::BTreeMap<u16, ConnectionId>,
    /// On their way to the federates.
    datagrams: Vec<Datagram>,
}

impl Recorded {
    pub fn new(setup: &RtiSetup, piece: usize) -> Self {
        let federates = usize::from(setup.federates);
        let mut world = World::new(config(setup), Sizes::ample(federates));
        world.piece = piece;
        Self { world, connections: std::collections::BTreeMap::new(), datagrams: Vec::new() }
    }

    fn udp_address(federate: u16) -> Endpoint {
        Endpoint::new(Ipv4Addr::LOCALHOST, 40_000 + federate)
    }
}

impl replay::Rti for Recorded {
    type Error = Infallible;

    fn connect(&mut self, connection: u16) -> Result<(), Infallible> {
        let id = self.world.connect();
        self.connections.insert(connection, id);
        Ok(())
    }

    fn send(&mut self, connection: u16, bytes: &[u8]) -> Result<(), Infallible> {
        self.world.send(self.connections[&connection], bytes);
        Ok(())
    }

    fn close(&mut self, connection: u16) -> Result<(), Infallible> {
        self.world.close(self.connections[&connection]);
        Ok(())
    }

    fn bind(&mut self, federate: u16) -> Result<u16, Infallible> {
        Ok(Self::udp_address(federate).port)
    }

    fn send_datagram(&mut self, federate: u16, bytes: &[u8]) -> Result<(), Infallible> {
        let World { rti, outlet, now, .. } = &mut self.world;
        if let Some(answer) = rti.handle_datagram(*now, Self::udp_address(federate), bytes, outlet) {
            self.datagrams.extend([answer, answer.coded_probe(*now)]);
        }
        Ok(())
    }

    /// Time goes on until there is one.
    fn receive_datagram(&mut self, federate: u16) -> Result<Vec<u8>, Infallible> {
        while self.datagrams.is_empty() {
            let Deadline::At(time) = self.world.rti.poll_round_timeout() else { panic!("no datagram is to come") };
            self.world.now = self.world.now.max(time);
            let question = self.world.rti.poll_round(self.world.now);
            self.datagrams.extend(question);
        }
        let datagram = self.datagrams.remove(0);
        assert_eq!(datagram.to, Self::udp_address(federate));
        let mut bytes = vec![0; datagram.message.encoded_len()];
        datagram.message.encode(&mut bytes).expect("there is as much room as the message is long");
        Ok(bytes)
    }

    fn receive(&mut self, connection: u16, _bytes: usize, _end: bool) -> Result<Received, Infallible> {
        let id = self.connections[&connection];
        let bytes = self.world.take(id, usize::MAX);
        Ok(Received { bytes, ended: self.world.outlet.list[id.0].ended })
    }
}

/// What the options of a recording mean. One that is not known here is a failure of the test.
pub fn config(setup: &RtiSetup) -> Config<'static> {
    let mut config = Config::new(setup.federation_id.clone().leak().as_bytes(), 1 << 16);
    let mut options = setup.options.iter().map(String::as_str);
    while let Some(option) = options.next() {
        match (option, &mut config.clock_sync) {
            ("-a", _) => config.authentication = Some(AUTHENTICATOR),
            ("-d", _) => config.dnet = false,
            ("-c", _) => match options.next() {
                Some("off") => config.clock_sync = ClockSync::Off,
                Some("init") => config.clock_sync = ClockSync::Init { trials: 10 },
                Some("on") => config.clock_sync = ClockSync::On { trials: 10, period: clock_sync::PERIOD },
                other => panic!("-c {other:?}"),
            },
            ("period", ClockSync::On { period, .. }) => {
                *period =
                    Interval::from_nanos(options.next().and_then(|text| text.parse().ok()).expect("a number follows"));
            }
            ("exchanges-per-interval", ClockSync::Init { trials } | ClockSync::On { trials, .. }) => {
                *trials = options.next().and_then(|text| text.parse().ok()).expect("a number follows");
            }
            ("-m", _) => {
                let value: i64 = options.next().and_then(|text| text.parse().ok()).expect("a number follows");
                config.start_time_multiple = Some(match options.next() {
                    Some("s") => Interval::from_secs(value),
                    Some("ms") => Interval::from_millis(value),
                    other => panic!("-m {value} {other:?}"),
                });
            }
            other => panic!("{other:?}"),
        }
    }
    config
}
