// SPDX-License-Identifier: Apache-2.0
//! What a federate can wait for, beside the time.

use core::fmt;

use lf_coordination::Endpoint;
use lf_coordination::federate::Phase;
use lf_model::time::{EventTag, Instant, Tag};
use lf_texts::say;

use crate::error::PeerFault;
use crate::platform::NetError;

/// What a federate waits for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Reason {
    /// An RTI that takes its connection at this address; what went wrong with the last attempt.
    Rti(Endpoint, Option<NetError>),
    /// Its id, which the RTI says is taken.
    Id,
    /// An answer of the RTI in the handshake.
    Answer(Phase),
    /// Another federate that takes its connection; what went wrong with the last attempt.
    Peer(u16, Option<PeerFault>),
    /// The start time, which the RTI tells when all federates are ready.
    Others,
    /// A grant of the RTI for this tag.
    Grant(Tag),
    /// What comes at this tag from the named connection.
    Input(Tag, &'static str),
    /// Others that have taken what this federate has sent at this tag: the RTI, or another federate.
    Room(Tag, Option<u16>),
}

impl Reason {
    /// Whether the federate has not started yet.
    pub(super) fn is_before_start(&self) -> bool {
        matches!(self, Self::Rti(..) | Self::Id | Self::Answer(_) | Self::Peer(..) | Self::Others)
    }

    /// What tells this wait from others. What has gone wrong with a federate does not make another wait of it.
    pub(super) fn key(&self) -> Key {
        match *self {
            Self::Rti(..) => (Tag::NEVER, 0, 0),
            Self::Others => (Tag::NEVER, 1, 0),
            Self::Answer(phase) => (Tag::NEVER, 2, phase as usize),
            Self::Peer(federate, _) => (Tag::NEVER, 3, federate.into()),
            Self::Grant(tag) => (tag, 4, 0),
            // The names of inputs are constants of the program, each in its place.
            Self::Input(tag, name) => (tag, 5, name.as_ptr().addr()),
            Self::Room(tag, None) => (tag, 6, 0),
            Self::Room(tag, Some(federate)) => (tag, 7, federate.into()),
            Self::Id => (Tag::NEVER, 8, 0),
        }
    }
}

/// What tells one wait from another.
pub(super) type Key = (Tag, u8, usize);

/// A reason in words: what comes after "waiting for".
pub(crate) struct Words(pub(crate) Reason, pub(crate) Instant);

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(reason, start) = *self;
        let at = |tag| EventTag::relative(tag, start);
        match reason {
            // There are no connections with others.
            Reason::Peer(..) if !cfg!(feature = "peers") => Ok(()),
            Reason::Rti(address, None) => say!(f, "an RTI that answers at {address}"),
            Reason::Rti(address, Some(last)) => say!(f, "an RTI that answers at {address} ({last})"),
            Reason::Id => say!(f, "its id, which the RTI says is taken"),
            Reason::Answer(phase) => say!(f, "the RTI, {phase}"),
            Reason::Peer(federate, None) => say!(f, "federate {federate}, to which this one sends directly"),
            Reason::Peer(federate, Some(fault)) => say!(f, "federate {federate}: it {fault}"),
            Reason::Others => say!(f, "the other federates, of which the RTI says which are missing"),
            Reason::Grant(tag) => say!(f, "the RTI to grant {}: others may still send something", at(tag)),
            Reason::Input(tag, name) => say!(f, "what comes over {name} at {}", at(tag)),
            Reason::Room(tag, None) => say!(f, "the RTI to take what is sent at {}", at(tag)),
            Reason::Room(tag, Some(federate)) => {
                say!(f, "federate {federate} to take what is sent at {}", at(tag))
            }
        }
    }
}

/// What can be done about a wait, in words: what comes behind how long it has lasted.
pub(crate) struct Advice(pub(crate) Reason);

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Reason::Rti(..) => {
                say!(f, ": start one with `lfz rti -n FEDERATES -i FEDERATION`, or correct the address")
            }
            Reason::Id => say!(
                f,
                ": the RTI is asked again, for it may not have noticed yet that the federate with it has ended; one \
                 that has left a federation that runs cannot come back"
            ),
            _ => Ok(()),
        }
    }
}
