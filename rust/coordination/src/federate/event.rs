// SPDX-License-Identifier: Apache-2.0
//! What the federate tells its event loop.

use lf_model::time::{Instant, Tag};

use crate::clock_sync::Estimate;
use crate::{Endpoint, FederateId};

/// What a message from the RTI means for the event loop. The payload is borrowed from the message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event<'m> {
    /// Nothing; there may be something to transmit.
    None,
    /// The RTI refuses this federate, because its id is taken. That may pass: the connection is to be closed, and a new
    /// one to be made after a while.
    IdInUse,
    /// The RTI has accepted this federate; the initial clock synchronization or the start barrier is next.
    Accepted,
    /// The initial clock synchronization is done; [`Federate::clock`](super::Federate::clock) is set.
    ClockCorrected(Estimate),
    /// To be connected to, because this federate sends to it directly. Then [`Federate::peer_connected`] or
    /// [`Federate::peer_lost`] is to be called.
    ///
    /// [`Federate::peer_connected`]: super::Federate::peer_connected
    /// [`Federate::peer_lost`]: super::Federate::peer_lost
    PeerFound {
        /// The federate.
        federate: FederateId,
        /// Where it listens.
        address: Endpoint,
    },
    /// A federate directly upstream has left: nothing more comes from it.
    UpstreamLeft(FederateId),
    /// All federates have come: logical time begins at this physical time.
    Started(Instant),
    /// More tags may be possible: all up to and including this one.
    Granted(Tag),
    /// A provisional grant, in a cycle without delay: this tag may be begun, and is to be begun even without an event,
    /// but not all is known of its inputs. See [`Federate::demanded_tag`](super::Federate::demanded_tag).
    GrantedProvisionally(Tag),
    /// A value for a network input, later than every tag that has been begun, or for the tag that is open after a
    /// provisional grant. Whether it is in time for that depends on the reactions that have run.
    Message {
        /// The network input.
        port: u16,
        /// When it is present.
        tag: Tag,
        /// The value.
        payload: &'m [u8],
    },
    /// A value for a network input at a tag after the stop tag, which this federate will not reach.
    MessageAfterStop {
        /// The network input.
        port: u16,
        /// When it would have been present.
        tag: Tag,
    },
    /// No value will come at a network input up to and including this tag.
    PortAbsent {
        /// The network input.
        port: u16,
        /// Up to when.
        tag: Tag,
    },
    /// Another federate wants to stop; until the RTI has decided, tags from `tag` on have to wait.
    StopRequested(Tag),
    /// The federation stops: `tag` is the last tag of this federate.
    StopGranted(Tag),
}

/// What to do after the connection to the RTI has ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Disconnected {
    /// The RTI has not accepted this federate yet: connect again, by [`ConnectRetry`](super::ConnectRetry).
    ConnectAgain,
    /// The federate had ended; nothing more is to do.
    Ended,
}
