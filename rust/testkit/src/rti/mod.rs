// SPDX-License-Identifier: Apache-2.0
//! An RTI with its connections in memory: a test decides the actions of each peer; the rig offers its input to the RTI,
//! and offers it again once the event has happened for which the RTI waits.
//!
//! The rig asserts invariants that hold whatever peers do: the RTI sends only where and as much as it may, names the
//! reason of every wait, and drops no whole message. An [`Observer`] may check more.

pub mod dialogue;
mod recorded;

use std::net::Ipv4Addr;

use lf_coordination::heap::{self, Memory};
use lf_coordination::rti::{Config, ConnectionId, Outlet, Rti, RtiEvent, Verdict};
use lf_coordination::{Deadline, IpAddress};
use lf_model::time::Instant;
use lf_wire::{Decoded, Limits, Message, decode};

use crate::messages::encoded;

pub use recorded::{Recorded, config};

/// An observer of the messages between peers and the RTI.
pub trait Observer {
    /// Observes that a peer has connected.
    fn connected(&mut self, _connection: ConnectionId) {}
    /// Observes the message at the beginning of the bytes that the rig is about to offer.
    fn offered(&mut self, _connection: ConnectionId, _message: &Message<'_>) {}
    /// Observes a message that the RTI has sent, and that the peer can read.
    fn sent(&mut self, _connection: ConnectionId, _message: &Message<'_>) {}
    /// Observes that the RTI sends no more on this connection.
    fn ended(&mut self, _connection: ConnectionId) {}
}

impl Observer for () {}

/// One connection: the RTI's bytes that the peer has not read, and the peer's bytes that the RTI has not consumed.
#[derive(Default, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each says something else")]
pub struct Connection {
    /// Bytes of the RTI that the peer has not read.
    pub outgoing: Vec<u8>,
    /// Bytes of the peer that the RTI has not consumed.
    pub incoming: Vec<u8>,
    /// Whether the RTI knows the connection.
    pub open: bool,
    /// Whether the peer has closed it, and reads and sends no more.
    pub closing: bool,
    /// Whether the RTI's direction is closed.
    pub ended: bool,
    /// The event that the input waits for.
    pub blocked: Option<Awaited>,
    /// Whether the RTI reads the messages behind the input that waits.
    pub reads_on: bool,
}

/// The event that the input of a connection waits for.
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
#[derive(Debug)]
pub struct Connections<O = ()> {
    /// The connections by number.
    pub list: Vec<Connection>,
    /// The capacity in bytes of each connection's output.
    pub capacity: usize,
    /// The log events of the RTI.
    pub log_events: Vec<String>,
    /// The observer of all messages.
    pub observer: O,
}

impl<O> Connections<O> {
    /// Returns unused connections.
    pub fn new(connections: usize, capacity: usize, observer: O) -> Self {
        let list = (0..connections).map(|_| Connection::default()).collect();
        Self { list, capacity, log_events: Vec::new(), observer }
    }
}

impl<O: Observer> Outlet for Connections<O> {
    fn room(&self, connection: ConnectionId) -> usize {
        self.capacity - self.list[connection.0].outgoing.len()
    }

    fn send(&mut self, connection: ConnectionId, message: &Message<'_>) {
        let wire = &mut self.list[connection.0];
        assert!(wire.open && !wire.ended, "{message:?} is sent on a connection that is closed");
        if wire.closing {
            return;
        }
        wire.outgoing.extend(encoded(message));
        assert!(wire.outgoing.len() <= self.capacity, "{message:?} is sent although there is no room");
        self.observer.sent(connection, message);
    }

    fn half_close(&mut self, connection: ConnectionId) {
        self.list[connection.0].ended = true;
        self.observer.ended(connection);
    }

    fn close(&mut self, connection: ConnectionId) {
        let wire = &mut self.list[connection.0];
        (wire.ended, wire.open, wire.blocked) = (true, false, None);
        wire.incoming.clear();
        self.observer.ended(connection);
    }

    fn log(&mut self, event: RtiEvent<'_>) {
        let event = event.to_string();
        assert!(!event.is_empty());
        self.log_events.push(event);
    }
}

/// The sizes of the RTI's memory.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Federates of the federation.
    pub federates: usize,
    /// Connections at a time.
    pub connections: usize,
    /// Upstream federates of each federate.
    pub upstream: usize,
    /// Tags of messages in transit, for each federate.
    pub in_transit: usize,
    /// Bytes of every connection's output.
    pub output: usize,
}

impl Sizes {
    /// Returns sizes that are always sufficient.
    pub fn ample(federates: usize) -> Self {
        Self { federates, connections: federates + 2, upstream: federates, in_transit: 1000, output: 1 << 20 }
    }

    /// Returns the RTI's part of the memory.
    pub fn memory(&self) -> Memory {
        let Self { federates, connections, upstream, in_transit, .. } = *self;
        Memory::new(heap::Sizes { federates, connections, upstream, in_transit })
    }
}

/// An RTI with its connections and an observer of them.
pub struct ObservedRig<'s, O> {
    /// The RTI.
    pub rti: Rti<'s>,
    /// Its connections.
    pub outlet: Connections<O>,
    /// The time of its clock.
    pub now: Instant,
    /// The size of the pieces in which input is offered, in bytes.
    pub piece: usize,
    /// Whether times of clock synchronization are sent as soon as they are due, for which time passes.
    pub tells_times: bool,
    limits: Limits,
    stopping: bool,
    nonces: u64,
}

/// An RTI with its connections.
pub type Rig = ObservedRig<'static, ()>;

impl Rig {
    /// Returns an RTI without connected peers.
    pub fn new(config: Config<'static>, sizes: Sizes) -> Self {
        // Tests end soon, so their memory may stay.
        Self::in_memory(config, Box::leak(Box::new(sizes.memory())), sizes, ())
    }
}

impl<'s, O: Observer> ObservedRig<'s, O> {
    /// Returns an RTI in this memory, which `sizes` has made.
    ///
    /// # Panics
    /// If the memory is too small for the configuration.
    pub fn in_memory(config: Config<'s>, memory: &'s mut Memory, sizes: Sizes, observer: O) -> Self {
        let limits = Limits {
            payload_bytes_max: config.payload_bytes_max,
            federation_id_bytes_max: 255,
            neighbors_max: sizes.federates,
        };
        Self {
            rti: Rti::new(config, memory.storage()).expect("the storage fits"),
            outlet: Connections::new(sizes.connections, sizes.output, observer),
            now: Instant::from_nanos(1_000),
            piece: usize::MAX,
            tells_times: true,
            limits,
            stopping: false,
            nonces: 0,
        }
    }

    /// Connects a peer on this computer.
    pub fn connect(&mut self) -> ConnectionId {
        self.connect_from(IpAddress::V4(Ipv4Addr::LOCALHOST))
    }

    /// Connects a peer at this address.
    ///
    /// # Panics
    /// If all connections are in use.
    pub fn connect_from(&mut self, address: IpAddress) -> ConnectionId {
        let free = (0..self.outlet.list.len()).map(ConnectionId).find(|connection| self.is_free(*connection));
        let connection = free.expect("there are enough connections");
        self.connect_as(connection, address);
        connection
    }

    /// Returns whether no peer uses a connection, and nothing is left to read on it.
    pub fn is_free(&self, connection: ConnectionId) -> bool {
        let wire = &self.outlet.list[connection.0];
        !wire.open && wire.outgoing.is_empty()
    }

    /// Connects a peer at this address on a free connection with this number.
    pub fn connect_as(&mut self, connection: ConnectionId, address: IpAddress) {
        self.outlet.list[connection.0] = Connection { open: true, ..Connection::default() };
        self.outlet.observer.connected(connection);
        // Each connection gets another nonce, and every run the same ones.
        self.nonces += 1;
        let nonce = self.nonces.to_le_bytes();
        self.rti.handle_connect(self.now, connection, address, nonce, &mut self.outlet);
    }

    /// Sends these bytes of the peer.
    pub fn send(&mut self, connection: ConnectionId, bytes: &[u8]) {
        for piece in bytes.chunks(self.piece.min(bytes.len().max(1))) {
            if self.outlet.list[connection.0].open {
                self.outlet.list[connection.0].incoming.extend(piece);
                self.pump(connection);
            }
        }
        self.resume();
    }

    /// Sends this message of the peer.
    pub fn message(&mut self, connection: ConnectionId, message: &Message<'_>) {
        self.send(connection, &encoded(message));
    }

    /// Offers the input of a connection, as far as the RTI accepts it, and then input that waited for it.
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

    /// Sends all times that become due without an action of a peer.
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
        let waits = |wire: &Connection| wire.blocked == Some(awaited);
        let waiting: Vec<_> = (0..self.outlet.list.len()).filter(|i| waits(&self.outlet.list[*i])).collect();
        for index in waiting {
            self.pump(ConnectionId(index));
        }
    }

    /// Offers the input of a connection. Returns whether the RTI has consumed any of it.
    ///
    /// # Panics
    /// If the verdict is not one that the input allows.
    pub fn offer(&mut self, connection: ConnectionId) -> bool {
        let mut any = false;
        loop {
            let bytes = std::mem::take(&mut self.outlet.list[connection.0].incoming);
            let front = decode(&bytes, &self.limits);
            if let Ok(Decoded::Complete { message, .. }) = &front {
                self.outlet.observer.offered(connection, message);
            }
            let holds_message = matches!(front, Ok(Decoded::Complete { message: Message::TaggedMessage { .. }, .. }));
            let verdict = self.rti.handle_input(self.now, connection, &bytes, &mut self.outlet);
            let len = bytes.len();
            let wire = &mut self.outlet.list[connection.0];
            (wire.incoming, wire.blocked, wire.reads_on) = (bytes, None, false);
            match verdict {
                Verdict::Consumed(consumed) => {
                    assert!(consumed > 0 && consumed <= len);
                    wire.incoming.drain(..consumed);
                    any = true;
                    continue;
                }
                Verdict::Incomplete(need) => {
                    assert!(need > len && need <= self.rti.message_bytes_max(), "it wants {need} bytes");
                    assert!(!holds_message, "a message that is whole would be dropped with its connection");
                    if wire.closing {
                        (wire.open, wire.ended) = (false, true);
                        self.outlet.observer.ended(connection);
                        self.rti.handle_disconnect(self.now, connection, &mut self.outlet);
                    }
                }
                Verdict::Blocked(on) => {
                    wire.blocked = Some(Awaited::Room(on));
                    let unread = self.outlet.list[on.0].outgoing.len();
                    assert!(unread > 0, "it waits for room where there is all the room");
                }
                Verdict::Held(until) => wire.blocked = Some(Awaited::Input(until)),
                Verdict::HeldReadOn(until) => {
                    assert!(!wire.closing, "nothing more is to be looked for");
                    assert!(len < self.rti.message_bytes_max(), "there is no space to read on");
                    (wire.blocked, wire.reads_on) = (Some(Awaited::Input(until)), true);
                }
                Verdict::Closed => {
                    assert!(!wire.open, "a connection that is closed is closed");
                    wire.incoming.clear();
                }
            }
            return any;
        }
    }

    /// Takes up to this number of bytes from the RTI, and lets it continue with the room.
    pub fn take(&mut self, connection: ConnectionId, max: usize) -> Vec<u8> {
        let wire = &mut self.outlet.list[connection.0];
        let taken: Vec<u8> = wire.outgoing.drain(..max.min(wire.outgoing.len())).collect();
        if !taken.is_empty() {
            self.rti.handle_writable(self.now, connection, &mut self.outlet);
            self.let_go_on(Awaited::Room(connection));
        }
        taken
    }

    /// Closes the peer's end of a connection. The RTI still reads the bytes that the peer sent before.
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
