// SPDX-License-Identifier: Apache-2.0
//! The RTI under arbitrary peers: it completes each step, names what it waits for when asked again, and grants nothing
//! that a message in transit contradicts; the rig asserts more.

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

/// Makes an RTI, and calls `act` with it.
pub(crate) fn with_world(federates: usize, config: Config<'_>, act: impl FnOnce(&mut World<'_>)) {
    let output = config.message_bytes_max(federates);
    let sizes = Sizes { federates, connections: CONNECTIONS, upstream: federates, in_transit: IN_TRANSIT, output };
    let mut memory = sizes.memory();
    let mut rig = ObservedRig::in_memory(config, &mut memory, sizes, Oracle::new(CONNECTIONS));
    assert_eq!(rig.rti.message_bytes_max(), output);
    (rig.now, rig.tells_times) = (Instant::from_nanos(0), false);
    act(&mut World(rig));
}

/// Returns the configuration that the first byte of the input chooses, for this number of federates.
pub(crate) fn config(choice: u8, federates: usize) -> Config<'static> {
    let transients = if choice & 32 == 0 { 0 } else { 2.min(federates - 1) };
    Config {
        clock_sync: if choice & 1 == 0 { ClockSync::Off } else { ClockSync::Init { trials: 2 } },
        dnet: choice & 2 == 0,
        authentication: (choice & 4 != 0).then_some(AUTHENTICATOR),
        window: if choice & 8 == 0 { 1 } else { 16 },
        transients: u16::try_from(transients).unwrap_or(0),
        start_time_multiple: (choice & 16 != 0).then_some(Interval::from_nanos(7)),
        ..Config::new(FEDERATION_ID_DEFAULT, PAYLOAD_BYTES_MAX)
    }
}

/// Runs the steps in the input. The first bytes choose the configuration and the number of federates; each step is a
/// byte for the kind and the connection, then its arguments. [`RawStep`](crate::RawStep) writes them.
///
/// # Panics
/// If something does not hold that has to.
pub fn rti_raw(data: &[u8]) {
    let [choice, federates, rest @ ..] = data else { return };
    let federates = usize::from(*federates) % FEDERATES_MAX + 1;
    with_world(federates, config(*choice, federates), |world| {
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

    /// Returns the time.
    pub(crate) fn now(&self) -> i64 {
        self.0.now.as_nanos()
    }

    /// Connects a peer, unless it is connected.
    pub(crate) fn connect(&mut self, connection: usize) {
        if self.0.is_free(ConnectionId(connection)) {
            self.0.connect_as(ConnectionId(connection), IpAddress::V4(Ipv4Addr::LOCALHOST));
            self.resume();
        }
    }

    /// Closes a peer's connection. The RTI still accepts the whole messages that the peer sent before.
    pub(crate) fn close(&mut self, connection: usize) {
        self.0.close(ConnectionId(connection));
        self.resume();
    }

    /// Lets a peer read this many bytes.
    pub(crate) fn read(&mut self, connection: usize, bytes: usize) {
        self.0.take(ConnectionId(connection), bytes);
        self.resume();
    }

    /// Lets time pass.
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

    /// Sends bytes of a peer. Bytes that the RTI cannot accept yet stay in the connection, and the peer sends nothing
    /// more meanwhile.
    pub(crate) fn say(&mut self, connection: usize, bytes: &[u8]) {
        let wire = &self.0.outlet.list[connection];
        if wire.open && !wire.closing && (wire.blocked.is_none() || wire.reads_on) {
            self.0.send(ConnectionId(connection), bytes);
            self.resume();
        }
    }

    /// Lets all peers read everything; afterwards only input that depends on another participant's progress waits.
    pub(crate) fn settle(&mut self) {
        for _ in 0..CONNECTIONS {
            for connection in 0..CONNECTIONS {
                self.read(connection, usize::MAX);
            }
        }
        let _ = self.0.rti.status();
    }

    /// Offers waiting input again, even without a reason, until the RTI accepts nothing more, and sends the times that
    /// are due.
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
