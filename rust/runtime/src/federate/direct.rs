// SPDX-License-Identifier: Apache-2.0
//! What the event loop does with its connections to other federates.
//!
//! Over one connection come messages for several inputs. One that finds no room in the queue of its input is held where
//! it lies, and what comes behind it for other inputs is taken: with decentralized coordination, word of those may be
//! what lets the tag begin that makes room.

use lf_coordination::federate::{Awaited, Phase};
use lf_coordination::{Tally, Times, from_wire};
use lf_model::time::{EventTag, Instant, Tag};
use lf_model::{Delivery, Engine, InputId, NetworkInput, Program, ReactionKind};
use lf_wire::{InBuffer, Limits, Message, tag_in_header};

use super::FederateLoop;
use super::input::{next_at, too_long};
use crate::description::{PEERS, TAGGED_MESSAGE_HEADER_BYTES};
use crate::error::{PeerFault, RunError};
use crate::platform::{Observation, Platform};

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Makes the connections to other federates, and takes those that come from them.
    pub(super) fn meet_peers(&mut self) -> Result<(), RunError> {
        if !PEERS {
            return Ok(());
        }
        let begun = self.machine.phase() >= Phase::Running;
        self.peers.welcome(self.platform, self.federation_id, self.federation.peers_in, begun);
        self.peers.look_for_ends(self.platform);
        let Some(index) = self.meeting.filter(|_| self.machine.phase() == Phase::Meeting) else { return Ok(()) };
        let introduction = Message::P2pSendingFedId { federate: self.federation.id, federation_id: self.federation_id };
        let outcome = self.peers.establish(self.platform, index, &introduction);
        let now = self.platform.now();
        if let Some(connected) = outcome {
            self.meeting = None;
            if connected {
                self.machine.peer_connected(now);
            } else {
                let fault = self.peers.trouble(index).unwrap_or(PeerFault::Unanswered);
                let federate = self.federation.peers_out.get(index).copied().unwrap_or_default();
                log::debug!("federate {federate} {fault}");
                self.machine.peer_lost(now).map_err(|_| RunError::Peer { federate, fault })?;
            }
        }
        Ok(())
    }

    /// Takes what other federates have sent, as far as there is room for it.
    pub(super) fn receive_directly(&mut self) -> Result<(), RunError> {
        if self.takes_messages() {
            for inbound in self.peers.inbound.iter_mut().filter(|inbound| inbound.from.is_some()) {
                inbound.fill(self.platform);
            }
        }
        self.take_messages()
    }

    /// Takes what has come until now, though no wait has told of it. `true` when there was something.
    pub(super) fn sweep(&mut self) -> Result<bool, RunError> {
        let mut any = false;
        if self.takes_messages() {
            for inbound in self.peers.inbound.iter_mut().filter(|inbound| inbound.from.is_some()) {
                any |= inbound.fill_now(self.platform);
            }
        }
        self.take_messages()?;
        Ok(any)
    }

    /// Sends other federates what is still to be sent, and closes the connections to them. With decentralized
    /// coordination, one that `resigned` also reads what they send until they end too: what comes now is late. `false`
    /// when there is nothing left to do, or at a time no time for it.
    pub(super) fn take_leave_of_peers(&mut self, resigned: bool, until: Instant) -> bool {
        let in_time = self.platform.now() < until;
        let hears = resigned && self.is_decentralized() && self.hear_out(in_time);
        let sends = self.peers.take_leave(self.platform, hears) && in_time;
        if !hears && !sends {
            self.peers.close(self.platform);
        }
        hears || sends
    }

    /// Reads once what other federates send at their end. `true` while more can come, and there is time.
    fn hear_out(&mut self, in_time: bool) -> bool {
        if let Err(error) = self.sweep() {
            log::warn!("what another federate sent at the end could not be read: {error}");
            return false;
        }
        if !in_time {
            for from in self.peers.inbound.iter().filter_map(|inbound| inbound.from) {
                log::warn!("federate {from} does not end: what it may still send is not waited for");
            }
        }
        in_time && self.peers.can_receive()
    }

    /// Whether messages of other federates can be taken. After its end a federate still looks for those that came late.
    fn takes_messages(&self) -> bool {
        match self.machine.phase() {
            Phase::Running => PEERS,
            Phase::Resigning | Phase::Ended => self.is_decentralized(),
            _ => false,
        }
    }

    /// Takes what lies in the receive buffers, as far as there is room for it; bounded by their sizes.
    pub(super) fn take_messages(&mut self) -> Result<(), RunError> {
        self.peers.stale = false;
        if !self.takes_messages() {
            return Ok(());
        }
        let mut receiver = Receiver {
            now: self.machine.clock().physical(self.platform.now()),
            engine: &mut self.engine,
            program: &mut *self.program,
            awaited: &mut self.awaited,
            federate: self.federation.id,
            late: &mut self.late,
        };
        for inbound in self.peers.inbound.iter_mut() {
            let Some(from) = inbound.from else { continue };
            let mut alike = inbound.held.release();
            let limits = Limits {
                payload_bytes_max: inbound.input.capacity().saturating_sub(TAGGED_MESSAGE_HEADER_BYTES),
                ..Limits::NONE
            };
            let fault = |fault| RunError::Peer { federate: from.0, fault };
            loop {
                let next = next_at(&inbound.input, inbound.held.bytes(), &limits);
                let next = next.map_err(|error| {
                    let bytes = inbound.input.bytes().get(inbound.held.bytes()..).unwrap_or_default();
                    too_long(bytes, error, receiver.engine).unwrap_or(fault(PeerFault::Bytes(error)))
                });
                let Some((message, length)) = next? else { break };
                if let Message::P2pTaggedMessage { port, tag, .. } = message {
                    self.platform.observe(Observation::Receives { port, tag: from_wire(tag) });
                }
                match receiver.take(from.0, &message).map_err(|refusal| refusal.of(from.0))? {
                    None => {
                        inbound.input.remove(inbound.held.bytes(), length);
                        alike = alike.saturating_sub(length);
                    }
                    // With those behind it, whose tags are later.
                    Some((tag, input)) => inbound.held.hold(length.max(core::mem::take(&mut alike)), tag, Some(input)),
                }
            }
            // What is left is the beginning of a message that will not become whole.
            if inbound.has_ended() && inbound.held.bytes() == 0 {
                if !inbound.input.bytes().is_empty() {
                    log::warn!("federate {from} has left in the middle of a message");
                }
                inbound.close(self.platform);
                receiver.left(from.0);
            } else if inbound.has_ended() {
                receiver.is_leaving(from.0, &inbound.input, inbound.held.bytes(), &limits);
            }
        }
        Ok(())
    }

    /// Whether a message for an earlier tag than this has begun to come, and is not whole yet. The rest of one that
    /// finds no room in the receive buffer, behind messages that wait for room themselves, comes only when a tag has
    /// made some.
    pub(super) fn awaits_rest_before(&mut self, tag: Tag) -> bool {
        self.peers.inbound.iter_mut().filter(|inbound| inbound.from.is_some() && !inbound.has_ended()).any(|inbound| {
            let rest = inbound.input.bytes().get(inbound.held.bytes()..).unwrap_or_default();
            let is_earlier = tag_in_header(rest).is_some_and(|earlier| from_wire(earlier) < tag);
            is_earlier && !inbound.input.space().is_empty()
        })
    }
}

/// Messages that have come too late.
#[derive(Debug, Default)]
pub(super) struct Late {
    pub(super) messages: u64,
    /// Those of them that not all reactions handle.
    pub(super) unhandled: u64,
    /// The same, to tell them now and then.
    told: Tally,
}

impl Late {
    /// One more that not all reactions handle: how loudly it is said, with how many there have been.
    fn count_unhandled(&mut self) -> (log::Level, Times) {
        self.unhandled = self.unhandled.saturating_add(1);
        let times = self.told.count();
        (if times.is_told() { log::Level::Warn } else { log::Level::Debug }, times)
    }
}

/// The parts of the loop that a message of another federate changes.
struct Receiver<'a, 's> {
    engine: &'a mut Engine<'s>,
    program: &'a mut dyn Program,
    awaited: &'a mut Awaited<'s>,
    late: &'a mut Late,
    /// This federate.
    federate: u16,
    /// The federation's physical time.
    now: Instant,
}

/// Why a message cannot be used.
enum Refusal {
    Fault(PeerFault),
    Error(RunError),
}

impl Refusal {
    fn of(self, federate: u16) -> RunError {
        match self {
            Self::Fault(fault) => RunError::Peer { federate, fault },
            Self::Error(error) => error,
        }
    }
}

impl Receiver<'_, '_> {
    /// Takes a message of this federate; `Some` when it has to wait for room, with its tag.
    fn take(&mut self, from: u16, message: &Message<'_>) -> Result<Option<(Tag, InputId)>, Refusal> {
        let (port, federate, tag) = match *message {
            Message::P2pMessage { port, federate, .. } => (port, federate, None),
            Message::P2pTaggedMessage { port, federate, tag, .. } | Message::PortAbsent { port, federate, tag } => {
                (port, federate, Some(from_wire(tag)))
            }
            _ => return Err(Refusal::Fault(PeerFault::Unexpected(message.name()))),
        };
        let input = InputId(port);
        let info = self.engine.tables().inputs.get(usize::from(port));
        let fits =
            |info: &&NetworkInput| federate == self.federate && info.federate == from && info.physical == tag.is_none();
        let Some(info) = info.filter(fits) else {
            return Err(Refusal::Fault(PeerFault::WrongInput { federate, port }));
        };
        // What comes after the last tag needs no room.
        let needs_room = tag.is_none_or(|tag| tag <= self.engine.stop_tag()) && !self.engine.is_done();
        if needs_room && !self.engine.has_room(self.program, input) {
            return Ok(Some((tag.unwrap_or(Tag::FOREVER), input)));
        }
        match (*message, tag) {
            (Message::P2pTaggedMessage { payload, .. }, Some(tag)) => {
                let delivery = self.engine.deliver_tardy(self.program, input, tag, payload);
                let delivery = delivery.map_err(|error| Refusal::Error(error.into()))?;
                self.awaited.learn(port, happens(delivery).unwrap_or(tag));
                self.report(info, tag, delivery);
            }
            (Message::P2pMessage { payload, .. }, _) => {
                let delivery = self.engine.deliver_physical(self.program, input, self.now, payload);
                delivery.map_err(|error| Refusal::Error(error.into()))?;
            }
            (_, Some(tag)) => self.awaited.learn(port, tag),
            (_, None) => {}
        }
        Ok(None)
    }

    /// This federate sends nothing any more.
    fn left(&mut self, from: u16) {
        log::debug!("federate {from} has left");
        for (port, _) in (0..).zip(self.engine.tables().inputs).filter(|(_, input)| input.federate == from) {
            self.awaited.learn(port, Tag::FOREVER);
        }
    }

    /// This federate has ended, and the last that it has sent waits for room: nothing more comes at its other inputs,
    /// and a tag that makes room may have to wait for them.
    fn is_leaving(&mut self, from: u16, buffer: &InBuffer<&mut [u8]>, held: usize, limits: &Limits) {
        let waits = |awaited: u16| {
            let mut at = 0;
            while at < held {
                match next_at(buffer, at, limits) {
                    Ok(Some((Message::P2pTaggedMessage { port, .. } | Message::PortAbsent { port, .. }, length))) => {
                        if port == awaited {
                            return true;
                        }
                        at += length;
                    }
                    Ok(Some((_, length))) => at += length,
                    Ok(None) | Err(_) => return true,
                }
            }
            false
        };
        for (port, _) in (0..).zip(self.engine.tables().inputs).filter(|(_, input)| input.federate == from) {
            if !waits(port) {
                self.awaited.learn(port, Tag::FOREVER);
            }
        }
    }

    /// Says what has come too late, and counts it.
    fn report(&mut self, info: &NetworkInput, tag: Tag, delivery: Delivery) {
        let start = self.engine.start_time();
        let (name, intended) = (info.name, EventTag::relative(tag, start));
        let lateness = self.now.duration_since(tag.time);
        match delivery {
            Delivery::InTime(_) => return,
            Delivery::AfterStop => {
                log::info!("a message over {name} is for {intended}, after the last tag: it does not happen");
                return;
            }
            Delivery::Tardy(actual) if self.is_handled(info) => {
                let actual = EventTag::relative(actual, start);
                log::debug!("late message over {name} for {intended}: it happens at {actual}, {lateness:?} late");
            }
            Delivery::Tardy(actual) => {
                let (level, times) = self.late.count_unhandled();
                let (federate, actual) = (self.federate, EventTag::relative(actual, start));
                log::log!(
                    level,
                    "late message to federate {federate} over {name} for {intended}: it happens at {actual}, \
                     {lateness:?} after its time{times}",
                );
            }
            Delivery::Lost => {
                let (level, times) = self.late.count_unhandled();
                let federate = self.federate;
                log::log!(
                    level,
                    "late message to federate {federate} over {name} for {intended}: it came {lateness:?} after its \
                     time, and after the last tag, so it does not happen{times}",
                );
            }
        }
        self.late.messages = self.late.messages.saturating_add(1);
    }

    /// Whether every reaction that a value of this input triggers has a handler for tardy ones.
    fn is_handled(&self, info: &NetworkInput) -> bool {
        let tables = self.engine.tables();
        let port = tables.triggers.get(usize::from(info.trigger.0)).and_then(|trigger| trigger.kind.fills());
        let reactions =
            port.and_then(|port| tables.ports.get(usize::from(port.0))).map_or(&[][..], |port| port.reactions);
        let handles = |reaction: &lf_model::ReactionInfo| reaction.kind == ReactionKind::Body && reaction.tardy;
        !reactions.is_empty() && reactions.iter().all(|id| tables.reactions.get(usize::from(id.0)).is_some_and(handles))
    }
}

/// The tag at which a message happens, if it does.
fn happens(delivery: Delivery) -> Option<Tag> {
    match delivery {
        Delivery::InTime(tag) | Delivery::Tardy(tag) => Some(tag),
        Delivery::AfterStop | Delivery::Lost => None,
    }
}
