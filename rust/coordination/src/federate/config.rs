// SPDX-License-Identifier: Apache-2.0
//! The configuration of a federate and of its place in the federation.

use core::marker::PhantomData;

use lf_model::time::Interval;
use lf_wire::FEDERATION_ID_BYTES_MAX;

use super::error::ConfigError;
use super::needs::{All, Needs};
use crate::auth::Answer;
use crate::{FederateId, IpAddress};

/// The pause after a failed attempt to reach the RTI.
pub const CONNECT_RETRY: Interval = Interval::from_millis(500);
/// The time within which a federate has to reach the RTI and to be accepted.
pub const CONNECT_TIME_OUT: Interval = Interval::from_secs(60);
/// The time within which the RTI has to send its next clock synchronization message.
pub const CLOCK_SYNC_TIME_OUT: Interval = Interval::from_secs(10);
/// The number of initial exchanges that the stock RTI makes by default.
pub const CLOCK_SYNC_TRIALS: u16 = 10;
/// The interval at which a federate whose outputs depend on physical actions renews its NET.
pub const ADVANCE_INTERVAL: Interval = Interval::from_millis(10);

/// The clock synchronization that a federate takes part in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ClockSync {
    /// None: this federate's own clock is the physical time.
    Off,
    /// Exchanges over TCP before the start.
    Init {
        /// The number of exchanges. It is not on the wire and has to be the RTI's number, at least 1.
        trials: u16,
    },
    /// Exchanges over TCP before the start, then rounds over UDP while the federation runs.
    On {
        /// The number of exchanges before the start, as with `Init`.
        trials: u16,
        /// Each round corrects 1/`attenuation` of the remaining error; at least 1.
        attenuation: u16,
    },
}

impl ClockSync {
    /// Returns the number of exchanges before the start.
    pub const fn trials(self) -> u16 {
        match self {
            Self::Off => 0,
            Self::Init { trials } | Self::On { trials, .. } => trials,
        }
    }
}

/// The way in which federates keep the order of tags.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Coordination {
    /// The RTI grants tags, and forwards messages.
    #[default]
    Centralized,
    /// Federates send messages to each other. A federate begins a tag when it knows everything that comes before, or
    /// when its wait for that is over.
    Decentralized,
}

/// The configuration of a federate and of its place in the federation. See [`Config::new`] for the defaults.
#[derive(Clone, Copy, Debug)]
pub struct Config<'a, N = All> {
    /// This federate's id.
    pub id: FederateId,
    /// The federation's id; at most 255 bytes.
    pub federation_id: &'a [u8],
    /// The function by which this federate and the RTI prove that they know the federation id, if they authenticate.
    pub authentication: Option<Answer>,
    /// The way in which federates keep the order of tags.
    pub coordination: Coordination,
    /// The federates with a connection to this one, each with the minimum delay of these connections in ns, or
    /// [`DELAY_NONE`](lf_wire::DELAY_NONE) if one has no `after`.
    pub upstream: &'a [(u16, i64)],
    /// The federates to which this one has a connection.
    pub downstream: &'a [u16],
    /// The port on which this federate awaits connections of others; `None` if no federate sends to it directly.
    pub listening: Option<u16>,
    /// The federates to which this one sends directly, each once.
    pub peers: &'a [u16],
    /// The transient federates among this one and its neighbors: they come and go while the federation runs.
    pub transients: &'a [u16],
    /// The clock synchronization to take part in.
    pub clock_sync: ClockSync,
    /// The port on which this federate awaits the datagrams of clock synchronization. Without one, [`ClockSync::On`]
    /// acts like `Init`.
    pub udp_port: Option<u16>,
    /// The address that the RTI's datagrams come from; `None` if it is not known, and then any address is accepted.
    pub rti: Option<IpAddress>,
    /// The offset by which this federate's clock is ahead, as a test of clock synchronization, which has to find it.
    pub test_offset: Interval,
    /// The minimum delay from a physical action to an output to another federate; `None` when no physical action can
    /// cause such an output.
    pub physical_delay: Option<Interval>,
    /// The interval at which the NET is renewed when physical actions bound it.
    pub advance_interval: Interval,
    /// The window that this federate offers, at most [`WINDOW_MAX`](crate::WINDOW_MAX): twice as many messages of each
    /// input can wait in its receive buffer. 0: it has no memory beyond that for the usual [`WINDOW`](crate::WINDOW).
    pub window: u16,
    /// The time to wait for the ACK after each connection.
    pub connect_time_out: Interval,
    /// The time to wait for the next message of the initial clock synchronization.
    pub clock_sync_time_out: Interval,
    /// The capabilities that the program needs.
    pub needs: PhantomData<N>,
}

impl<'a> Config<'a> {
    /// Returns the configuration of a federate without neighbors, with the initial clock synchronization and the stock
    /// programs' times.
    pub const fn new(id: FederateId, federation_id: &'a [u8]) -> Self {
        Self::with_needs(id, federation_id)
    }
}

impl<'a, N: Needs> Config<'a, N> {
    /// Returns the same configuration for a program with these needs.
    pub const fn with_needs(id: FederateId, federation_id: &'a [u8]) -> Self {
        Self {
            id,
            federation_id,
            authentication: None,
            coordination: Coordination::Centralized,
            upstream: &[],
            downstream: &[],
            listening: None,
            peers: &[],
            transients: &[],
            clock_sync: ClockSync::Init { trials: CLOCK_SYNC_TRIALS },
            udp_port: None,
            rti: None,
            test_offset: Interval::ZERO,
            physical_delay: None,
            advance_interval: ADVANCE_INTERVAL,
            window: 0,
            connect_time_out: CONNECT_TIME_OUT,
            clock_sync_time_out: CLOCK_SYNC_TIME_OUT,
            needs: PhantomData,
        }
    }

    /// Returns the federates to which this one sends directly.
    pub(super) fn peers(&self) -> &'a [u16] {
        if N::PEERS_OUT { self.peers } else { &[] }
    }

    /// Returns whether this federate comes and goes while the federation runs.
    pub(super) fn is_transient(&self) -> bool {
        self.may_be_absent(self.id)
    }

    /// Returns whether a federate, this one or a neighbor, comes and goes while the federation runs.
    pub(super) fn may_be_absent(&self, federate: FederateId) -> bool {
        N::TRANSIENTS && self.transients.contains(&federate.0)
    }

    /// Returns the way in which federates keep the order of tags.
    pub(super) fn coordination(&self) -> Coordination {
        match (N::CENTRALIZED, N::DECENTRALIZED) {
            (true, true) => self.coordination,
            (_, false) => Coordination::Centralized,
            (false, true) => Coordination::Decentralized,
        }
    }

    /// Returns the window that this federate offers to those with which it exchanges messages through the RTI, or 0.
    pub(super) fn window(&self) -> u16 {
        if N::WINDOW && self.coordination() == Coordination::Centralized { self.window } else { 0 }
    }

    /// Returns the clock synchronization to take part in.
    pub(super) fn clock_sync(&self) -> ClockSync {
        if N::CLOCK_SYNC { self.clock_sync } else { ClockSync::Off }
    }

    /// Returns an address on the RTI's computer as this federate's computer sees it: a link-local address is at the
    /// interface that leads to the RTI, unless the RTI is on this computer.
    #[cfg(feature = "ipv6")]
    pub(super) fn as_seen_here(&self, address: core::net::Ipv6Addr, scope: u32) -> IpAddress {
        let leads_to_rti = match self.rti {
            Some(IpAddress::V6(_, scope)) if scope != 0 => Some(scope),
            _ => None,
        };
        IpAddress::v6(address, leads_to_rti.unwrap_or(scope))
    }

    /// Returns the federate's way to authenticate, if it does.
    pub(super) fn answer(&self) -> Option<Answer> {
        if N::AUTHENTICATION { self.authentication } else { None }
    }

    /// Checks that a federate can work with this configuration.
    ///
    /// # Errors
    /// The invalid setting, in a sentence.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.federation_id.len() > FEDERATION_ID_BYTES_MAX {
            return Err(ConfigError::FederationIdTooLong { bytes: self.federation_id.len() });
        }
        if self.clock_sync != ClockSync::Off && self.clock_sync.trials() == 0 {
            return Err(ConfigError::NoTrials);
        }
        // A federate that reached the timer would otherwise renew its NET without end at one instant.
        if self.physical_delay.is_some() && self.advance_interval.as_nanos() <= 0 {
            return Err(ConfigError::AdvanceInterval);
        }
        Ok(())
    }
}
