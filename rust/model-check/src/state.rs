// SPDX-License-Identifier: Apache-2.0
//! One state of a federation: the RTI, the federates, and what is under way between them.

use std::fmt;

use lf_model::time::Tag;

use crate::federate::Federate;
use crate::graph::FEDERATES_MAX;
use crate::moment::{Moment, Short};
use crate::rti::Suspension;

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

/// One state.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct State {
    pub(crate) rti: Suspension,
    pub(crate) federates: [Federate; FEDERATES_MAX],
    /// To the RTI, in order.
    pub(crate) up: [Vec<Up>; FEDERATES_MAX],
    /// From the RTI, in order.
    pub(crate) down: [Vec<Down>; FEDERATES_MAX],
    /// Events of their own that the federates can still plan.
    pub(crate) own_events_left: u8,
    /// Messages that they can still send.
    pub(crate) messages_left: u8,
    /// Losses that can still come.
    pub(crate) losses_left: u8,
    pub(crate) broken: Option<Broken>,
}

impl State {
    /// The first promise that was broken on the way here.
    pub fn broken(&self) -> Option<Broken> {
        self.broken
    }

    /// Whether nothing is left to be done: no event, and nothing under way.
    pub fn is_done(&self) -> bool {
        let quiet = self.up.iter().all(Vec::is_empty) && self.down.iter().all(Vec::is_empty);
        quiet && self.federates.iter().all(Federate::is_idle)
    }
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (id, federate) in self.federates.iter().enumerate() {
            writeln!(f, "federate {id}: {federate:?}")?;
            if !self.up[id].is_empty() || !self.down[id].is_empty() {
                writeln!(f, "  to the RTI: {:?}, from it: {:?}", self.up[id], self.down[id])?;
            }
        }
        if let Some(broken) = self.broken {
            writeln!(f, "broken: {broken:?}")?;
        }
        Ok(())
    }
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
