// SPDX-License-Identifier: Apache-2.0
//! What a federate is told about itself and the federation.

use core::marker::PhantomData;

use lf_model::time::Interval;
use lf_wire::FEDERATION_ID_BYTES_MAX;

use super::error::ConfigError;
use super::needs::{All, Needs};
use crate::auth::Answer;
use crate::{FederateId, IpAddress};

/// How long after a failed attempt to reach the RTI the next one is made.
pub const CONNECT_RETRY: Interval = Interval::from_millis(500);
/// How long a federate tries to reach the RTI and to be accepted by it.
pub const CONNECT_TIME_OUT: Interval = Interval::from_secs(60);
/// How long a federate waits for the RTI's next clock synchronization message.
pub const CLOCK_SYNC_TIME_OUT: Interval = Interval::from_secs(10);
/// How many initial exchanges the stock RTI makes if it is not told otherwise.
pub const CLOCK_SYNC_TRIALS: u16 = 10;
/// How often a federate whose outputs depend on physical actions renews its NET.
pub const ADVANCE_INTERVAL: Interval = Interval::from_millis(10);

/// Which clock synchronization a federate takes part in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ClockSync {
    /// None: this federate's own clock is the physical time.
    Off,
    /// Exchanges over TCP before the start.
    Init {
        /// How many exchanges. The number is not on the wire: it has to be that of the RTI, at least 1.
        trials: u16,
    },
    /// The same, and then rounds over UDP as long as the federation runs.
    On {
        /// How many exchanges before the start, as with `Init`.
        trials: u16,
        /// With each round, one of so many parts of what the clock is off is made up for; at least 1.
        attenuation: u16,
    },
}

impl ClockSync {
    /// How many exchanges there are before the start.
    pub const fn trials(self) -> u16 {
        match self {
            Self::Off => 0,
            Self::Init { trials } | Self::On { trials, .. } => trials,
        }
    }
}

/// How tags are kept in order between the federates.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Coordination {
    /// The RTI grants tags, and forwards messages.
    #[default]
    Centralized,
    /// Messages go from federate to federate. A federate begins a tag when it knows all that comes before, or when the
    /// time that it waits for that is over.
    Decentralized,
}

/// What a federate is told about itself and the federation. See [`Config::new`] for the defaults.
#[derive(Clone, Copy, Debug)]
pub struct Config<'a, N = All> {
    /// This federate's id.
    pub id: FederateId,
    /// The federation's id; at most 255 bytes.
    pub federation_id: &'a [u8],
    /// How this federate and the RTI prove to each other that they know the federation id, if they do.
    pub authentication: Option<Answer>,
    /// How tags are kept in order.
    pub coordination: Coordination,
    /// The federates with a connection to this one, each with the least delay of these connections in ns, or
    /// [`DELAY_NONE`](lf_wire::DELAY_NONE) where one has no `after`.
    pub upstream: &'a [(u16, i64)],
    /// The federates to which this one has a connection.
    pub downstream: &'a [u16],
    /// The port on which this federate awaits connections of others; `None` if none are to come.
    pub listening: Option<u16>,
    /// The federates to which this one sends directly, each once.
    pub peers: &'a [u16],
    /// Which clock synchronization to take part in.
    pub clock_sync: ClockSync,
    /// The port on which this federate awaits the datagrams of clock synchronization; `None` if there is none, and then
    /// [`ClockSync::On`] is as `Init`.
    pub udp_port: Option<u16>,
    /// From where the RTI's datagrams come; `None` if that is not known, and then they may come from anywhere.
    pub rti: Option<IpAddress>,
    /// What this federate's clock shows too much, as a test of clock synchronization, which has to find it out.
    pub test_offset: Interval,
    /// The least delay from a physical action to an output to another federate; `None` when no physical action can
    /// cause such an output.
    pub physical_delay: Option<Interval>,
    /// How often the NET is renewed when physical actions bound it.
    pub advance_interval: Interval,
    /// How long to wait for the ACK after each connection.
    pub connect_time_out: Interval,
    /// How long to wait for the next message of the initial clock synchronization.
    pub clock_sync_time_out: Interval,
    /// What the program needs.
    pub needs: PhantomData<N>,
}

impl<'a> Config<'a> {
    /// A federate without neighbors, with the initial clock synchronization and the stock programs' times.
    pub const fn new(id: FederateId, federation_id: &'a [u8]) -> Self {
        Self::with_needs(id, federation_id)
    }
}

impl<'a, N: Needs> Config<'a, N> {
    /// The same for a program with these needs.
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
            clock_sync: ClockSync::Init { trials: CLOCK_SYNC_TRIALS },
            udp_port: None,
            rti: None,
            test_offset: Interval::ZERO,
            physical_delay: None,
            advance_interval: ADVANCE_INTERVAL,
            connect_time_out: CONNECT_TIME_OUT,
            clock_sync_time_out: CLOCK_SYNC_TIME_OUT,
            needs: PhantomData,
        }
    }

    /// The federates to which this one sends directly.
    pub(super) fn peers(&self) -> &'a [u16] {
        if N::PEERS { self.peers } else { &[] }
    }

    /// An address that the RTI's computer sees, as this federate's sees it: a link-local one is at the interface that
    /// leads to the RTI, unless the RTI is on this computer.
    #[cfg(feature = "ipv6")]
    pub(super) fn as_seen_here(&self, address: core::net::Ipv6Addr, scope: u32) -> IpAddress {
        let leads_to_rti = match self.rti {
            Some(IpAddress::V6(_, scope)) if scope != 0 => Some(scope),
            _ => None,
        };
        IpAddress::v6(address, leads_to_rti.unwrap_or(scope))
    }

    /// How this federate authenticates, if it does.
    pub(super) fn answer(&self) -> Option<Answer> {
        if N::AUTHENTICATION { self.authentication } else { None }
    }

    /// Whether a federate can work with this.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.federation_id.len() > FEDERATION_ID_BYTES_MAX {
            return Err(ConfigError::FederationIdTooLong { bytes: self.federation_id.len() });
        }
        if self.clock_sync != ClockSync::Off && self.clock_sync.trials() == 0 {
            return Err(ConfigError::NoTrials);
        }
        // The federate that reached the timer would otherwise renew its NET without end at one instant.
        if self.physical_delay.is_some() && self.advance_interval.as_nanos() <= 0 {
            return Err(ConfigError::AdvanceInterval);
        }
        Ok(())
    }
}
