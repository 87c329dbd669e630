// SPDX-License-Identifier: Apache-2.0
//! Direct connections with other federates: one in each direction in which something is sent.
//!
//! Each has a bounded buffer of its own: what does not fit there keeps the sender's tag open. Other parts examine the
//! messages; this part makes the connections, accepts those of others, and ends them.

use core::marker::PhantomData;

use lf_coordination::federate::Needs;
use lf_coordination::{Deadline, Endpoint, FederateId};
use lf_model::NetworkOutput;
use lf_model::time::{Instant, Tag};
use lf_wire::{Message, RejectCode};

use super::accept_queue::{AcceptQueue, Introduced, refuse, refuse_transient};
use super::inbound::Inbound;
use super::outbound::Outbound;
use crate::description::Federation;
use crate::error::PeerFault;
#[cfg(feature = "security")]
use crate::platform::Participant;
use crate::platform::{Interest, NetError, Platform, SocketId};
use crate::trace::Recording;

/// The outputs of a federate, some of which lead directly to their receivers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outputs {
    outputs: &'static [NetworkOutput],
    is_decentralized: bool,
}

impl Outputs {
    /// Returns all outputs of a federate; those without a tag, or with decentralized coordination all, are direct.
    pub(super) fn new(outputs: &'static [NetworkOutput], is_decentralized: bool) -> Self {
        Self { outputs, is_decentralized }
    }

    /// Returns the direct outputs to this federate.
    fn to(&self, federate: u16) -> impl Iterator<Item = &'static NetworkOutput> {
        let is_direct = |output: &&NetworkOutput| output.physical || self.is_decentralized;
        self.outputs.iter().filter(move |output| output.federate == federate && is_direct(output))
    }
}

/// All connections with other federates.
#[derive(Debug)]
pub(super) struct Peers<'a, 's, N> {
    outbound: &'s mut [Outbound<'s>],
    inbound: &'s mut [Inbound<'s>],
    accept_queue: AcceptQueue,
    federation: &'a Federation,
    federation_id: &'a [u8],
    /// The index of the outbound connection that is being made.
    meeting: Option<usize>,
    /// Whether messages wait in a receive buffer, and there may be room for them now.
    stale: bool,
    needs: PhantomData<N>,
}

impl<'a, 's, N: Needs> Peers<'a, 's, N> {
    /// Returns connections to the federates of [`Federation::peers_out`], in the same order, and slots for those from
    /// [`Federation::peers_in`].
    pub(super) fn new(
        outbound: &'s mut [Outbound<'s>],
        inbound: &'s mut [Inbound<'s>],
        federation: &'a Federation,
        federation_id: &'a [u8],
    ) -> Self {
        let (accept_queue, needs) = (AcceptQueue::default(), PhantomData);
        Self { outbound, inbound, accept_queue, federation, federation_id, meeting: None, stale: false, needs }
    }

    /// Returns the connections that lead here.
    pub(super) fn inbound(&mut self) -> &mut [Inbound<'s>] {
        if N::PEERS_IN { self.inbound } else { &mut [] }
    }

    /// Returns the connections that lead to others.
    fn outbound(&self) -> &[Outbound<'s>] {
        if N::PEERS_OUT { self.outbound } else { &[] }
    }

    fn outbound_mut(&mut self) -> &mut [Outbound<'s>] {
        if N::PEERS_OUT { self.outbound } else { &mut [] }
    }

    /// Returns the connections that lead to others, with their receivers.
    pub(super) fn receivers(&self) -> impl Iterator<Item = (u16, &Outbound<'s>)> {
        self.federation.peers_out.iter().copied().zip(self.outbound())
    }

    /// Returns the connection to this federate.
    pub(super) fn to(&mut self, federate: u16) -> Option<&mut Outbound<'s>> {
        let index = self.federation.peers_out.iter().position(|peer| *peer == federate)?;
        self.outbound_mut().get_mut(index)
    }

    /// Returns whether a federate, this one or a neighbor, comes and goes while the federation runs.
    pub(super) fn may_be_absent(&self, federate: u16) -> bool {
        N::TRANSIENTS && self.federation.is_transient(federate)
    }

    /// Returns whether a federate that sends to this one can come while the federation runs: a transient one, or one
    /// that finds this transient one anew.
    fn may_come_again(&self) -> bool {
        let mut senders = self.federation.peers_in.iter().copied().chain([self.federation.id]);
        N::TRANSIENTS && senders.any(|federate| self.may_be_absent(federate))
    }

    /// Handles that a transient federate to which this one sends has come or left.
    #[cfg(feature = "transients")]
    pub(super) fn expect<P: Platform>(&mut self, platform: &mut P, federate: FederateId, is_here: bool) {
        log::debug!("federate {federate} has {}", if is_here { "come" } else { "left" });
        if !is_here && self.meeting.and_then(|index| self.federation.peers_out.get(index)) == Some(&federate.0) {
            self.meeting = None;
        }
        if let Some(outbound) = self.to(federate.0) {
            outbound.expect(platform, is_here);
        }
    }

    /// Sets the time at which to look again for a transient federate, which has come and could not be reached.
    #[cfg(feature = "transients")]
    pub(super) fn look_again(&mut self, federate: u16, at: Instant) {
        if self.may_be_absent(federate)
            && let Some(outbound) = self.to(federate)
        {
            outbound.look_again(Some(at));
        }
    }

    /// Returns a transient federate to look for, which has come.
    #[cfg(feature = "transients")]
    pub(super) fn wanted(&self, now: Instant) -> Option<FederateId> {
        let mut receivers = self.receivers();
        receivers.find(|(_, outbound)| outbound.is_wanted(now)).map(|(federate, _)| FederateId(federate))
    }

    /// Returns whether held messages may have room that the last call did not report.
    pub(super) fn take_stale(&mut self) -> bool {
        core::mem::take(&mut self.stale)
    }

    /// Handles that a tag has begun: there may be room for held messages.
    pub(super) fn recheck(&mut self) {
        let mut stale = false;
        for inbound in self.inbound() {
            inbound.receiver.held.recheck();
            stale |= inbound.receiver.held.stale;
        }
        self.stale = stale;
    }

    /// Opens the port for connections, if any are to come; returns its number.
    pub(super) fn listen<P: Platform>(&mut self, platform: &mut P) -> Result<Option<u16>, NetError> {
        if self.inbound().is_empty() {
            return Ok(None);
        }
        self.accept_queue.listen(platform).map(Some)
    }

    /// Begins to connect to this federate.
    pub(super) fn connect<P: Platform>(&mut self, platform: &mut P, federate: FederateId, address: Endpoint) {
        log::debug!("connecting to federate {federate} at {address}");
        self.meeting = self.federation.peers_out.iter().position(|peer| *peer == federate.0);
        if let Some(outbound) = self.to(federate.0) {
            outbound.connect(platform, federate.0, address);
        }
    }

    /// Advances the connection that is being made. Returns `Some` when it is there, or cannot be made.
    pub(super) fn establish<P: Platform>(&mut self, platform: &mut P) -> Option<Result<(), (u16, PeerFault)>> {
        let index = self.meeting.filter(|_| N::PEERS_OUT)?;
        let (federate, federation_id) = (self.federation.id, self.federation_id);
        let is_transient = self.may_be_absent(federate);
        let outbound = self.outbound_mut().get_mut(index)?;
        let is_transient = if is_transient { Some(true) } else { outbound.says_transient() };
        let introduction = Message::P2pSendingFedId { federate, is_transient, federation_id };
        let connected = outbound.establish(platform, &introduction)?;
        let fault = outbound.fault.unwrap_or(PeerFault::Unanswered);
        self.meeting = None;
        let federate = self.federation.peers_out.get(index).copied().unwrap_or_default();
        Some(if connected { Ok(()) } else { Err((federate, fault)) })
    }

    /// Returns the federate to which a connection is being made, or else the one that is `next` among those to which
    /// this one sends, and the fault of the last attempt.
    pub(super) fn meets(&self, next: Option<usize>) -> Option<(u16, Option<PeerFault>)> {
        self.receivers().nth(self.meeting.or(next)?).map(|(federate, outbound)| (federate, outbound.fault))
    }

    /// Accepts pending connections, and admits peers that send their id, as long as this federate has not `begun` with
    /// all of them. Bounded by the number of slots.
    pub(super) fn accept<P: Platform>(&mut self, platform: &mut P, begun: bool) {
        if !N::PEERS_IN {
            return;
        }
        let is_complete = begun && !self.may_come_again();
        if is_complete && self.inbound().iter().all(|inbound| inbound.from.is_some()) {
            return self.close_accept_queue(platform);
        }
        while let Some(peer) = self.accept_queue.receive(platform, self.federation_id) {
            let Introduced { federate, socket, address, is_transient } = peer;
            if is_transient && !self.may_be_absent(federate.0) {
                refuse_transient(platform, peer, self.accept_queue.refused.count());
                continue;
            }
            #[cfg(feature = "security")]
            if !platform.may_be(socket, Participant::Federate(federate.0)) {
                let times = self.accept_queue.refused.count();
                refuse(platform, socket, address, RejectCode::Insecure, times);
                continue;
            }
            match self.place_for(platform, federate, begun) {
                Ok(place) => place.open(platform, federate, socket),
                Err(code) => refuse(platform, socket, address, code, self.accept_queue.refused.count()),
            }
        }
    }

    /// Returns the slot of a federate that has introduced itself, or why there is none.
    fn place_for<P: Platform>(
        &mut self,
        platform: &mut P,
        federate: FederateId,
        begun: bool,
    ) -> Result<&mut Inbound<'s>, RejectCode> {
        let stays = begun && !self.may_be_absent(federate.0);
        if let Some(before) = self.inbound.iter_mut().find(|inbound| inbound.from == Some(federate)) {
            // It may have come anew, because its first connection was lost. What it has sent before comes first.
            before.fill_now(platform);
            if stays || !before.has_ended() || before.receiver.held.bytes > 0 {
                return Err(RejectCode::IdInUse);
            }
            before.close(platform);
        }
        let is_awaited = self.federation.peers_in.contains(&federate.0);
        let vacant = self.inbound.iter_mut().find(|inbound| inbound.from.is_none());
        vacant.filter(|_| is_awaited).ok_or(RejectCode::IdOutOfRange)
    }

    /// Writes what is pending on all connections.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) {
        for outbound in self.outbound_mut() {
            outbound.flush(platform);
        }
    }

    /// Sends the ends of direct connections, as far as there is room for that: those with a delay, and `all` when the
    /// last tag is complete.
    ///
    /// A receiver learns by it that this federate ends in order, and what to wait for at its own last tag.
    pub(super) fn send_ends<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        outputs: &Outputs,
        all: bool,
    ) {
        'federates: for (federate, outbound) in self.federation.peers_out.iter().zip(self.outbound_mut()) {
            let mut before = outbound.ends_sent;
            for delayed in [true, false] {
                let to = outputs.to(*federate).filter(|output| output.delay.is_some() == delayed && (delayed || all));
                for output in to {
                    if before > 0 {
                        before -= 1;
                        continue;
                    }
                    let end =
                        Message::PortAbsent { port: output.port, federate: *federate, tag: lf_wire::Tag::FOREVER };
                    if !outbound.is_open() || outbound.output().push(&end).is_err() {
                        continue 'federates;
                    }
                    recording.note_sent(platform, &end, *federate);
                    outbound.ends_sent += 1;
                }
            }
        }
    }

    /// Sends what is still pending, and closes each connection when that is done. A federate that `ends` in order sends
    /// that first. Those over which something may come stay open as long as this federate `hears`. Returns `false` when
    /// nothing is left to send.
    pub(super) fn leave<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        ends: Option<&Outputs>,
        hears: bool,
    ) -> bool {
        self.close_accept_queue(platform);
        if !hears {
            self.inbound().iter_mut().for_each(|inbound| inbound.close(platform));
        }
        for outbound in self.outbound_mut() {
            outbound.detect_end_now(platform);
        }
        if let Some(outputs) = ends {
            self.send_ends(platform, recording, outputs, true);
        }
        self.flush(platform);
        let mut sends = false;
        for (federate, outbound) in self.federation.peers_out.iter().zip(self.outbound_mut()) {
            let has_said = ends.is_none_or(|outputs| outbound.ends_sent >= outputs.to(*federate).count());
            if outbound.is_empty() && (has_said || !outbound.is_open()) {
                outbound.end(platform);
            } else {
                sends = true;
            }
        }
        sends
    }

    /// Returns the federates that are to send directly and have not connected.
    #[cfg(feature = "transients")]
    pub(super) fn strangers(&self) -> impl Iterator<Item = u16> {
        let has_connected = |federate: u16| self.senders().any(|sender| sender.0 == federate);
        self.federation.peers_in.iter().copied().filter(move |federate| !has_connected(*federate))
    }

    /// Returns the federates that can still send something directly.
    pub(super) fn senders(&self) -> impl Iterator<Item = FederateId> {
        let inbound: &[Inbound<'s>] = if N::PEERS_IN { self.inbound } else { &[] };
        inbound.iter().filter_map(|inbound| inbound.from)
    }

    /// Returns whether another federate can still send something directly, or may come and do so.
    pub(super) fn can_receive(&self) -> bool {
        let may_come = || self.federation.peers_in.iter().any(|federate| self.may_be_absent(*federate));
        N::PEERS_IN && (self.senders().next().is_some() || N::TRANSIENTS && may_come())
    }

    /// Returns whether a message for an earlier tag than this is incomplete. See [`Inbound::awaits_rest_before`].
    pub(super) fn awaits_rest_before(&mut self, tag: Tag) -> bool {
        self.inbound().iter_mut().any(|inbound| inbound.awaits_rest_before(tag))
    }

    /// Returns the federate that has accepted nothing for longest though this one waits for that, and since when.
    pub(super) fn blocked(&self) -> Option<(u16, Instant)> {
        let blocked = self.receivers().filter_map(|(federate, outbound)| Some((federate, outbound.blocked_since?)));
        blocked.min_by_key(|(_, since)| *since)
    }

    /// Sets what to wait for; messages only while the program can handle them.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P, running: bool) {
        if N::PEERS_IN {
            self.accept_queue.set_interest(platform);
        }
        for inbound in self.inbound() {
            inbound.receiver.connection.set_interest(platform, running);
        }
        for outbound in self.outbound() {
            outbound.set_interest(platform);
        }
    }

    /// Handles that a wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        if N::PEERS_IN {
            self.accept_queue.handle_ready(ready);
        }
        for inbound in self.inbound() {
            inbound.receiver.connection.handle_ready(ready, interest);
        }
        for outbound in self.outbound_mut() {
            outbound.handle_ready(ready, interest);
        }
    }

    /// Detects which federates have left, as far as a wait has reported it.
    pub(super) fn detect_ends<P: Platform>(&mut self, platform: &mut P) {
        for outbound in self.outbound_mut() {
            outbound.detect_end(platform);
        }
    }

    /// Returns when there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&mut self, running: bool) -> Deadline {
        if running && (self.stale || self.inbound().iter_mut().any(Inbound::is_due)) {
            return Deadline::Now;
        }
        let answers = self.outbound().iter().map(Outbound::poll_timeout).min().unwrap_or(Deadline::Never);
        if N::PEERS_IN { answers.min(self.accept_queue.poll_timeout()) } else { answers }
    }

    /// Returns when to look for a transient federate that has come.
    #[cfg(feature = "transients")]
    pub(super) fn poll_search(&self) -> Deadline {
        self.outbound().iter().map(Outbound::poll_search).min().unwrap_or(Deadline::Never)
    }

    /// Closes all connections.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        self.close_accept_queue(platform);
        for outbound in self.outbound_mut() {
            outbound.end(platform);
        }
        for inbound in self.inbound() {
            inbound.close(platform);
        }
    }

    fn close_accept_queue<P: Platform>(&mut self, platform: &mut P) {
        if N::PEERS_IN {
            self.accept_queue.close(platform);
        }
    }
}
