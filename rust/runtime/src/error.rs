// SPDX-License-Identifier: Apache-2.0
//! The errors that end a participant early. Each says in a sentence what happened, and where it helps, what to do.

use core::fmt;

use lf_coordination::Endpoint;
use lf_coordination::federate::{ConfigError, FederateError, Phase, before_start, late};
use lf_model::time::{EventTag, Interval};
use lf_model::{DeliverError, ModelError};
use lf_texts::say;
use lf_wire::{DecodeError, MessageType, RejectCode};

use crate::platform::{NetError, RandomError};

/// An error that ends a participant early.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RunError {
    /// No RTI answered within the connect time-out.
    RtiUnreachable {
        /// The address that it tried.
        address: Endpoint,
        /// The outcome of the last attempt; `None` when none had an outcome.
        last: Option<NetError>,
    },
    /// There are no random numbers for the authentication.
    Random(RandomError),
    /// The federate cannot go on with the federation.
    Federate(FederateError),
    /// The federate's configuration is invalid.
    Config(ConfigError),
    /// The program broke a rule of the reactor model, or a capacity.
    Model(ModelError),
    /// The RTI sent bytes that are no message.
    Bytes {
        /// The decoder's error.
        error: DecodeError,
        /// The federate's phase.
        phase: Phase,
    },
    /// A message cannot be delivered.
    Deliver(DeliverError),
    /// A user or the system asked this program to end (^C, SIGTERM).
    Interrupted,
    /// The queue of an input and the receive buffer are full of messages that have to wait, and the grant or absence
    /// that would let them go can never be read behind them.
    InputFull {
        /// The input.
        input: &'static str,
    },
    /// A message came for a tag at which reactions that could see it have run.
    Late {
        /// The connection: `unit_a.out -> unit_b.in`.
        input: &'static str,
        /// The message's tag.
        tag: EventTag,
        /// The federate's current tag.
        current: EventTag,
    },
    /// A message has a tag from before the start.
    BeforeStart {
        /// The connection: `unit_a.out -> unit_b.in`.
        input: &'static str,
        /// The time by which it is too early.
        by: Interval,
    },
    /// A message is longer than the type of its input, and than any that this federate can receive.
    TooLong {
        /// The connection: `unit_a.out -> unit_b.in`.
        input: &'static str,
        /// Bytes of its value.
        bytes: u32,
        /// The maximum bytes of a value of the type.
        max: usize,
    },
    /// The memory for the state of awaited inputs is too short.
    KnownTooShort {
        /// Tags that it has to hold.
        needed: usize,
        /// Tags that it holds.
        found: usize,
    },
    /// No UDP port can be opened for clock synchronization.
    Bind(NetError),
    /// No port can be opened for connections of other federates.
    Listen(NetError),
    /// The direct connection with another federate has a fault.
    Peer {
        /// The federate.
        federate: u16,
        /// The fault.
        fault: PeerFault,
    },
    /// More messages have come for one tag than the queue of an input holds. Values that were sent at several
    /// microsteps of one instant come at one tag if the connection has `after`.
    TagFull {
        /// The input.
        input: &'static str,
    },
    /// A buffer cannot hold the longest message.
    BufferTooSmall {
        /// Its purpose.
        buffer: &'static str,
        /// Bytes that it has to hold.
        needed: usize,
        /// Bytes that it holds.
        found: usize,
    },
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Ports that are never opened have no errors.
            Self::Bind(_) if !cfg!(feature = "datagrams") => Ok(()),
            Self::Listen(_) if !cfg!(feature = "peers") => Ok(()),
            Self::RtiUnreachable { address, last } => {
                say!(f, "no RTI answers at {address}")?;
                if let Some(last) = last {
                    say!(f, " ({last})")?;
                }
                say!(f, ": start the RTI, or correct the address")
            }
            Self::Random(error) => error.fmt(f),
            Self::Federate(error) => error.fmt(f),
            Self::Config(error) => error.fmt(f),
            Self::Model(error) => error.fmt(f),
            Self::Bytes { error, phase } if *phase <= Phase::Introducing => say!(
                f,
                "what listens at the RTI's address sent bytes that are no message: {error}; check the address and the \
                 port, and that an RTI listens there",
            ),
            Self::Bytes { error, phase } => say!(
                f,
                "the RTI sent bytes that are no message {phase}: {error}; check that the RTI is one of the same \
                 release as this federate",
            ),
            Self::Deliver(error) => error.fmt(f),
            Self::Interrupted => say!(f, "interrupted"),
            Self::InputFull { input } => say!(
                f,
                "the queue of {input} and the receive buffer are full, and what would empty them cannot come before \
                 they have room: raise the capacity of that connection with `@capacity(n)`, or slow its sender",
            ),
            Self::Late { input, tag, current } => late(f, input, *tag, *current),
            Self::BeforeStart { input, by } => before_start(f, input, *by),
            Self::TooLong { input, bytes, max } => say!(
                f,
                "a message over {input} has {bytes} bytes, but its type holds {max} at most: give the ports of this \
                 connection a type that holds more, and build all federates from one program",
            ),
            Self::KnownTooShort { needed, found } => {
                say!(f, "what is known of inputs takes {needed} tags of memory, but there are {found}")
            }
            Self::Bind(error) => say!(f, "no UDP port can be opened for clock synchronization: {error}"),
            Self::Listen(error) => say!(f, "no TCP port can be listened on for other federates: {error}"),
            Self::Peer { federate, fault } => say!(f, "federate {federate} {fault}"),
            Self::TagFull { input } => say!(
                f,
                "more messages for {input} have come for one time than its queue holds: raise the capacity of that \
                 connection with `@capacity(n)`, or send less often at one time",
            ),
            Self::BufferTooSmall { buffer, needed, found } => {
                say!(f, "the {buffer} buffer has {found} bytes, but has to have {needed} at least: make it that large")
            }
        }
    }
}

impl core::error::Error for RunError {}

/// A fault of the direct connection with another federate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PeerFault {
    /// Its bytes are no message.
    Bytes(DecodeError),
    /// It sent a message that no federate sends to another one.
    Unexpected(MessageType),
    /// It sent to another federate, or to an input that is not the end of such a connection from it.
    WrongInput {
        /// The federate that it named.
        federate: u16,
        /// The input that it named.
        port: u16,
    },
    /// It sent a value with a tag that no tag can follow or come before, so that it can never happen.
    WrongTag {
        /// The input.
        port: u16,
    },
    /// It cannot be connected to, for this reason.
    Unreachable(NetError),
    /// It does not answer a connection, or ends it.
    Unanswered,
    /// It refuses the connection, with this code.
    Refuses(RejectCode),
    /// It accepts nothing any more, while this federate waits for that in the middle of a tag.
    Blocked,
}

impl fmt::Display for PeerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !cfg!(feature = "peers") {
            // Connections that do not exist have no faults, and the sentences are long.
            return Ok(());
        }
        match self {
            Self::Bytes(error) => {
                say!(f, "sent bytes that are no message: {error}; check that all federates are of the same release")
            }
            Self::Unexpected(message) => say!(
                f,
                "sent {message} directly to this one, which federates send to the RTI only: check that all federates \
                 are of the same release",
            ),
            Self::WrongInput { federate, port } => say!(
                f,
                "sent a value for input {port} of federate {federate}, to which it has no such connection: check \
                 that all federates are built from the same program",
            ),
            Self::WrongTag { port } => say!(
                f,
                "sent a value for input {port} at the end of time, where nothing can happen: check that all federates \
                 are built from the same program, and the delays of its connections",
            ),
            Self::Unreachable(error) => say!(
                f,
                "cannot be reached, though this federate sends to it directly: {error}; check that this computer or \
                 board can connect to that one",
            ),
            Self::Unanswered => say!(
                f,
                "does not answer, though this federate sends to it directly: check that it runs, and that no other \
                 program connects to its port",
            ),
            Self::Refuses(code) => say!(
                f,
                "refuses the connection of this one: {code}; check that both are built from the same program, and that \
                 no other program connects in this one's name",
            ),
            Self::Blocked => say!(
                f,
                "has taken nothing for a minute, though a tag of this federate waits for that; it may be waiting for \
                 this one: raise the capacity of the connection with `@capacity(n)`, or send less",
            ),
        }
    }
}

impl From<RandomError> for RunError {
    fn from(error: RandomError) -> Self {
        Self::Random(error)
    }
}

impl From<FederateError> for RunError {
    fn from(error: FederateError) -> Self {
        Self::Federate(error)
    }
}

impl From<ConfigError> for RunError {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

impl From<ModelError> for RunError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<DeliverError> for RunError {
    fn from(error: DeliverError) -> Self {
        Self::Deliver(error)
    }
}
