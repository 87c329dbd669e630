// SPDX-License-Identifier: Apache-2.0
//! The RTI: whatever peers do, it sends only where and as much as it may, ends each step, says once more what it waits
//! for, and grants nothing that a message on its way contradicts.

use lf_coordination::auth::AUTHENTICATOR;
use lf_coordination::heap::{Memory, Sizes};
use lf_coordination::rti::{ClockSync, Config, ConnectionId, FEDERATION_ID_DEFAULT, Rti, Verdict};
use lf_model::time::{Instant, Interval};
use lf_testkit::messages::encoded;
use lf_wire::{Decoded, Limits, Message, decode, message_bytes_max};

use crate::rti_oracle::{Oracle, Peer};

pub(crate) const FEDERATES_MAX: usize = 6;
pub(crate) const CONNECTIONS: usize = 8;
const PAYLOAD_BYTES_MAX: usize = 300;
const IN_TRANSIT: usize = 20;

/// An RTI with its connections.
pub(crate) struct World<'s> {
    rti: Rti<'s>,
    pub(crate) oracle: Oracle,
    limits: Limits,
    pub(crate) now: Instant,
    /// Which connection each one waits for.
    waits: [Option<usize>; CONNECTIONS],
    /// Those that may say more though they wait.
    reads_on: [bool; CONNECTIONS],
}

/// Makes an RTI, and does something with it.
pub(crate) fn with_world(federates: usize, config: Config<'_>, act: impl FnOnce(&mut World<'_>)) {
    let sizes = Sizes { federates, connections: CONNECTIONS, upstream: federates, in_transit: IN_TRANSIT };
    let mut memory = Memory::new(sizes);
    let limits =
        Limits { payload_bytes_max: PAYLOAD_BYTES_MAX, federation_id_bytes_max: 255, neighbors_max: federates };
    let rti = Rti::new(config, memory.storage()).expect("the storage fits");
    assert_eq!(rti.message_bytes_max(), message_bytes_max(&limits));
    let oracle = Oracle::new(CONNECTIONS, message_bytes_max(&limits));
    act(&mut World {
        rti,
        oracle,
        limits,
        now: Instant::from_nanos(0),
        waits: [None; CONNECTIONS],
        reads_on: [false; CONNECTIONS],
    });
}

/// The configuration that the first byte of the input chooses.
pub(crate) fn config(choice: u8) -> Config<'static> {
    Config {
        clock_sync: if choice & 1 == 0 { ClockSync::Off } else { ClockSync::Init { trials: 2 } },
        dnet: choice & 2 == 0,
        authentication: (choice & 4 != 0).then_some(AUTHENTICATOR),
        window: if choice & 8 == 0 { 1 } else { 16 },
        start_time_multiple: (choice & 16 != 0).then_some(Interval::from_nanos(7)),
        ..Config::new(FEDERATION_ID_DEFAULT, PAYLOAD_BYTES_MAX)
    }
}

/// The first bytes choose the configuration and the number of federates; then come steps: a byte for what and where,
/// then what it needs. [`RawStep`](crate::RawStep) writes them.
///
/// # Panics
/// If something does not hold that has to.
pub fn rti_raw(data: &[u8]) {
    let [choice, federates, rest @ ..] = data else { return };
    let federates = usize::from(*federates) % FEDERATES_MAX + 1;
    with_world(federates, config(*choice), |world| {
        let mut rest = rest;
        while let [step, tail @ ..] = rest {
            rest = tail;
            let connection = usize::from(step % 8);
            match step / 8 {
                0 => world.connect(connection),
                1 => world.close(connection),
                2 => world.read(connection, usize::MAX),
                3 => world.pass(i64::from(*step) * 1_000_000_000),
                _ => {
                    let Some((len, tail)) = rest.split_first() else { return };
                    let (said, tail) = tail.split_at(usize::from(*len).min(tail.len()));
                    rest = tail;
                    world.say(connection, said);
                }
            }
        }
        world.settle();
    });
}

impl World<'_> {
    pub(crate) fn start(&self) -> i64 {
        self.rti.start_time().map_or(0, Instant::as_nanos)
    }

    /// A peer connects, unless it is connected.
    pub(crate) fn connect(&mut self, connection: usize) {
        if self.oracle.peers[connection].open || self.oracle.peers[connection].pending > 0 {
            return;
        }
        self.oracle.peers[connection] = Peer::connected();
        let nonce = [7; 8];
        self.rti.handle_connect(
            self.now,
            ConnectionId(connection),
            lf_coordination::IpAddress::V4([127, 0, 0, 1].into()),
            nonce,
            &mut self.oracle,
        );
        self.resume();
    }

    /// A peer closes its connection. What it has said before is still taken, as far as it is whole.
    pub(crate) fn close(&mut self, connection: usize) {
        let peer = &mut self.oracle.peers[connection];
        peer.pending = 0;
        if peer.open && !std::mem::replace(&mut peer.closing, true) {
            self.rti.handle_end(ConnectionId(connection));
            self.offer(connection);
        }
        self.resume();
    }

    /// A peer reads so many bytes.
    pub(crate) fn read(&mut self, connection: usize, bytes: usize) {
        let peer = &mut self.oracle.peers[connection];
        let taken = bytes.min(peer.pending);
        if taken > 0 {
            peer.pending -= taken;
            self.rti.handle_writable(self.now, ConnectionId(connection), &mut self.oracle);
        }
        self.resume();
    }

    /// Time passes.
    pub(crate) fn pass(&mut self, ns: i64) {
        self.now = self.now + Interval::from_nanos(ns);
        if self.rti.poll_timeout().is_due(self.now) {
            self.rti.handle_timeout(self.now, &mut self.oracle);
            assert!(!self.rti.poll_timeout().is_due(self.now), "a time-out that was handled is over");
        }
        self.resume();
    }

    pub(crate) fn say_message(&mut self, connection: usize, message: &Message<'_>) {
        self.say(connection, &encoded(message));
    }

    /// A peer says something. What the RTI cannot take yet stays where it is, and no more is said meanwhile.
    pub(crate) fn say(&mut self, connection: usize, bytes: &[u8]) {
        let peer = &mut self.oracle.peers[connection];
        if peer.open && !peer.closing && (self.waits[connection].is_none() || self.reads_on[connection]) {
            peer.input.extend(bytes);
            self.offer(connection);
            self.resume();
        }
    }

    /// All read all; nothing waits any more but what waits for somebody to get on.
    pub(crate) fn settle(&mut self) {
        for _ in 0..CONNECTIONS {
            for connection in 0..CONNECTIONS {
                self.read(connection, usize::MAX);
            }
        }
        let _ = self.rti.status();
    }

    /// Offers what one peer has said, as far as it is taken. Returns whether anything was.
    fn offer(&mut self, connection: usize) -> bool {
        let mut any = false;
        loop {
            (self.waits[connection], self.reads_on[connection]) = (None, false);
            let bytes = std::mem::take(&mut self.oracle.peers[connection].input);
            let front = decode(&bytes, &self.limits);
            if let Ok(Decoded::Complete { message, .. }) = &front {
                self.oracle.expect(connection, message);
            }
            let verdict = self.rti.handle_input(self.now, ConnectionId(connection), &bytes, &mut self.oracle);
            let peer = &mut self.oracle.peers[connection];
            match verdict {
                Verdict::Consumed(len) => {
                    assert!(len > 0 && len <= bytes.len());
                    peer.input = bytes[len..].to_vec();
                    any = true;
                    while self.rti.poll_exchange(self.now, &mut self.oracle).is_some() {}
                    continue;
                }
                Verdict::Incomplete(need) => {
                    assert!(need > bytes.len() && need <= message_bytes_max(&self.limits), "it wants {need} bytes");
                    let holds_message =
                        matches!(front, Ok(Decoded::Complete { message: Message::TaggedMessage { .. }, .. }));
                    assert!(!holds_message, "a message that is whole would be dropped with its connection");
                    if peer.closing {
                        (peer.open, peer.ended) = (false, true);
                        self.rti.handle_disconnect(self.now, ConnectionId(connection), &mut self.oracle);
                    } else {
                        peer.input = bytes;
                    }
                }
                Verdict::Blocked(ConnectionId(on)) => {
                    assert!(self.oracle.peers[on].pending > 0, "it waits for room where there is all the room");
                    self.oracle.peers[connection].input = bytes;
                    self.waits[connection] = Some(on);
                }
                Verdict::Held(ConnectionId(on)) => {
                    peer.input = bytes;
                    self.waits[connection] = Some(on);
                }
                Verdict::HeldReadOn(ConnectionId(on)) => {
                    assert!(!peer.closing, "nothing more is to be looked for");
                    assert!(bytes.len() < message_bytes_max(&self.limits), "there is no space to read on");
                    peer.input = bytes;
                    (self.waits[connection], self.reads_on[connection]) = (Some(on), true);
                }
                Verdict::Closed => assert!(!peer.open, "a connection that is closed is closed"),
            }
            return any;
        }
    }

    /// Offers again what waits, until nothing more is taken, and sends the times that are due.
    fn resume(&mut self) {
        loop {
            while self.rti.poll_exchange(self.now, &mut self.oracle).is_some() {}
            assert!(!self.rti.poll_exchange_timeout().is_due(self.now), "all times are sent");
            let waiting = (0..CONNECTIONS).filter(|connection| self.waits[*connection].is_some());
            let waiting: Vec<_> = waiting.collect();
            if !waiting.into_iter().any(|connection| self.offer(connection)) {
                return;
            }
        }
    }
}
