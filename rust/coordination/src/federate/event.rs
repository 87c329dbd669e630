// SPDX-License-Identifier: Apache-2.0
//! The events that a federate reports to its event loop.

use lf_model::time::{Instant, Tag};

use crate::clock_sync::Estimate;
use crate::{Endpoint, FederateId};

/// The meaning of a message from the RTI for the event loop. The payload is borrowed from the message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event<'m> {
    /// Nothing to do, except that there may be something to transmit.
    None,
    /// The RTI refuses this federate, because its id is taken. That may pass: close the connection, and make a new one
    /// after a while.
    IdInUse,
    /// The RTI has accepted this federate; the initial clock synchronization or the start barrier is next.
    Accepted,
    /// The initial clock synchronization is done; [`Federate::clock`](super::Federate::clock) is set.
    ClockCorrected(Estimate),
    /// Connect to this federate, because this one sends to it directly. Then call [`Federate::peer_connected`] or
    /// [`Federate::peer_lost`].
    ///
    /// [`Federate::peer_connected`]: super::Federate::peer_connected
    /// [`Federate::peer_lost`]: super::Federate::peer_lost
    PeerFound {
        /// The federate.
        federate: FederateId,
        /// The address at which it listens.
        address: Endpoint,
    },
    /// A federate directly upstream has left: nothing more comes from it, until it comes again if it is transient.
    UpstreamLeft(FederateId),
    /// A transient federate directly upstream has come: its first tag is later than all that have been granted.
    #[cfg(feature = "transients")]
    UpstreamCame(FederateId),
    /// A transient federate has come to which this one sends directly: call [`Federate::find_peer`] while this one
    /// runs.
    ///
    /// [`Federate::find_peer`]: super::Federate::find_peer
    #[cfg(feature = "transients")]
    PeerCame(FederateId),
    /// Such a federate has left: close the connection to it.
    #[cfg(feature = "transients")]
    PeerLeft(FederateId),
    /// The RTI tells this federate to leave, mostly because another instance takes its place: it stops alone, one
    /// microstep after its current tag.
    #[cfg(feature = "transients")]
    Replaced,
    /// All federates have joined: logical time begins at this physical time.
    Started(Instant),
    /// This federate, which is transient, has joined the federation.
    #[cfg(feature = "transients")]
    Joined {
        /// The physical time at which the logical time of the federation began.
        start: Instant,
        /// The first tag of this federate.
        tag: Tag,
    },
    /// More tags may be possible: all up to and including this one.
    Granted(Tag),
    /// A provisional grant, in a cycle without delay. The federate may begin this tag, and has to begin it even without
    /// an event, but not all of its inputs are known. See [`Federate::demanded_tag`](super::Federate::demanded_tag).
    GrantedProvisionally(Tag),
    /// A value for a network input, later than every tag that has begun, or for the open tag of a provisional grant.
    /// Then it depends on the reactions that have run whether the value is in time.
    Message {
        /// The network input.
        port: u16,
        /// The tag at which it is present.
        tag: Tag,
        /// The value.
        payload: &'m [u8],
    },
    /// A value for a network input at a tag after the stop tag, which this federate will not reach.
    MessageAfterStop {
        /// The network input.
        port: u16,
        /// The tag at which it would have been present.
        tag: Tag,
    },
    /// No value will come at a network input up to and including this tag.
    PortAbsent {
        /// The network input.
        port: u16,
        /// The last tag without a value.
        tag: Tag,
    },
    /// Another federate wants to stop. Tags from `tag` on have to wait until the RTI has decided.
    StopRequested(Tag),
    /// The federation stops: `tag` is the last tag of this federate.
    StopGranted(Tag),
}

/// The step after the connection to the RTI has ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Disconnected {
    /// The RTI has not accepted this federate yet: connect again, by [`ConnectRetry`](super::ConnectRetry).
    ConnectAgain,
    /// The federate had ended; there is nothing more to do.
    Ended,
}
