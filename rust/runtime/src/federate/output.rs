// SPDX-License-Identifier: Apache-2.0
//! The destination of messages while a tag runs: the send buffer of the session, or of a direct connection.

use lf_coordination::federate::Needs;
#[cfg(feature = "transients")]
use lf_model::HandedOver;
#[cfg(feature = "traces")]
use lf_model::time::Instant;
use lf_model::time::Tag;
use lf_model::{NetworkOutput, Outgoing, Outside, PayloadError, SendError};
#[cfg(feature = "transients")]
use lf_wire::HANDED_OVER_PORT;
use lf_wire::{Message, MessageType, PushError};

use super::execution::Outlet;
use super::outbound::Outbound;
use super::peers::Peers;
use super::session::Session;
use crate::description::{CONTROL_BYTES, TAGGED_MESSAGE_HEADER_BYTES};
use crate::log_event::{PeerEvent, report};
use crate::platform::Platform;
use crate::trace::{Event, RTI, Recording, TracedMessage};
use log::Level;

/// The connections of a federate, to send over.
pub(super) struct Output<'x, 'a, 's, P, N> {
    pub(super) platform: &'x mut P,
    pub(super) recording: Recording<'x>,
    pub(super) session: &'x mut Session<'a, 's>,
    pub(super) peers: &'x mut Peers<'a, 's, N>,
    /// Whether a direct message is written at once, because its receiver may be waiting only for a time. Those of the
    /// later tags of a turn, which are late already, go together at its end: a write takes as long as many short tags.
    pub(super) at_once: bool,
}

impl<'x, 's, P: Platform, N: Needs> Output<'x, '_, 's, P, N> {
    /// Makes room for a message of this many bytes, beside the control messages.
    fn make_room(&mut self, bytes: usize) -> Result<(), SendError> {
        let needed = bytes.saturating_add(CONTROL_BYTES);
        if self.session.output().room() < needed {
            self.session.flush(self.platform);
        }
        if self.session.output().room() < needed { Err(SendError::NoRoom) } else { Ok(()) }
    }

    /// Adds a tagged message to a port of a federate for the RTI, whose payload `encode` writes. Returns the length of
    /// that.
    fn push(
        &mut self,
        (port, federate): (u16, u16),
        tag: lf_wire::Tag,
        max_len: usize,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> Result<usize, SendError> {
        self.make_room(max_len.saturating_add(TAGGED_MESSAGE_HEADER_BYTES))?;
        match self.session.output().push_tagged_with(port, federate, tag, max_len, encode) {
            Ok(bytes) => Ok(bytes),
            Err(PushError::Payload(error)) => Err(SendError::Payload(error)),
            Err(PushError::Encode(_) | PushError::PayloadOverrun { .. }) => Err(SendError::NoRoom),
        }
    }

    /// Returns the connection to this federate, with room for a message with this many bytes of payload if the system
    /// accepts what is before it. Returns `None` when the federate has left or is absent: then nothing is sent.
    fn peer(&mut self, federate: u16, payload_bytes: usize) -> Option<(&mut Outbound<'s>, &mut P, &mut Recording<'x>)> {
        let peer = self.peers.to(federate)?;
        if peer.output().room() < payload_bytes.saturating_add(TAGGED_MESSAGE_HEADER_BYTES) {
            peer.flush(self.platform);
        }
        peer.is_open().then_some((peer, self.platform, &mut self.recording))
    }
}

#[cfg(feature = "transients")]
impl<P: Platform, N: Needs> Output<'_, '_, '_, P, N> {
    /// Sends the RTI a state, for the instance that takes the place of this federate.
    pub(super) fn hand_over(
        &mut self,
        state: &HandedOver,
        federate: u16,
        tag: lf_wire::Tag,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> Result<(), SendError> {
        let max_len = state.max_len.saturating_add(HandedOver::ID_BYTES);
        let encode = |bytes: &mut [u8]| {
            let (id, value) = bytes.split_at_mut_checked(HandedOver::ID_BYTES).ok_or(PayloadError::Absent)?;
            id.copy_from_slice(&state.id.to_le_bytes());
            encode(value).map(|len| len + HandedOver::ID_BYTES)
        };
        self.push((HANDED_OVER_PORT, federate), tag, max_len, encode).map(|_| ())
    }
}

/// Returns the event of a value with this many bytes that goes to the other end of a connection.
fn sent(kind: MessageType, message: &Outgoing<'_>, tag: Option<Tag>, peer: u16, bytes: usize) -> Event {
    let to = (message.output.federate, message.output.port);
    let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
    Event::Sent(TracedMessage { kind, peer, to, tag, bytes })
}

impl<P: Platform, N: Needs> Outlet for Output<'_, '_, '_, P, N> {
    fn outside(&self) -> &'static dyn Outside {
        self.platform.outside()
    }

    fn send(&mut self, message: &Outgoing<'_>, tag: lf_wire::Tag) -> Result<(), SendError> {
        let NetworkOutput { port, federate, max_len, .. } = *message.output;
        let bytes = self.push((port, federate), tag, max_len, |bytes| message.encode(bytes))?;
        let event = sent(MessageType::TaggedMessage, message, Some(message.tag), RTI, bytes);
        self.recording.note(self.platform, event);
        Ok(())
    }

    fn send_control(&mut self, message: &Message<'_>) -> Result<(), SendError> {
        self.make_room(message.encoded_len())?;
        self.session.output().push(message).map_err(|_| SendError::NoRoom)?;
        self.recording.note_sent(self.platform, message, RTI);
        Ok(())
    }

    fn send_directly(&mut self, message: &Outgoing<'_>, tag: Option<lf_wire::Tag>) -> Result<(), SendError> {
        let NetworkOutput { port, federate, max_len, .. } = *message.output;
        let at_once = self.at_once;
        let Some((peer, platform, recording)) = self.peer(federate, max_len) else {
            let is_lost = tag.is_some() && !self.peers.may_be_absent(federate);
            if is_lost && self.peers.to(federate).is_some_and(Outbound::lose) {
                report(Level::Warn, &PeerEvent::Left(federate));
            }
            return Ok(());
        };
        let encode = |bytes: &mut [u8]| message.encode(bytes);
        match peer.output().push_p2p_with(port, federate, tag, max_len, encode) {
            Ok(bytes) => {
                let kind = tag.map_or(MessageType::P2pMessage, |_| MessageType::P2pTaggedMessage);
                recording.note(platform, sent(kind, message, tag.map(|_| message.tag), federate, bytes));
                if at_once && tag.is_some() {
                    peer.flush(platform);
                }
                Ok(())
            }
            Err(PushError::Payload(error)) => Err(SendError::Payload(error)),
            Err(PushError::Encode(_) | PushError::PayloadOverrun { .. }) => {
                peer.is_full(platform.now());
                Err(SendError::NoRoom)
            }
        }
    }

    fn send_control_directly(&mut self, federate: u16, message: &Message<'_>) -> Result<(), SendError> {
        let at_once = self.at_once;
        let Some((peer, platform, recording)) = self.peer(federate, 0) else { return Ok(()) };
        if peer.output().push(message).is_err() {
            peer.is_full(platform.now());
            return Err(SendError::NoRoom);
        }
        recording.note_sent(platform, message, federate);
        if at_once {
            peer.flush(platform);
        }
        Ok(())
    }

    #[cfg(feature = "traces")]
    fn note(&mut self, at: Option<Instant>, event: Event) {
        let at = at.unwrap_or_else(|| self.platform.now());
        self.recording.note_at(at, event);
    }
}
