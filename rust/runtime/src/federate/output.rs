// SPDX-License-Identifier: Apache-2.0
//! Where the engine sends to, and what it sees of the world, while a tag runs.

use lf_coordination::federate::Federate;
use lf_coordination::to_wire;
use lf_model::{Env, NetworkOutput, Outgoing, Outside, SendError};
use lf_wire::{Message, PushError};

use super::is_decentralized;
use super::link::Link;
use super::peers::{Outbound, Peers};
use crate::description::{CONTROL_BYTES, PEERS, TAGGED_MESSAGE_HEADER_BYTES};
use crate::platform::{Observation, Platform};

/// The connection to the RTI as the engine's environment.
pub(super) struct Output<'a, 's, 'c, P> {
    platform: &'a mut P,
    link: &'a mut Link<'s>,
    peers: &'a mut Peers<'s>,
    /// To which federates the outbound connections lead.
    peers_out: &'a [u16],
    machine: &'a mut Federate<'c>,
    /// Nothing is sent any more.
    silent: bool,
}

impl<'a, 's, 'c, P: Platform> Output<'a, 's, 'c, P> {
    pub(super) fn new(
        platform: &'a mut P,
        link: &'a mut Link<'s>,
        peers: &'a mut Peers<'s>,
        peers_out: &'a [u16],
        machine: &'a mut Federate<'c>,
        silent: bool,
    ) -> Self {
        Self { platform, link, peers, peers_out, machine, silent }
    }
}

impl<P: Platform> Output<'_, '_, '_, P> {
    /// Sees to it that a message of so many bytes fits, beside what coordination may have to say.
    fn make_room(&mut self, bytes: usize) -> Result<(), SendError> {
        let needed = bytes.saturating_add(CONTROL_BYTES);
        if self.link.buffers.output.room() < needed {
            self.link.flush(self.platform);
        }
        if self.link.buffers.output.room() < needed { Err(SendError::NoRoom) } else { Ok(()) }
    }
}

impl<'s, P: Platform> Output<'_, 's, '_, P> {
    /// The connection to this federate, with room for a message with so many bytes of payload if the system takes what
    /// is before it. `None` when it has left: then nothing is sent.
    fn peer(&mut self, federate: u16, payload_bytes: usize) -> Option<(&mut Outbound<'s>, &mut P)> {
        let index = self.peers_out.iter().position(|peer| *peer == federate)?;
        let peer = self.peers.outbound.get_mut(index)?;
        if peer.output.room() < payload_bytes.saturating_add(TAGGED_MESSAGE_HEADER_BYTES) {
            peer.flush(self.platform);
        }
        (!peer.has_ended()).then_some((peer, self.platform))
    }

    /// Sends to another federate past the RTI; over a logical connection with this tag.
    fn send_directly(&mut self, message: &Outgoing<'_>, tag: Option<lf_wire::Tag>) -> Result<(), SendError> {
        let output = message.output;
        let Some((peer, platform)) = self.peer(output.federate, output.max_len) else {
            if tag.is_some() {
                self.lose(output.federate);
            }
            return Ok(());
        };
        let encode = |bytes: &mut [u8]| message.encode(bytes);
        let pushed = match tag {
            None => peer.output.push_p2p_with(output.port, output.federate, output.max_len, encode),
            Some(tag) => peer.output.push_p2p_tagged_with(output.port, output.federate, tag, output.max_len, encode),
        };
        match pushed {
            Ok(_) => {
                if tag.is_some() {
                    let Outgoing { output: NetworkOutput { federate, port, .. }, tag, .. } = *message;
                    platform.observe(Observation::Sends { federate: *federate, port: *port, tag });
                    // At once, for its receiver may be waiting only for a time.
                    peer.flush(platform);
                }
                Ok(())
            }
            Err(PushError::Payload(error)) => Err(SendError::Payload(error)),
            Err(PushError::Encode(_) | PushError::PayloadOverrun { .. }) => {
                peer.stuck = peer.stuck.or(Some(platform.now()));
                Err(SendError::NoRoom)
            }
        }
    }

    /// A message has a tag, and is for a federate that has left.
    fn lose(&mut self, federate: u16) {
        let index = self.peers_out.iter().position(|peer| *peer == federate);
        if index.and_then(|index| self.peers.outbound.get_mut(index)).is_some_and(Outbound::lose) {
            log::warn!("federate {federate} has left: messages to it are lost");
        }
    }

    /// Tells another federate past the RTI that an output has no value.
    fn tell_absent_directly(&mut self, federate: u16, message: &Message<'_>) -> Result<(), SendError> {
        let Some((peer, platform)) = self.peer(federate, 0) else { return Ok(()) };
        if peer.output.push(message).is_err() {
            peer.stuck = peer.stuck.or(Some(platform.now()));
            return Err(SendError::NoRoom);
        }
        peer.flush(platform);
        Ok(())
    }
}

impl<P: Platform> Env for Output<'_, '_, '_, P> {
    fn outside(&self) -> &'static dyn Outside {
        self.platform.outside()
    }

    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError> {
        if PEERS && message.output.physical {
            return self.send_directly(message, None);
        }
        if self.silent || !self.machine.may_send(message.tag) {
            // Nobody gets as far as this tag.
            return Ok(());
        }
        let tag = to_wire(message.tag);
        if is_decentralized(self.machine.coordination()) {
            return self.send_directly(message, Some(tag));
        }
        self.make_room(message.output.max_len.saturating_add(TAGGED_MESSAGE_HEADER_BYTES))?;
        let output = message.output;
        let pushed =
            self.link
                .buffers
                .output
                .push_tagged_with(output.port, output.federate, tag, output.max_len, |bytes| message.encode(bytes));
        match pushed {
            Ok(_) => {
                self.machine.sent();
                Ok(())
            }
            Err(PushError::Payload(error)) => Err(SendError::Payload(error)),
            Err(PushError::Encode(_) | PushError::PayloadOverrun { .. }) => Err(SendError::NoRoom),
        }
    }

    fn send_absent(&mut self, output: &'static NetworkOutput, tag: lf_model::time::Tag) -> Result<(), SendError> {
        if self.silent || !self.machine.may_send(tag) {
            return Ok(());
        }
        let message = Message::PortAbsent { port: output.port, federate: output.federate, tag: to_wire(tag) };
        if is_decentralized(self.machine.coordination()) {
            return self.tell_absent_directly(output.federate, &message);
        }
        self.make_room(message.encoded_len())?;
        self.link.buffers.output.push(&message).map_err(|_| SendError::NoRoom)
    }
}
