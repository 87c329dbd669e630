// SPDX-License-Identifier: Apache-2.0
//! Waits that have lasted for too long, as log events.

use core::fmt;

use lf_model::time::{EventTag, Interval};
use lf_texts::say;
use lf_wire::MessageType;

use crate::FederateId;

/// The progress of a federate towards the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It has not connected, or not sent its id.
    Absent,
    /// It has connected, and this message of it comes next.
    Handshake(MessageType),
    /// It has joined, and its clock comes next.
    Joined,
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => say!(
                f,
                "has not connected: start it or, if the program has fewer federates, the RTI with their number (`-n`)"
            ),
            Self::Handshake(next) => say!(f, "has connected; {next} of it is to come"),
            Self::Joined => say!(
                f,
                "has joined, but is not ready: it says so (TIMESTAMP) when it has connected to the federates to which \
                 it sends directly",
            ),
        }
    }
}

/// A wait that has lasted for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waits {
    /// The start has been waiting for some federates for a while; each of the first has a log event of its own.
    Start {
        /// The number of federates that are not ready.
        missing: u16,
        /// The number of federates of the federation.
        federates: u16,
        /// The number of connections that have not sent an id.
        strangers: u16,
    },
    /// One of them.
    StartFor {
        /// The federate.
        federate: FederateId,
        /// Its progress.
        progress: Progress,
    },
    /// This many more are missing.
    StartForMore(u16),
    /// A federate has been waiting for a grant for too long.
    Grant {
        /// The federate.
        federate: FederateId,
        /// The tag that it wants to begin.
        tag: EventTag,
        /// The duration.
        lasts: Interval,
        /// The federate that may still send something for that tag or an earlier one, directly or indirectly.
        by: FederateId,
        /// Its next event, as announced.
        at: EventTag,
    },
    /// A stop has been waiting for the agreement of this federate for too long.
    Stop(FederateId),
    /// The messages of a federate have been waiting for another one for too long.
    Sender {
        /// The sender.
        from: FederateId,
        /// The receiver.
        to: FederateId,
        /// Whether they wait for room on its connection; otherwise they wait until it has completed some tags.
        room: bool,
        /// The duration.
        lasts: Interval,
    },
}

impl fmt::Display for Waits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Start { missing, federates, strangers } => {
                say!(f, "the start waits for {missing} of {federates} federates")?;
                match strangers {
                    0 => Ok(()),
                    _ => say!(f, "; {strangers} connections have not said which federates they are"),
                }
            }
            Self::StartFor { federate, progress } => say!(f, "federate {federate} {progress}"),
            Self::StartForMore(more) => say!(f, "and {more} more"),
            Self::Grant { federate, tag, lasts, by, at } => say!(
                f,
                "federate {federate} has been waiting for {} ms for a grant of {tag}, because federate {by} may still \
                 send something: it has not got beyond {at}",
                millis(lasts)
            ),
            Self::Stop(federate) => {
                say!(f, "the stop waits for federate {federate}, which has not answered the request")
            }
            Self::Sender { from, to, room, lasts } => {
                say!(f, "messages of federate {from} have been waiting for {} ms, because ", millis(lasts))?;
                say!(f, "federate {to} ")?;
                if room { say!(f, "does not take what it is sent") } else { say!(f, "is too many tags behind") }
            }
        }
    }
}

fn millis(interval: Interval) -> i64 {
    interval.as_nanos() / 1_000_000
}
