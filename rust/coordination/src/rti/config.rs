// SPDX-License-Identifier: Apache-2.0
//! The configuration of the RTI.

use core::fmt;

use lf_model::time::Interval;
use lf_texts::say;
use lf_wire::{FEDERATION_ID_BYTES_MAX, Limits, message_bytes_max};

use crate::WINDOW;
use crate::auth::Authenticator;

/// The default federation id of a stock RTI.
pub const FEDERATION_ID_DEFAULT: &[u8] = b"Unidentified Federation";
/// The time from the last clock to the start.
pub const START_DELAY: Interval = Interval::from_secs(1);
/// The default number of initial clock synchronization exchanges.
pub const CLOCK_SYNC_TRIALS: u32 = 10;
/// The longest silence of a connection before its handshake is complete, and after it resigned.
pub const CONNECTION_TIME_OUT: Interval = Interval::from_secs(10);
/// The longest silence of a federate that has joined before it sends its clock: longer than federates try to connect to
/// each other.
pub const CLOCK_TIME_OUT: Interval = Interval::from_secs(90);
/// The time within which all federates have to answer a stop request.
pub const STOP_REPLY_TIME_OUT: Interval = Interval::from_secs(30);

/// The time that the start waits for a federate that was there and has left.
pub const START_BARRIER_TIME_OUT: Interval = Interval::from_secs(60);

/// The clock synchronization that the RTI offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockSync {
    /// None, whatever the federates ask for.
    Off,
    /// Exchanges over TCP in the handshake of each federate that asks for it.
    Init {
        /// The number of exchanges. It is not on the wire, so the federates have to know it.
        trials: u32,
    },
    /// Exchanges over TCP, then rounds over UDP while the federation runs, with each federate that asks for them.
    On {
        /// The number of exchanges before the start, as with `Init`.
        trials: u32,
        /// The time from one round with a federate to the next, longer than 0.
        period: Interval,
    },
}

/// The consequence for the others when a federate is lost after the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterLoss {
    /// They go on, as if it had resigned; only the outcome says that something went wrong. This is what the stock RTI
    /// does after FAILED.
    GoOn,
    /// They receive FAILED: the federation has failed.
    StopAll,
}

/// The configuration of the RTI. See [`Config::new`] for the defaults.
#[derive(Clone, Copy, Debug)]
pub struct Config<'a> {
    /// The federation's id; at most 255 bytes. It is compared in full.
    pub federation_id: &'a [u8],
    /// The functions by which federates prove that they know the federation id before they send their id; `None` if
    /// they need not.
    pub authentication: Option<Authenticator>,
    /// The clock synchronization that the RTI offers.
    pub clock_sync: ClockSync,
    /// If given, the start time is rounded up to a multiple of this, which is positive.
    pub start_time_multiple: Option<Interval>,
    /// Whether federates learn which of their NETs no other federate needs (DNET).
    pub dnet: bool,
    /// The consequence for the others when a federate is lost after the start.
    pub after_loss: AfterLoss,
    /// The longest silence of a connection before its handshake is complete, and after it resigned.
    pub connection_time_out: Interval,
    /// The longest silence of a federate that has joined before it sends its clock.
    pub clock_time_out: Interval,
    /// The time within which all federates have to answer a stop request.
    pub stop_reply_time_out: Interval,
    /// The time after which the RTI logs which federates the start waits for, repeated after longer pauses; `None`:
    /// never.
    pub start_report: Option<Interval>,
    /// While the federation runs, the RTI logs each federate that waits for longer than this, and what it waits for;
    /// `None`: never. Longer than 0.
    pub log_waits: Option<Interval>,
    /// The time that the start waits after the first loss of a federate before it; `None`: without end.
    pub start_barrier_time_out: Option<Interval>,
    /// The number of different tags with messages in front of a federate at which more messages are held whose senders
    /// are past these tags; at least 1. If the storage for messages in transit is smaller, that counts; if all
    /// federates offer a larger window, the smallest of those. See the module `window`.
    pub window: u16,
    /// The longest payload that is forwarded, in bytes. Input and output buffers have to hold the whole message.
    pub payload_bytes_max: usize,
    /// The number of federates that may come and go while the federation runs, fewer than there are.
    #[cfg(feature = "transients")]
    pub transients: u16,
}

impl<'a> Config<'a> {
    /// Returns the stock RTI's defaults, for payloads up to the given length.
    pub const fn new(federation_id: &'a [u8], payload_bytes_max: usize) -> Self {
        Self {
            federation_id,
            authentication: None,
            clock_sync: ClockSync::Init { trials: CLOCK_SYNC_TRIALS },
            start_time_multiple: None,
            dnet: true,
            after_loss: AfterLoss::GoOn,
            connection_time_out: CONNECTION_TIME_OUT,
            clock_time_out: CLOCK_TIME_OUT,
            stop_reply_time_out: STOP_REPLY_TIME_OUT,
            start_report: None,
            log_waits: None,
            start_barrier_time_out: Some(START_BARRIER_TIME_OUT),
            window: WINDOW,
            payload_bytes_max,
            #[cfg(feature = "transients")]
            transients: 0,
        }
    }

    /// Returns the number of transient federates.
    pub(super) const fn transients(&self) -> usize {
        #[cfg(feature = "transients")]
        return self.transients as usize;
        #[cfg(not(feature = "transients"))]
        return 0;
    }

    /// Returns the length of the longest message in a federation of this many federates: every buffer has to hold it.
    pub const fn message_bytes_max(&self, federates: usize) -> usize {
        message_bytes_max(&self.limits(federates))
    }

    /// Returns the limits that a peer's messages have to meet in a federation of this many federates.
    pub(super) const fn limits(&self, federates: usize) -> Limits {
        Limits {
            payload_bytes_max: self.payload_bytes_max,
            federation_id_bytes_max: FEDERATION_ID_BYTES_MAX,
            neighbors_max: federates,
        }
    }

    /// Returns the storage for registrations, cleared, if it suffices for the transient federates among `federates`.
    #[cfg(feature = "transients")]
    pub(super) fn check_transients<'s>(
        &self,
        federates: usize,
        registrations: &'s mut [bool],
    ) -> Result<&'s mut [bool], SetupError> {
        if self.transients() == 0 {
            return Ok(&mut []);
        }
        if self.transients() >= federates {
            return Err(SetupError::Transients { transients: self.transients, federates });
        }
        let (needed, found) = (federates.saturating_mul(federates), registrations.len());
        let Some(registrations) = registrations.get_mut(..needed) else {
            return Err(SetupError::Storage { part: "registrations", needed, found });
        };
        registrations.fill(false);
        Ok(registrations)
    }

    pub(super) fn check(&self) -> Result<(), SetupError> {
        if self.federation_id.len() > FEDERATION_ID_BYTES_MAX {
            return Err(SetupError::FederationIdTooLong { bytes: self.federation_id.len() });
        }
        if self.start_time_multiple.is_some_and(|multiple| multiple.as_nanos() <= 0) {
            return Err(SetupError::StartTimeMultiple);
        }
        if matches!(self.clock_sync, ClockSync::On { period, .. } if period.as_nanos() <= 0) {
            return Err(SetupError::ClockSyncPeriod);
        }
        if self.window == 0 {
            return Err(SetupError::Window);
        }
        Ok(())
    }
}

/// The reason why this configuration or storage does not work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupError {
    /// The wire cannot carry the federation id.
    FederationIdTooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// The multiple for the start time is zero or negative.
    StartTimeMultiple,
    /// The time between two rounds of clock synchronization is zero or negative.
    ClockSyncPeriod,
    /// The window is 0, so no message could be passed on.
    Window,
    /// There are no slots, or more than a federate id can name.
    Federates {
        /// Number of slots.
        slots: usize,
    },
    /// Part of the storage does not fit the number of federates.
    Storage {
        /// The part's name.
        part: &'static str,
        /// The minimum number of entries.
        needed: usize,
        /// The number of entries that it has.
        found: usize,
    },
    /// All federates are transient, so the federation would be over before it begins.
    #[cfg(feature = "transients")]
    Transients {
        /// The number of transient federates.
        transients: u16,
        /// The number of all federates.
        federates: usize,
    },
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FederationIdTooLong { bytes } => {
                say!(f, "the federation id has {bytes} bytes, at most {FEDERATION_ID_BYTES_MAX} are possible")
            }
            Self::StartTimeMultiple => say!(f, "the start time can be a multiple of a positive time only"),
            Self::ClockSyncPeriod => say!(f, "the period of clock synchronization has to be longer than 0"),
            Self::Window => say!(f, "the window has to let one tag with messages through at least"),
            Self::Federates { slots } => {
                say!(f, "a federation has from 1 to {} federates, not {slots}", u16::MAX)
            }
            Self::Storage { part, needed, found } => {
                say!(f, "the RTI's storage for {part} needs {needed} entries or more, but has {found}")
            }
            #[cfg(feature = "transients")]
            Self::Transients { transients, federates } => say!(
                f,
                "{transients} of {federates} federates are transient: a federation needs one that is not, because it \
                 lasts as long as those do"
            ),
        }
    }
}

impl core::error::Error for SetupError {}
