// SPDX-License-Identifier: Apache-2.0
//! The RTI: whatever peers do, it ends each step, says once more what it waits for, and grants nothing that a message
//! on its way contradicts; the rig asserts more.

use std::net::Ipv4Addr;

use lf_coordination::IpAddress;
use lf_coordination::auth::AUTHENTICATOR;
use lf_coordination::rti::{ClockSync, Config, ConnectionId, FEDERATION_ID_DEFAULT};
use lf_model::time::{Instant, Interval};
use lf_testkit::messages::encoded;
use lf_testkit::rti::{ObservedRig, Sizes};
use lf_wire::Message;

use crate::rti_oracle::Oracle;

pub(crate) const FEDERATES_MAX: usize = 6;
pub(crate) const CONNECTIONS: usize = 8;
const PAYLOAD_BYTES_MAX: usize = 300;
const IN_TRANSIT: usize = 20;

/// An RTI with its connections.
pub(crate) struct World<'s>(ObservedRig<'s, Oracle>);

/// Makes an RTI, and does something with it.
pub(crate) fn with_world(federates: usize, config: Config<'_>, act: impl FnOnce(&mut World<'_>)) {
    let output = config.message_bytes_max(federates);
    let sizes = Sizes { federates, connections: CONNECTIONS, upstream: federates, in_transit: IN_TRANSIT, output };
    let mut memory = sizes.memory();
    let mut rig = ObservedRig::in_memory(config, &mut memory, sizes, Oracle::new(CONNECTIONS));
    assert_eq!(rig.rti.message_bytes_max(), output);
    (rig.now, rig.tells_times) = (Instant::from_nanos(0), false);
    act(&mut World(rig));
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
        self.0.rti.start_time().map_or(0, Instant::as_nanos)
    }

    /// A peer connects, unless it is connected.
    pub(crate) fn connect(&mut self, connection: usize) {
        if self.0.is_free(ConnectionId(connection)) {
            self.0.connect_as(ConnectionId(connection), IpAddress::V4(Ipv4Addr::LOCALHOST));
            self.resume();
        }
    }

    /// A peer closes its connection. What it has said before is still taken, as far as it is whole.
    pub(crate) fn close(&mut self, connection: usize) {
        self.0.close(ConnectionId(connection));
        self.resume();
    }

    /// A peer reads so many bytes.
    pub(crate) fn read(&mut self, connection: usize, bytes: usize) {
        self.0.take(ConnectionId(connection), bytes);
        self.resume();
    }

    /// Time passes.
    pub(crate) fn pass(&mut self, ns: i64) {
        let ObservedRig { rti, outlet, now, .. } = &mut self.0;
        *now = *now + Interval::from_nanos(ns);
        if rti.poll_timeout().is_due(*now) {
            rti.handle_timeout(*now, outlet);
            assert!(!rti.poll_timeout().is_due(*now), "a time-out that was handled is over");
        }
        self.resume();
    }

    pub(crate) fn say_message(&mut self, connection: usize, message: &Message<'_>) {
        self.say(connection, &encoded(message));
    }

    /// A peer says something. What the RTI cannot take yet stays where it is, and no more is said meanwhile.
    pub(crate) fn say(&mut self, connection: usize, bytes: &[u8]) {
        let wire = &self.0.outlet.list[connection];
        if wire.open && !wire.closing && (wire.blocked.is_none() || wire.reads_on) {
            self.0.send(ConnectionId(connection), bytes);
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
        let _ = self.0.rti.status();
    }

    /// Offers again what waits, also without a reason, until nothing more is taken, and sends the times that are due.
    fn resume(&mut self) {
        loop {
            let ObservedRig { rti, outlet, now, .. } = &mut self.0;
            while rti.poll_exchange(*now, outlet).is_some() {}
            assert!(!rti.poll_exchange_timeout().is_due(*now), "all times are sent");
            let waiting = (0..CONNECTIONS).filter(|connection| outlet.list[*connection].blocked.is_some());
            let waiting: Vec<_> = waiting.collect();
            if !waiting.into_iter().any(|connection| self.0.offer(ConnectionId(connection))) {
                return;
            }
        }
    }
}
