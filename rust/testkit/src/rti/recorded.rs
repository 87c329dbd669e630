// SPDX-License-Identifier: Apache-2.0
//! The RTI of a recording.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::Ipv4Addr;

use lf_coordination::auth::AUTHENTICATOR;
use lf_coordination::rti::{ClockSync, Config, ConnectionId, Datagram};
use lf_coordination::{Deadline, Endpoint, clock_sync};
use lf_model::time::{Instant, Interval};

use super::{Rig, Sizes};
use crate::golden::RtiSetup;
use crate::golden::replay::{self, Received};

/// The time at which a replay begins.
const NOW: Instant = Instant::from_nanos(1_700_000_000_000_000_000);

/// The RTI of a recording.
pub struct Recorded {
    /// The RTI and its connections.
    pub rig: Rig,
    /// Connections by their numbers in the recording.
    connections: BTreeMap<u16, ConnectionId>,
    /// The datagrams in transit to the federates.
    datagrams: Vec<Datagram>,
}

impl Recorded {
    /// Returns the RTI with this configuration; its input comes in pieces of this many bytes.
    pub fn new(setup: &RtiSetup, piece: usize) -> Self {
        let federates = usize::from(setup.federates);
        let mut rig = Rig::new(config(setup), Sizes::ample(federates));
        rig.piece = piece;
        // The tags of most recordings are long past, so that nothing waits for the clock.
        rig.now = NOW;
        Self { rig, connections: BTreeMap::new(), datagrams: Vec::new() }
    }

    fn udp_address(federate: u16) -> Endpoint {
        Endpoint::new(Ipv4Addr::LOCALHOST, 40_000 + federate)
    }
}

impl replay::Rti for Recorded {
    type Error = Infallible;

    fn connect(&mut self, connection: u16) -> Result<(), Infallible> {
        let id = self.rig.connect();
        self.connections.insert(connection, id);
        Ok(())
    }

    fn send(&mut self, connection: u16, bytes: &[u8]) -> Result<(), Infallible> {
        self.rig.send(self.connections[&connection], bytes);
        Ok(())
    }

    fn close(&mut self, connection: u16) -> Result<(), Infallible> {
        self.rig.close(self.connections[&connection]);
        Ok(())
    }

    fn now(&mut self) -> i64 {
        self.rig.now.as_nanos()
    }

    fn wait_until(&mut self, time_ns: i64) -> Result<(), Infallible> {
        let until = Instant::from_nanos(time_ns);
        while let Deadline::At(time) = self.rig.rti.poll_timeout()
            && time <= until
        {
            self.rig.now = self.rig.now.max(time);
            self.rig.rti.handle_timeout(self.rig.now, &mut self.rig.outlet);
        }
        self.rig.now = self.rig.now.max(until);
        Ok(())
    }

    fn bind(&mut self, federate: u16) -> Result<u16, Infallible> {
        Ok(Self::udp_address(federate).port)
    }

    fn send_datagram(&mut self, federate: u16, bytes: &[u8]) -> Result<(), Infallible> {
        let Rig { rti, outlet, now, .. } = &mut self.rig;
        if let Some(answer) = rti.handle_datagram(*now, Self::udp_address(federate), bytes, outlet) {
            self.datagrams.extend([answer, answer.coded_probe(*now)]);
        }
        Ok(())
    }

    /// Advances time until there is one.
    fn receive_datagram(&mut self, federate: u16) -> Result<Vec<u8>, Infallible> {
        while self.datagrams.is_empty() {
            let Deadline::At(time) = self.rig.rti.poll_round_timeout() else { panic!("no datagram is to come") };
            self.rig.now = self.rig.now.max(time);
            let question = self.rig.rti.poll_round(self.rig.now);
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
        let bytes = self.rig.take(id, usize::MAX);
        Ok(Received { bytes, ended: self.rig.outlet.list[id.0].ended })
    }
}

/// Returns the configuration for the options of a recording.
///
/// # Panics
/// If it does not support an option.
pub fn config(setup: &RtiSetup) -> Config<'static> {
    let mut config = Config::new(setup.federation_id.clone().leak().as_bytes(), 1 << 16);
    config.transients = setup.transient_federates;
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
