// SPDX-License-Identifier: Apache-2.0
//! The errors that end a federate. Each says in a sentence what to do.

use core::fmt;

use lf_model::time::{EventTag, Interval};
use lf_texts::{Text, say, text};
use lf_wire::{Message, MessageType, RejectCode};

use super::phase::Phase;
use crate::FederateId;

/// A [`Config`](super::Config) that no federate can work with.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConfigError {
    /// The federation id does not fit into `FED_IDS`.
    FederationIdTooLong {
        /// Its length.
        bytes: usize,
    },
    /// Initial clock synchronization without exchanges.
    NoTrials,
    /// An interval of 0 or less between two NETs.
    AdvanceInterval,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FederationIdTooLong { bytes } => {
                say!(f, "the federation id has {bytes} bytes: give one of at most 255")
            }
            Self::NoTrials => say!(
                f,
                "initial clock synchronization with 0 trials: give at least 1, or switch clock synchronization off",
            ),
            Self::AdvanceInterval => say!(f, "the advance-message-interval must be longer than 0"),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Advice for messages that do not fit the receiver's program.
pub const SAME_PROGRAM: Text = text!("check that all federates are built from the same program");

/// An error that ends a federate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FederateError {
    /// The RTI rejects this federate.
    Rejected(RejectCode),
    /// The RTI could not prove that it knows the federation id.
    RtiNotAuthentic,
    /// Connected, but no ACK within the connect time-out.
    NoAnswer,
    /// The RTI made no exchange of the initial clock synchronization.
    NoClockSync,
    /// The RTI makes more initial exchanges than this federate expects.
    TrialsDiffer {
        /// The number that this federate expects.
        trials: u16,
    },
    /// This federate cannot connect to a federate to which it sends directly.
    PeerUnreachable {
        /// The federate.
        federate: FederateId,
    },
    /// A message that is not allowed in this phase.
    Unexpected {
        /// Its type.
        message: MessageType,
        /// The federate's phase.
        phase: Phase,
    },
    /// A tagged message for another federate.
    WrongDestination {
        /// The federate it was for.
        federate: FederateId,
    },
    /// A message whose tag this federate has begun or completed already.
    LateMessage {
        /// The input it was for.
        port: u16,
        /// Its tag.
        tag: EventTag,
        /// The tag that the federate has begun or completed.
        current: EventTag,
    },
    /// A message whose tag is before the start.
    BeforeStart {
        /// The input it was for.
        port: u16,
        /// The time by which it is too early.
        by: Interval,
    },
    /// A message with a tag at which nothing can happen: at the end of time.
    NoTag {
        /// The input it was for.
        port: u16,
    },
    /// The RTI has ended because of an error.
    RtiFailed,
    /// The connection to the RTI ended before this federate had resigned.
    RtiLost {
        /// The federate's phase.
        phase: Phase,
    },
    /// [`Federate::begin`](super::Federate::begin) with a tag that has not been granted: an error of the caller.
    NotGranted {
        /// The tag.
        tag: EventTag,
    },
    /// [`Federate::begin`](super::Federate::begin) with a tag that is not later than the last: an error of the caller.
    NotLater {
        /// The tag.
        tag: EventTag,
        /// The last tag begun.
        current: EventTag,
    },
}

impl FederateError {
    /// Returns the error for a message that is not allowed in this phase.
    pub(super) fn unexpected(message: &Message<'_>, phase: Phase) -> Self {
        Self::Unexpected { message: message.message_type(), phase }
    }
}

impl fmt::Display for FederateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rejected(code) => say!(f, "the RTI rejects this federate: {code}. {}", advice(*code)),
            Self::RtiNotAuthentic => say!(
                f,
                "the RTI could not prove that it knows this federation's id: start the RTI and all federates with the \
                 same federation id, and check that the right RTI listens at this address",
            ),
            Self::NoAnswer => say!(
                f,
                "the RTI accepted the connection but did not answer: check that an RTI, and no other program, listens \
                 at this address, and that it still waits for federates",
            ),
            Self::NoClockSync => say!(
                f,
                "the RTI did not begin the initial clock synchronization: start it with clock synchronization on \
                 (`-c init`), or set `clock-sync: off` in the program",
            ),
            Self::TrialsDiffer { trials } => say!(
                f,
                "the RTI makes more clock synchronization exchanges than the {trials} that this federate expects: give \
                 both the same number (`trials` in the program, `exchanges-per-interval` of the RTI)",
            ),
            Self::PeerUnreachable { federate } => say!(
                f,
                "federate {federate}, to which this one sends directly, cannot be reached: check that this computer \
                 or board can connect to that one",
            ),
            Self::Unexpected { message, phase } => say!(
                f,
                "the RTI sent {message} {phase}: check that the RTI is one of the same release as this federate",
            ),
            Self::WrongDestination { federate } => {
                say!(f, "the RTI delivered a message for federate {federate}: {SAME_PROGRAM}")
            }
            Self::LateMessage { port, tag, current } => late(f, &format_args!("input {port}"), *tag, *current),
            Self::BeforeStart { port, by } => before_start(f, &format_args!("input {port}"), *by),
            Self::NoTag { port } => say!(
                f,
                "a message over input {port} came for the end of time, where nothing can happen: check the delays of \
                 the connections",
            ),
            Self::RtiFailed => say!(f, "the RTI or another federate failed: see its output for the reason"),
            Self::RtiLost { phase } => say!(
                f,
                "the connection to the RTI ended {phase}: check the network cables and that the RTI is running, and \
                 see its output for the reason",
            ),
            Self::NotGranted { tag } => say!(f, "the event loop began tag {tag}, which the RTI has not granted"),
            Self::NotLater { tag, current } => {
                say!(f, "the event loop began tag {tag}, which is not later than {current}")
            }
        }
    }
}

impl core::error::Error for FederateError {}

/// Writes that a message came too late for this input: its number or the name of its connection.
///
/// # Errors
/// Those of the formatter.
pub fn late(f: &mut fmt::Formatter<'_>, input: &dyn fmt::Display, tag: EventTag, current: EventTag) -> fmt::Result {
    say!(
        f,
        "a message over {input} came with tag {tag}, but this federate is at {current} already: {SAME_PROGRAM}, so \
         that the RTI knows all connections",
    )
}

/// Writes that a message came this long before the start for this input.
///
/// # Errors
/// Those of the formatter.
pub fn before_start(f: &mut fmt::Formatter<'_>, input: &dyn fmt::Display, by: Interval) -> fmt::Result {
    let ns = by.as_nanos();
    say!(
        f,
        "a message over {input} came with a tag that is {ns} ns = {} ms before the start of the federation: \
         {SAME_PROGRAM}",
        ns / 1_000_000,
    )
}

/// Returns the advice for a rejection.
fn advice(code: RejectCode) -> Text {
    match code {
        RejectCode::FederationIdMismatch => text!(
            "Start the RTI and all federates with the same federation id; if that is so, the federation is complete or \
             has begun already: start all of it again"
        ),
        RejectCode::IdInUse => text!(
            "End the other federate with this id; a federation that runs takes nobody back: then start all of it again"
        ),
        RejectCode::IdOutOfRange => text!("Start the RTI with the number of federates that the program has"),
        RejectCode::UnexpectedMessage => {
            text!(
                "Start the RTI with the number of federates that the program has (`-n`), of the same release as this \
                 federate; if it has `-a`, set `auth: true` in the program"
            )
        }
        RejectCode::WrongServer => text!("Check the RTI's address and port: another federate or program listens there"),
        RejectCode::HmacMismatch => text!("Start the RTI and all federates with the same federation id"),
        RejectCode::NotInAuthenticationMode => {
            text!("Start the RTI with authentication (`-a`), or set `auth: false` in the program")
        }
        RejectCode::JoinsTooLate => text!("Start the RTI and all federates again, all at the same time"),
        #[cfg(feature = "security")]
        RejectCode::Insecure => text!("Compare the federate's key with the one that the RTI trusts"),
        RejectCode::Other(_) => text!("See the RTI's output for the reason, and use an RTI of the same release"),
    }
}
