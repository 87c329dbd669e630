// SPDX-License-Identifier: Apache-2.0
//! The messages between RTI and federates, and the violations.

use std::fmt;

use lf_model::time::Tag;

use crate::small_tag::{Short, SmallTag};

/// A message of a federate to the RTI.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ToRti {
    /// NET.
    Next(Tag),
    /// LTC.
    Complete(SmallTag),
    /// A tagged message.
    Message { to: u8, at: SmallTag },
    /// `PORT_ABSENT`.
    Absent { to: u8, at: SmallTag },
    /// The clock of a transient federate that has come, its last message before it begins.
    Clock,
    /// RESIGN.
    Resign,
    /// The connection has ended.
    End,
}

/// A message of the RTI to a federate.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ToFederate {
    /// TAG.
    Grant(Tag),
    /// PTAG.
    Provisional(Tag),
    /// DNET.
    DownstreamNext(Tag),
    /// A tagged message.
    Message { from: u8, tag: Tag },
    /// `PORT_ABSENT`.
    Absent { from: u8, tag: Tag },
    /// The first tag of a transient federate that has come.
    Begins(Tag),
    /// A transient federate upstream has come.
    Came(u8),
    /// It has left.
    Left(u8),
    /// Another instance is to take its place.
    Stop,
}

/// A violation of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Violation {
    /// A message came for a tag that its receiver had been granted.
    AfterGrant {
        /// The receiver.
        federate: u8,
        /// The sender.
        from: u8,
        /// The message's tag.
        tag: Tag,
    },
    /// A message arrived for a provisionally granted tag, from outside the cycle or at a port whose status was known.
    AfterProvisional {
        /// The receiver.
        federate: u8,
        /// The sender.
        from: u8,
        /// The message's tag.
        tag: Tag,
    },
    /// A grant, provisional or not, was no later than the previous one.
    OldGrant {
        /// The receiver of the grant.
        federate: u8,
        /// The granted tag.
        tag: Tag,
    },
    /// A federate that is in no cycle without delay got a provisional grant.
    NeedlessProvisional {
        /// The receiver of the grant.
        federate: u8,
        /// The granted tag.
        tag: Tag,
    },
    /// The RTI talked to an instance of the transient federate before it had said that one's first tag.
    BeforeFirst {
        /// The federate.
        federate: u8,
    },
    /// An instance of the transient federate began no later than what an earlier one had completed.
    BeginsInPast {
        /// The federate.
        federate: u8,
        /// The first tag of the instance.
        tag: Tag,
    },
    /// The RTI had too little room for the tags of messages in transit.
    InTransitFull {
        /// The receiver.
        federate: u8,
    },
    /// The RTI reported a message as late.
    CalledLate {
        /// The receiver.
        federate: u8,
    },
    /// The RTI refused a valid message of a federate.
    Refused {
        /// The federate.
        from: u8,
    },
    /// The RTI closed a federate's connection.
    Expelled {
        /// The federate.
        federate: u8,
    },
}

impl fmt::Debug for ToRti {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Next(tag) => write!(f, "NET {:?}", Short(*tag)),
            Self::Complete(at) => write!(f, "LTC {at:?}"),
            Self::Message { to, at } => write!(f, "a message to {to} at {at:?}"),
            Self::Absent { to, at } => write!(f, "PORT_ABSENT to {to} at {at:?}"),
            Self::Clock => f.write_str("its clock"),
            Self::Resign => f.write_str("RESIGN"),
            Self::End => f.write_str("the end of its connection"),
        }
    }
}

impl fmt::Debug for ToFederate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grant(tag) => write!(f, "TAG {:?}", Short(*tag)),
            Self::Provisional(tag) => write!(f, "PTAG {:?}", Short(*tag)),
            Self::DownstreamNext(tag) => write!(f, "DNET {:?}", Short(*tag)),
            Self::Message { from, tag } => write!(f, "a message from {from} at {:?}", Short(*tag)),
            Self::Absent { from, tag } => write!(f, "PORT_ABSENT from {from} at {:?}", Short(*tag)),
            Self::Begins(tag) => write!(f, "effective start {:?}", Short(*tag)),
            Self::Came(from) => write!(f, "{from} has come"),
            Self::Left(from) => write!(f, "{from} has left"),
            Self::Stop => f.write_str("STOP"),
        }
    }
}
