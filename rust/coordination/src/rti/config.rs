// SPDX-License-Identifier: Apache-2.0
//! What the RTI is told about the federation.

use core::fmt;

use lf_model::time::Interval;
use lf_texts::say;
use lf_wire::{FEDERATION_ID_BYTES_MAX, Limits, message_bytes_max};

use crate::auth::Authenticator;

/// The federation id of a stock RTI that was given none.
pub const FEDERATION_ID_DEFAULT: &[u8] = b"Unidentified Federation";
/// How long after the last clock the start is.
pub const START_DELAY: Interval = Interval::from_secs(1);
/// How many clock synchronization exchanges there are at first, unless told otherwise.
pub const CLOCK_SYNC_TRIALS: u32 = 10;
/// How long a connection may be silent before its handshake is complete, and after it resigned.
pub const CONNECTION_TIME_OUT: Interval = Interval::from_secs(10);
/// How long a federate that has joined may be silent before it tells its clock: longer than federates try to connect
/// with each other.
pub const CLOCK_TIME_OUT: Interval = Interval::from_secs(90);
/// How long all may take to answer a stop request.
pub const STOP_REPLY_TIME_OUT: Interval = Interval::from_secs(30);

/// How long the start waits for a federate that was there and has left.
pub const START_BARRIER_TIME_OUT: Interval = Interval::from_secs(60);
/// How many tags of messages a receiver may be behind its senders.
pub const WINDOW: usize = 16;

/// Which clock synchronization the RTI offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockSync {
    /// None, whatever the federates ask for.
    Off,
    /// Exchanges over TCP in the handshake of each federate that asks for it.
    Init {
        /// How many. The number is not on the wire, the federates have to know it.
        trials: u32,
    },
    /// The same, and then rounds over UDP, as long as the federation runs, with each federate that asks for them.
    On {
        /// How many exchanges before the start, as with `Init`.
        trials: u32,
        /// How much time there is from one round with a federate to the next, longer than 0.
        period: Interval,
    },
}

/// What becomes of the others when a federate is lost after the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterLoss {
    /// They go on, as if it had resigned; only the outcome says that something went wrong. This is what the stock RTI
    /// does after FAILED.
    GoOn,
    /// They are told that the federation has failed.
    StopAll,
}

/// What the RTI is told about the federation. See [`Config::new`] for the defaults.
#[derive(Clone, Copy, Debug)]
pub struct Config<'a> {
    /// The federation's id; at most 255 bytes. It is compared in full.
    pub federation_id: &'a [u8],
    /// How federates have to prove that they know the federation id before they say who they are; `None` if they need
    /// not.
    pub authentication: Option<Authenticator>,
    /// Which clock synchronization there is.
    pub clock_sync: ClockSync,
    /// If given, the start time is rounded up to a multiple of this, which is positive.
    pub start_time_multiple: Option<Interval>,
    /// Whether federates are told which of their NETs nobody needs (DNET).
    pub dnet: bool,
    /// What becomes of the others when a federate is lost after the start.
    pub after_loss: AfterLoss,
    /// How long a connection may be silent before its handshake is complete, and after it resigned.
    pub connection_time_out: Interval,
    /// How long a federate that has joined may be silent before it tells its clock.
    pub clock_time_out: Interval,
    /// How long all may take to answer a stop request.
    pub stop_reply_time_out: Interval,
    /// After how long it is said for whom the start waits, again and again after longer pauses; `None`: never.
    pub start_report: Option<Interval>,
    /// While the federation runs, it is said of each federate that waits for longer than this what it waits for;
    /// `None`: never. Longer than 0.
    pub log_waits: Option<Interval>,
    /// How long the start waits after the first loss of a federate before it; `None`: for ever.
    pub start_barrier_time_out: Option<Interval>,
    /// How many different tags with messages a federate may have before it while more are passed on to it from senders
    /// that are past them; at least 1. If its memory for messages in transit is less, that counts. See the module
    /// `window`.
    pub window: usize,
    /// Longest payload that is forwarded, in bytes. Input and output buffers have to hold the whole message.
    pub payload_bytes_max: usize,
}

impl<'a> Config<'a> {
    /// The stock RTI's defaults, for payloads up to the given length.
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
        }
    }

    /// Bytes of the longest message in a federation of so many federates: what each buffer has to hold.
    pub const fn message_bytes_max(&self, federates: usize) -> usize {
        message_bytes_max(&self.limits(federates))
    }

    /// What the RTI accepts from a peer in a federation of so many federates.
    pub(super) const fn limits(&self, federates: usize) -> Limits {
        Limits {
            payload_bytes_max: self.payload_bytes_max,
            federation_id_bytes_max: FEDERATION_ID_BYTES_MAX,
            neighbors_max: federates,
        }
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

/// Why there can be no RTI with this configuration or storage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupError {
    /// The wire cannot carry the federation id.
    FederationIdTooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// The start time cannot be a multiple of nothing.
    StartTimeMultiple,
    /// There would be no time between two rounds of clock synchronization.
    ClockSyncPeriod,
    /// No message could ever be passed on.
    Window,
    /// There are no slots, or more than a federate id can name.
    Federates {
        /// Number of slots.
        slots: usize,
    },
    /// Part of the storage does not fit the number of federates.
    Storage {
        /// Which part.
        part: &'static str,
        /// How many entries it needs at least.
        needed: usize,
        /// How many it has.
        found: usize,
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
        }
    }
}

impl core::error::Error for SetupError {}
