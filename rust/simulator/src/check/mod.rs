// SPDX-License-Identifier: Apache-2.0
//! The invariants of every run. The checks stand outside the code that they check: they see bytes, records of reactions
//! and ends, and no state of any state machine.

mod direct;
mod ends;
mod incarnations;
mod late;
mod order;
mod seen;
mod traces;
mod wire;

use std::fmt;

use lf_model::time::Tag;

pub(crate) use direct::Sent;
pub(crate) use ends::{ends, is_endless, own_fault};
pub(crate) use incarnations::{handed_over, passed, reasons};
pub(crate) use late::{LateCounts, comings_are_in_time, late};
pub(crate) use order::order;
pub(crate) use seen::{Introduction, Seen, Unpassed};
pub(crate) use traces::{Difference, Expected, in_order, incarnation, traces};
pub(crate) use wire::{Counts, Watch};

/// A violation of an invariant.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Violation {
    /// A federate handled an event after one with a later tag.
    TagOrder { federate: usize, before: Tag, after: Tag },
    /// A federate's reactions did not do the same as those of the program run unfederated.
    Trace { federate: usize, difference: Difference },
    /// The reactions of a federate at one tag run in another order than those of the program run unfederated.
    Unordered { federate: usize, first: String, second: String },
    /// A message arrived for a tag that had been granted before.
    GrantViolated { federate: usize, grant: &'static str, granted: Tag, message: Tag },
    /// A grant was for an earlier tag than the one before it.
    GrantOrder { federate: usize, granted: Tag, before: Tag },
    /// No participant can ever run again, though not all have ended.
    Deadlock { waiting: Vec<usize>, now_ns: u64 },
    /// The participants keep running without an end.
    NoEnd { running: Vec<usize>, now_ns: u64, turns: u64 },
    /// The federates did not stop at one tag.
    StopTag { federate: usize, stopped: Tag, expected: Tag },
    /// A participant ended otherwise than it must; `None` for the RTI.
    End { federate: Option<usize>, how: String },
    /// The queue of an input and a receive buffer could not hold the messages, though they were sized for them.
    InputFull { federate: usize, how: String },
    /// The bytes on a connection are no messages.
    Bytes { federate: usize, error: String },
    /// A queue held more than the plan gives it.
    Capacity { federate: usize, most: usize, capacity: usize },
    /// A message was late though the wait covered all possible delays.
    LateThoughBounded { federate: usize, port: usize, sent: Tag, happened: Option<Tag> },
    /// A message was late though it had arrived before the wait for it ended.
    LateThoughInTime { federate: usize, port: usize, sent: Tag, happened: Option<Tag> },
    /// Late messages were not counted, or not reported.
    Unreported { federate: usize, late: u64, counted: u64, reported: u64, warnings: u64 },
    /// A federate reports lost messages, though no federate has left early.
    Lost { federate: usize, messages: u64 },
    /// A message was handled at a tag that is not its own, without a note in the input's queue; or the other way round.
    Misplaced { federate: usize, port: usize, sent: Tag, happened: Tag, intended: Option<Tag> },
    /// The messages that an input handled are not those that were sent to it, or not in that order.
    Order { federate: usize, port: usize, tag: Tag },
    /// A reaction did not run its handler for a late message, or ran it without one.
    Mishandled { federate: usize, tag: Tag },
    /// The RTI granted tags or forwarded messages with decentralized coordination.
    Centralized { messages: u64 },
    /// The RTI forwarded a message that nobody had sent, or one twice.
    Unsent { federate: usize, port: u16, tag: Tag },
    /// The RTI has read a message for an instance that was there at its tag, and has not forwarded it.
    NotPassed { from: usize, to: usize, tag: Tag },
    /// Two instances of one federate took part at the same time.
    TwoHeard { first: usize, second: usize },
    /// An instance of a federate has a tag that an earlier one has had already.
    Repeated { first: usize, second: usize, tag: Tag, before: Tag },
    /// An instance has taken over a state that no other one had, or none though it has taken the place of another one.
    State { instance: usize, taken: Option<u64> },
    /// An instance of a transient federate has left before the stop, though nobody and nothing has ended it.
    Left { instance: usize, completed: Tag },
    /// The program cannot be run at all.
    Program(String),
}

impl Violation {
    /// Returns the name of the invariant.
    pub(crate) fn invariant(&self) -> &'static str {
        match self {
            Self::TagOrder { .. } => "tag-order",
            Self::Trace { .. } => "same-trace-as-unfederated",
            Self::Unordered { .. } => "same-order-as-unfederated",
            Self::GrantViolated { .. } => "no-message-after-grant",
            Self::GrantOrder { .. } => "grants-in-order",
            Self::Deadlock { .. } => "no-deadlock",
            Self::NoEnd { .. } => "progress",
            Self::StopTag { .. } => "one-stop-tag",
            Self::End { .. } => "expected-end",
            Self::InputFull { .. } => "memory-suffices",
            Self::Bytes { .. } => "well-formed-bytes",
            Self::Capacity { .. } => "within-capacity",
            Self::LateThoughBounded { .. } => "nothing-late-within-bounds",
            Self::LateThoughInTime { .. } => "nothing-late-that-was-there",
            Self::Unreported { .. } => "late-messages-are-reported",
            Self::Lost { .. } => "no-message-is-lost",
            Self::Misplaced { .. } => "late-messages-say-so",
            Self::Order { .. } => "messages-in-order",
            Self::Mishandled { .. } => "late-messages-are-handled",
            Self::Centralized { .. } => "no-grants",
            Self::Unsent { .. } => "what-is-received-was-sent",
            Self::NotPassed { .. } => "nothing-is-lost-between-those-who-are-there",
            Self::TwoHeard { .. } => "one-instance-is-heard",
            Self::Repeated { .. } => "incarnations-follow-each-other",
            Self::State { .. } => "state-is-handed-over",
            Self::Left { .. } => "nobody-leaves-without-a-reason",
            Self::Program(_) => "program",
        }
    }
}

impl Violation {
    /// Describes a violation of decentralized coordination.
    fn fmt_late(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LateThoughBounded { federate, port, sent, happened: Some(happened) } => {
                write!(
                    f,
                    "a message to input {port} of f{federate} for {sent} happened at {happened}, and waits suffice"
                )
            }
            Self::LateThoughBounded { federate, port, sent, happened: None } => {
                write!(f, "a message to input {port} of f{federate} for {sent} did not happen, and waits suffice")
            }
            Self::LateThoughInTime { federate, port, sent, happened } => {
                let happened = happened.map_or("never".to_owned(), |tag| format!("at {tag}"));
                write!(f, "a message to input {port} of f{federate} for {sent} was in time, and happened {happened}")
            }
            Self::Unreported { federate, late, counted, reported, warnings } => write!(
                f,
                "f{federate} got {late} messages too late, counted {counted}, and reported {reported}, {warnings} of \
                 them as warnings"
            ),
            Self::Lost { federate, messages } => {
                write!(f, "f{federate} lost {messages} messages, and no federate left early")
            }
            Self::Misplaced { federate, port, sent, happened, intended: Some(intended) } => write!(
                f,
                "a message to input {port} of f{federate} for {sent} happened at {happened}, as if for {intended}"
            ),
            Self::Misplaced { federate, port, sent, happened, intended: None } => {
                write!(f, "a message to input {port} of f{federate} for {sent} happened at {happened}, as if in time")
            }
            Self::Order { federate, port, tag } => {
                write!(f, "what happened at {tag} at input {port} of f{federate} was not sent, or not in that order")
            }
            Self::Mishandled { federate, tag } => {
                write!(f, "f{federate} ran a body at {tag} instead of a handler of late messages, or the reverse")
            }
            Self::Centralized { messages } => write!(f, "{messages} messages were those of centralized coordination"),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.invariant())?;
        match self {
            Self::TagOrder { federate, before, after } => {
                write!(f, "f{federate} handled an event at {after} after one at {before}")
            }
            Self::Trace { federate, difference } => write!(f, "f{federate} {difference}"),
            Self::Unordered { federate, first, second } => {
                write!(f, "f{federate} runs {first} before {second}, unfederated the reverse")
            }
            Self::GrantViolated { federate, grant, granted, message } => {
                write!(f, "f{federate} was sent a message with tag {message} after {grant} {granted}")
            }
            Self::GrantOrder { federate, granted, before } => {
                write!(f, "f{federate} was granted {granted} after {before}")
            }
            Self::Deadlock { waiting, now_ns } => {
                write!(f, "at {now_ns} ns nothing can run, and these wait (0 is the RTI, 1 is f0): {waiting:?}")
            }
            Self::NoEnd { running, now_ns, turns } => {
                write!(f, "at {now_ns} ns, after {turns} turns, these still run (0 is the RTI, 1 is f0): {running:?}")
            }
            Self::StopTag { federate, stopped, expected } => {
                write!(f, "f{federate} stopped at {stopped}, and the stop was to be at {expected}")
            }
            Self::End { federate: Some(federate), how } => write!(f, "f{federate} ended: {how}"),
            Self::End { federate: None, how } => write!(f, "the RTI ended: {how}"),
            Self::InputFull { federate, how } => write!(f, "f{federate}: {how}"),
            Self::Bytes { federate, error } => write!(f, "on the connection of f{federate}: {error}"),
            Self::Capacity { federate, most, capacity } => {
                write!(f, "a queue of f{federate} held {most} events, and is to hold {capacity}")
            }
            Self::LateThoughBounded { .. }
            | Self::LateThoughInTime { .. }
            | Self::Unreported { .. }
            | Self::Lost { .. }
            | Self::Misplaced { .. }
            | Self::Order { .. }
            | Self::Mishandled { .. }
            | Self::Centralized { .. } => self.fmt_late(f),
            Self::Unsent { federate, port, tag } => {
                write!(f, "f{federate} got a message at port {port} for {tag} that was not sent, or got it before")
            }
            Self::NotPassed { from, to, tag } => {
                write!(f, "the RTI has not forwarded a message of f{from} to f{to} for {tag}, which was there then")
            }
            Self::TwoHeard { first, second } => {
                write!(f, "instance f{second} took part while instance f{first} of the same federate did")
            }
            Self::Repeated { first, second, tag, before } => {
                write!(
                    f,
                    "instance f{second} is at {tag} though instance f{first} of the same federate was at {before}"
                )
            }
            Self::State { instance, taken: Some(taken) } => {
                write!(f, "instance f{instance} has taken over the state {taken:x}, which no other one had")
            }
            Self::State { instance, taken: None } => {
                write!(f, "instance f{instance} has taken the place of another one, and not taken over its state")
            }
            Self::Left { instance, completed } => {
                write!(f, "instance f{instance} has left after {completed} by itself, before the stop")
            }
            Self::Program(error) => f.write_str(error),
        }
    }
}
