// SPDX-License-Identifier: Apache-2.0
//! The log events of the RTI: what has happened, why federates are lost, and which violations they committed.

use core::ascii;
use core::fmt::{self, Write as _};

use lf_model::time::{Instant, Tag};
use lf_texts::{say, text};
use lf_wire::{DecodeError, MessageType, RejectCode};

use super::suspected_violation::SuspectedViolation;
use super::waits::Waits;
use crate::tag::to_wire;
use crate::{Endpoint, FederateId, Times};

/// The reason why a federate is not part of the federation any more, although it did not resign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// It reported so itself, with FAILED.
    Failed,
    /// Its connection ended without a word.
    ConnectionLost,
    /// It sent a message that no federate may send.
    Violation(Violation),
    /// It joined, and then was silent for too long.
    NoClock,
    /// It did not answer a stop request in time.
    NoStopReply,
    /// The RTI's computer has no memory for a message from it or for it.
    NoMemory {
        /// Bytes of the message.
        bytes: usize,
    },
    /// The RTI was told to end.
    Aborted,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed => say!(f, "it reported that it has failed"),
            Self::ConnectionLost => say!(f, "its connection ended without a word"),
            Self::Violation(violation) => say!(f, "it broke the protocol: {violation}"),
            Self::NoClock => say!(f, "it has joined, but was silent for too long before it was ready to start"),
            Self::NoMemory { bytes } => {
                say!(f, "the RTI's computer has no memory left for a message of {bytes} bytes from it or for it")
            }
            Self::NoStopReply => say!(f, "it did not answer a stop request in time"),
            Self::Aborted => say!(f, "the RTI was told to end"),
        }
    }
}

/// A peer's violation of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Violation {
    /// The bytes are no message.
    Bytes(DecodeError),
    /// The payload of a message is longer than this RTI forwards.
    TooLong {
        /// Its length in bytes.
        bytes: u32,
        /// The limit.
        max: usize,
    },
    /// This message may not come at this point.
    Unexpected(MessageType),
    /// Its clock shows a time that no clock can show.
    Clock(Instant),
    /// It named a federate that the federation does not have.
    NoSuchFederate(u16),
    /// The delay of a connection is negative or FOREVER.
    Delay {
        /// The upstream federate of that connection.
        upstream: u16,
        /// The delay in nanoseconds.
        delay_ns: i64,
    },
    /// More upstream federates than the RTI has storage for.
    TooManyUpstream {
        /// The maximum number.
        max: usize,
    },
    /// The peer names another federate than the one it is.
    OtherFederate(u16),
    /// The peer does not authenticate, which this federation requires.
    NoAuthentication,
    /// The peer claims the id of a federate that has left since the start.
    HasLeft,
    /// The peer is a transient federate, and this RTI expects none.
    Transient,
    /// It sent a message with a tag at which nothing can happen: at the beginning or at the end of time.
    NoTag {
        /// The federate that it was for.
        to: u16,
    },
    /// The connections of a transient federate are not those that it had when it was there first.
    #[cfg(feature = "transients")]
    OtherNeighbors,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bytes(error) => error.fmt(f),
            Self::TooLong { bytes, max } => say!(
                f,
                "it sent a message of {bytes} bytes, but this RTI forwards at most {max}: start it with `--max-message \
                 {bytes}`, or, if it is on a board, build it from the program that the federates are from"
            ),
            Self::Unexpected(message_type) => say!(f, "{message_type} may not come at this point"),
            Self::Clock(clock) => {
                say!(f, "its clock shows {} ns since 1970, and no time of the years 1900 to 2199", clock.as_nanos())
            }
            Self::NoSuchFederate(id) => say!(
                f,
                "it named federate {id}, which this federation does not have: start the RTI with the number of \
                 federates that the program has (`-n`)"
            ),
            Self::HasLeft => {
                say!(f, "that federate has left, and a federation that runs takes nobody back: start all of it again")
            }
            Self::Delay { upstream, delay_ns } => {
                say!(f, "its connection from federate {upstream} has a delay of {delay_ns} ns, which cannot be")
            }
            Self::TooManyUpstream { max } => {
                say!(f, "it has more upstream federates than the {max} that this RTI has room for")
            }
            Self::OtherFederate(id) => say!(f, "it claimed to be federate {id}, which it is not"),
            Self::NoTag { to } => say!(
                f,
                "it sent federate {to} a message for the end of time, where nothing can happen: check the delays of \
                 its connections",
            ),
            Self::NoAuthentication => say!(
                f,
                "it does not authenticate: compile its program with the target property `auth: true`, or start this \
                 RTI without `-a`",
            ),
            Self::Transient => say!(
                f,
                "it is a transient federate, which may come and go while the federation runs, and this RTI expects \
                 none: start it with their number (`-nt`)",
            ),
            #[cfg(feature = "transients")]
            Self::OtherNeighbors => say!(
                f,
                "its connections are not those of the federate that was there before: build it from the program that \
                 the others are from"
            ),
        }
    }
}

/// A log event of the RTI. A frequent event has the number of its occurrences: see [`RtiEvent::is_logged`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RtiEvent<'a> {
    /// A federate has completed its handshake.
    Joined(FederateId),
    /// All federates have joined; they begin at this time.
    Started(Instant),
    /// A connection was refused.
    Rejected {
        /// The code that was sent.
        code: RejectCode,
        /// The federate that it claimed to be, if it sent an id.
        federate: Option<FederateId>,
        /// The federation that it wanted to join, if it sent an id.
        federation_id: Option<&'a [u8]>,
        /// The violation in its bytes, if there was one.
        violation: Option<Violation>,
        /// The number of refused connections.
        times: Times,
    },
    /// A federate refuses this RTI, because it could not prove that it knows the federation id.
    RejectedBy {
        /// The federate that it claimed to be.
        federate: FederateId,
        /// The code that it sent.
        code: RejectCode,
        /// The number of such refusals by any federate.
        times: Times,
    },
    /// A connection ended, or was silent for too long, before it sent its id, or before it had completed its handshake.
    /// Its id is free.
    HandshakeAbandoned {
        /// The federate, if it sent an id.
        federate: Option<FederateId>,
        /// Whether the RTI gave up, not the peer.
        timed_out: bool,
        /// The number of times that this has happened.
        times: Times,
    },
    /// A connection without an id was closed, because a new one came and all were in use.
    Evicted(Times),
    /// A federate left in order.
    Resigned(FederateId),
    /// A federate left out of order. Before the start its id is free again; later on, others go on as if it had
    /// resigned.
    Lost {
        /// The federate.
        federate: FederateId,
        /// The reason.
        cause: Cause,
        /// Whether the federation had started.
        started: bool,
    },
    /// A federate is suspected of a violation. Logged once for each federate.
    SuspectedViolation {
        /// The federate.
        federate: FederateId,
        /// The suspected violation.
        violation: SuspectedViolation,
    },
    /// A federate has been waiting for too long.
    Waits(Waits),
    /// The federation ends before it has started, and this federate was not there.
    Missing(FederateId),
    /// A byte that is no message was skipped.
    UnknownType {
        /// The federate that sent it.
        federate: FederateId,
        /// The byte.
        found: u8,
        /// The number of bytes that begin no message from this federate.
        times: Times,
    },
    /// A message was dropped, because its destination has left.
    Dropped {
        /// The sender.
        from: FederateId,
        /// The destination.
        to: FederateId,
        /// The number of such messages of this sender.
        times: Times,
    },
    /// A message was forwarded with a tag that its destination has completed already.
    Late {
        /// The sender.
        from: FederateId,
        /// The destination.
        to: FederateId,
        /// The number of such messages of this sender.
        times: Times,
    },
    /// The totals of a federate that has left, for events that happened more than once.
    Sum {
        /// The federate.
        federate: FederateId,
        /// The number of bytes that begin no message from this federate.
        unknown: Times,
        /// The number of its messages that came too late.
        late: Times,
        /// The number of its messages that were dropped.
        dropped: Times,
    },
    /// More messages are in transit to a federate than can be stored one by one. Federates that wait for this one may
    /// have to wait longer, in a cycle without end.
    InTransitFull(FederateId),
    /// The first federate that asks the federation to stop.
    StopRequested(FederateId),
    /// All federates stop at this tag.
    StopGranted(Tag),
    /// A datagram that no federate's answer can be was ignored. Logged once, because anybody can send datagrams.
    Stranger(Endpoint),
    /// A transient federate takes part from this tag on.
    #[cfg(feature = "transients")]
    Begins {
        /// The federate.
        federate: FederateId,
        /// Its effective start.
        tag: Tag,
    },
    /// A transient federate is told to stop, because another instance of it has come.
    #[cfg(feature = "transients")]
    Replaced(FederateId),
    /// A message was dropped, because its destination, which is transient, does not take part at its tag.
    #[cfg(feature = "transients")]
    Missed {
        /// The sender.
        from: FederateId,
        /// The destination.
        to: FederateId,
        /// The number of dropped messages of this sender.
        times: Times,
    },
}

impl RtiEvent<'_> {
    /// Returns whether to log it: of frequent events, only some are logged.
    pub fn is_logged(&self) -> bool {
        match self {
            Self::Rejected { times, .. }
            | Self::RejectedBy { times, .. }
            | Self::HandshakeAbandoned { times, .. }
            | Self::Evicted(times)
            | Self::UnknownType { times, .. }
            | Self::Dropped { times, .. }
            | Self::Late { times, .. } => times.is_logged(),
            #[cfg(feature = "transients")]
            Self::Missed { times, .. } => times.is_logged(),
            _ => true,
        }
    }
}

impl fmt::Display for RtiEvent<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Joined(federate) => say!(f, "federate {federate} has joined"),
            Self::Started(start) => say!(f, "all federates have joined and start at {} ns", start.as_nanos()),
            Self::Rejected { code, federate, federation_id, violation, times } => {
                say!(f, "a connection was refused")?;
                if let Some(federate) = federate {
                    say!(f, " that claims to be federate {federate}")?;
                }
                if let Some(id) = federation_id {
                    say!(f, " of federation \"{}\"", Escaped(id))?;
                }
                say!(f, ": {code}")?;
                violation.map_or(Ok(()), |violation| say!(f, "; {violation}"))?;
                times.fmt(f)
            }
            Self::RejectedBy { federate, code, times } => {
                say!(f, "a program that claims to be federate {federate} refuses this RTI: {code}{times}")
            }
            Self::HandshakeAbandoned { federate, timed_out, times } => {
                match federate {
                    Some(federate) => say!(f, "federate {federate}")?,
                    None => say!(f, "a connection")?,
                }
                if timed_out { say!(f, " was silent for too long") } else { say!(f, " ended") }?;
                say!(f, " before its handshake was complete{times}")
            }
            Self::Evicted(times) => say!(
                f,
                "a connection that had not said which federate it is was closed, because another one has come and all \
                 places are taken{times}"
            ),
            Self::Resigned(federate) => say!(f, "federate {federate} has resigned"),
            Self::Lost { federate, cause, started: true } => say!(f, "federate {federate} is lost: {cause}"),
            Self::Lost { federate, cause, started: false } => {
                say!(f, "federate {federate} is lost before the start, its place is free again: {cause}")
            }
            Self::SuspectedViolation { federate, violation } => say!(f, "federate {federate} {violation}"),
            Self::Waits(ref waits) => waits.fmt(f),
            Self::Missing(federate) => {
                say!(f, "federate {federate} is missing: the federation ends without having started")
            }
            Self::UnknownType { federate, found, times } => {
                say!(f, "federate {federate} sent {found}, which begins no message and was skipped{times}")
            }
            Self::Dropped { from, to, times } => {
                say!(f, "a message from federate {from} was dropped, because federate {to} has left{times}")
            }
            Self::Late { from, to, times } => {
                say!(f, "a message from federate {from} is late: federate {to} has completed its tag already{times}")
            }
            Self::Sum { federate, unknown, late, dropped } => {
                say!(f, "federate {federate} in all:")?;
                write_sum(f, [unknown, late, dropped])
            }
            Self::InTransitFull(federate) => {
                say!(f, "more messages are on their way to federate {federate} than can be remembered one by one")
            }
            Self::StopRequested(federate) => say!(f, "federate {federate} asks the federation to stop"),
            Self::Stranger(from) => {
                say!(f, "datagrams from {from} are ignored, because they are no answers to clock synchronization")
            }
            Self::StopGranted(tag) => say!(f, "the federation stops at {}", to_wire(tag)),
            #[cfg(feature = "transients")]
            Self::Begins { .. } | Self::Replaced(_) | Self::Missed { .. } => self.write_transient(f),
        }
    }
}

#[cfg(feature = "transients")]
impl RtiEvent<'_> {
    /// Writes an event of a transient federate.
    fn write_transient(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Begins { federate, tag } => say!(f, "federate {federate} takes part from {} on", to_wire(tag)),
            Self::Replaced(federate) => {
                say!(f, "federate {federate} is told to stop, because another instance of it has come")
            }
            Self::Missed { from, to, times } => say!(
                f,
                "a message from federate {from} was dropped, because federate {to} does not take part at its \
                 tag{times}"
            ),
            _ => Ok(()),
        }
    }
}

/// Escapes bytes of a peer like `escape_ascii`, whose `Display` is larger because it writes several at once.
struct Escaped<'a>(&'a [u8]);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut characters = self.0.iter().flat_map(|byte| ascii::escape_default(*byte));
        characters.try_for_each(|character| f.write_char(character.into()))
    }
}

/// Writes the totals of a federate: bytes that begin no message, late and dropped messages.
fn write_sum(f: &mut fmt::Formatter<'_>, times: [Times; 3]) -> fmt::Result {
    let what = [
        text!("bytes that begin no message"),
        text!("late messages"),
        text!("messages dropped, because their destinations have left"),
    ];
    let mut separator = " ";
    for (Times(count), what) in times.into_iter().zip(what).filter(|(Times(count), _)| *count > 0) {
        say!(f, "{separator}{count} {what}")?;
        separator = "; ";
    }
    Ok(())
}
