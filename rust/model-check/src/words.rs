// SPDX-License-Identifier: Apache-2.0
//! What RTI and federates say to each other, and what they must not.

use std::fmt;

use lf_model::time::Tag;

use crate::moment::{Moment, Short};

/// What a federate says to the RTI.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Up {
    /// NET.
    Next(Tag),
    /// LTC.
    Complete(Moment),
    /// A tagged message.
    Message { to: u8, at: Moment },
    /// `PORT_ABSENT`.
    Absent { to: u8, at: Moment },
    /// The connection has ended.
    End,
}

/// What the RTI says to a federate.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Down {
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
}

/// A promise that was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Broken {
    /// A message came for a tag that its receiver had been granted.
    AfterGrant {
        /// The receiver.
        federate: u8,
        /// The sender.
        from: u8,
        /// The message's tag.
        tag: Tag,
    },
    /// A message came for a tag that was granted provisionally, from outside the cycle or at a port that was known.
    AfterProvisional {
        /// The receiver.
        federate: u8,
        /// The sender.
        from: u8,
        /// The message's tag.
        tag: Tag,
    },
    /// A grant, provisional or not, that is not later than what was granted before.
    OldGrant {
        /// Who got it.
        federate: u8,
        /// What was granted.
        tag: Tag,
    },
    /// A provisional grant for a federate that is in no cycle without delay.
    NeedlessProvisional {
        /// Who got it.
        federate: u8,
        /// What was granted.
        tag: Tag,
    },
    /// The RTI had too little room for the tags of messages under way.
    InTransitFull {
        /// The receiver.
        federate: u8,
    },
    /// The RTI took a message for one that comes too late.
    CalledLate {
        /// The receiver.
        federate: u8,
    },
    /// The RTI did not take what a federate said by the protocol.
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

impl fmt::Debug for Up {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Next(tag) => write!(f, "NET {:?}", Short(*tag)),
            Self::Complete(at) => write!(f, "LTC {at:?}"),
            Self::Message { to, at } => write!(f, "a message to {to} at {at:?}"),
            Self::Absent { to, at } => write!(f, "PORT_ABSENT to {to} at {at:?}"),
            Self::End => f.write_str("the end of its connection"),
        }
    }
}

impl fmt::Debug for Down {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grant(tag) => write!(f, "TAG {:?}", Short(*tag)),
            Self::Provisional(tag) => write!(f, "PTAG {:?}", Short(*tag)),
            Self::DownstreamNext(tag) => write!(f, "DNET {:?}", Short(*tag)),
            Self::Message { from, tag } => write!(f, "a message from {from} at {:?}", Short(*tag)),
            Self::Absent { from, tag } => write!(f, "PORT_ABSENT from {from} at {:?}", Short(*tag)),
        }
    }
}
