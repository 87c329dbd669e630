// SPDX-License-Identifier: Apache-2.0
//! The reasons for which a federate can wait, beside the time.

use core::fmt;

use lf_coordination::Endpoint;
use lf_coordination::federate::Phase;
use lf_model::time::{EventTag, Instant, Tag};
use lf_texts::say;

use crate::error::PeerFault;
use crate::platform::NetError;

/// The reason for which a federate waits.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Reason {
    /// An RTI that accepts its connection at this address; the error of the last attempt.
    Rti(Endpoint, Option<NetError>),
    /// Its id, which the RTI says is in use.
    Id,
    /// An answer of the RTI in the handshake.
    Answer(Phase),
    /// Another federate that accepts its connection; the fault of the last attempt.
    Peer(u16, Option<PeerFault>),
    /// The start time, which the RTI sends when all federates are ready.
    Others,
    /// A grant of the RTI for this tag.
    Grant(Tag),
    /// A value or an absence at this tag from the named connection.
    Input(Tag, &'static str),
    /// Others that have to accept the messages of this tag: the RTI, or another federate.
    Room(Tag, Option<u16>),
}

impl Reason {
    /// Returns whether the federate has not started yet.
    pub(super) fn is_before_start(&self) -> bool {
        matches!(self, Self::Rti(..) | Self::Id | Self::Answer(_) | Self::Peer(..) | Self::Others)
    }

    /// Returns what distinguishes this wait from others. A fault of a federate does not make another wait of it.
    pub(super) fn key(&self) -> Key {
        match *self {
            Self::Rti(..) => (Tag::NEVER, 0, 0),
            Self::Others => (Tag::NEVER, 1, 0),
            Self::Answer(phase) => (Tag::NEVER, 2, phase as usize),
            Self::Peer(federate, _) => (Tag::NEVER, 3, federate.into()),
            Self::Grant(tag) => (tag, 4, 0),
            // The names of inputs are constants of the program, each at its own address.
            Self::Input(tag, name) => (tag, 5, name.as_ptr().addr()),
            Self::Room(tag, None) => (tag, 6, 0),
            Self::Room(tag, Some(federate)) => (tag, 7, federate.into()),
            Self::Id => (Tag::NEVER, 8, 0),
        }
    }
}

/// The identity of a wait.
pub(super) type Key = (Tag, u8, usize);

/// The text of a reason: after "waiting for".
pub(crate) struct ReasonText(pub(crate) Reason, pub(crate) Instant);

impl fmt::Display for ReasonText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(reason, start) = *self;
        let at = |tag| EventTag::relative(tag, start);
        match reason {
            // There are no direct connections.
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

/// Advice about a wait, in words: the text behind its duration.
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
