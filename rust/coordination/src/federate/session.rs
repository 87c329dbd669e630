// SPDX-License-Identifier: Apache-2.0
//! The session of a federate with the RTI. From the connection to the start: authentication, `FED_IDS` and ACK,
//! `NEIGHBOR_STRUCTURE` and `UDP_PORT`, initial clock synchronization, connections to others, start barrier. At the
//! end: RESIGN, or FAILED.

use lf_derive::outlined;
use lf_model::time::Instant;
use lf_wire::{Message, RejectCode};

use super::clock_sync::Clock;
use super::config::{ClockSync, Config, Coordination};
use super::error::FederateError;
use super::event::{Disconnected, Event};
use super::needs::Needs;
use super::outbox::Outbox;
use super::peers::{Address, Meeting};
use super::phase::Phase;
use crate::auth::{Nonce, Proof};
use crate::clock_sync::Estimate;
use crate::{Deadline, FederateId, IpAddress};

/// The state of the session.
#[derive(Clone, Debug)]
pub(super) struct Session {
    phase: Phase,
    outbox: Outbox,
    /// The nonce that the RTI has to authenticate.
    nonce: Nonce,
    meeting: Meeting,
    /// The time at which to give up waiting for the RTI, before the start.
    deadline: Deadline,
}

impl Session {
    pub(super) fn new() -> Self {
        Self {
            phase: Phase::Disconnected,
            outbox: Outbox::default(),
            nonce: Nonce::default(),
            meeting: Meeting::default(),
            deadline: Deadline::Never,
        }
    }

    pub(super) fn phase(&self) -> Phase {
        self.phase
    }

    /// Returns the time at which to call [`Session::handle_timeout`].
    pub(super) fn poll_timeout(&self) -> Deadline {
        self.deadline
    }

    /// Returns the index of the federate to connect to next.
    pub(super) fn next_peer_index(&self, config: &Config<'_, impl Needs>) -> Option<usize> {
        self.meeting.next_index(config.peers())
    }

    /// Begins to run, unless that has to wait for something else. Returns whether it did.
    #[cfg(feature = "transients")]
    pub(super) fn start(&mut self) -> bool {
        let starts = self.phase == Phase::Starting && self.outbox.timestamp.is_none();
        if starts {
            self.phase = Phase::Running;
        }
        starts
    }

    /// Returns the message that is due.
    pub(super) fn due<'a>(&self, config: &Config<'a, impl Needs>) -> Option<Message<'a>> {
        self.outbox.next(config)
    }

    /// Records that this message of [`Session::due`], or RESIGN, has been transmitted.
    pub(super) fn transmitted(&mut self, message: &Message<'_>) {
        self.outbox.remove(message);
        if *message == Message::Resign {
            self.phase = Phase::Ended;
        }
    }

    /// Handles a new connection to the RTI. Has no effect when the RTI has accepted this federate before.
    pub(super) fn handle_connected(&mut self, config: &Config<'_, impl Needs>, now: Instant, nonce: Nonce) {
        if !matches!(self.phase, Phase::Disconnected | Phase::Authenticating | Phase::Introducing) {
            return;
        }
        self.outbox.clear();
        if config.answer().is_some() {
            self.phase = Phase::Authenticating;
            self.nonce = nonce;
            self.outbox.fed_nonce = Some(nonce);
        } else {
            self.phase = Phase::Introducing;
            self.outbox.fed_ids = true;
        }
        self.deadline = Deadline::At(now + config.connect_time_out);
    }

    /// Handles the end or the break of the connection to the RTI.
    pub(super) fn handle_disconnected(&mut self) -> Result<Disconnected, FederateError> {
        match self.phase {
            Phase::Disconnected | Phase::Authenticating | Phase::Introducing => {
                self.disconnected();
                Ok(Disconnected::ConnectAgain)
            }
            Phase::Synchronizing | Phase::Meeting | Phase::Starting | Phase::Running | Phase::Resigning => {
                Err(FederateError::RtiLost { phase: self.phase })
            }
            Phase::Ended | Phase::Failed => {
                self.outbox.clear();
                Ok(Disconnected::Ended)
            }
        }
    }

    /// Returns to the phase before the connection.
    fn disconnected(&mut self) {
        self.phase = Phase::Disconnected;
        self.outbox.clear();
        self.deadline = Deadline::Never;
    }

    /// Handles a message before the start.
    #[outlined]
    pub(super) fn handle_message<'m, N: Needs>(
        &mut self,
        config: &Config<'_, N>,
        clock: &mut Clock,
        now: Instant,
        message: &Message<'m>,
    ) -> Result<Event<'m>, FederateError> {
        match (self.phase, *message) {
            (Phase::Disconnected, _) => Err(FederateError::unexpected(message, self.phase)),
            (_, Message::Failed) => Err(FederateError::RtiFailed),
            (Phase::Meeting, Message::AddressQueryReply { port, address }) if N::PEERS_OUT => {
                Ok(self.handle_address(config, clock, now, port, IpAddress::V4(address.into())))
            }
            #[cfg(feature = "ipv6")]
            (Phase::Meeting, Message::AddressQueryReplyIpv6 { port, address, scope }) if N::PEERS_OUT => {
                let address = config.as_seen_here(address.into(), scope);
                Ok(self.handle_address(config, clock, now, port, address))
            }
            #[cfg(feature = "ipv6")]
            (_, Message::AddressQueryReplyIpv6 { .. }) => Ok(Event::None),
            // Answers without a question of this federate do no harm.
            (_, Message::AddressQueryReply { .. }) => Ok(Event::None),
            // The id may become free soon: the RTI has not noticed the end of its last owner, or a stranger claims it.
            (Phase::Authenticating | Phase::Introducing, Message::Reject(RejectCode::IdInUse)) => {
                self.disconnected();
                Ok(Event::IdInUse)
            }
            // Also after the ACK: the stock RTI rejects messages in an unexpected order with code 4.
            (_, Message::Reject(code)) => Err(FederateError::Rejected(code)),
            (Phase::Authenticating, Message::RtiResponse { nonce, hmac })
                if config.answer().is_some() && self.outbox.fed_nonce.is_none() =>
            {
                self.authenticate(config, nonce, hmac).map(|()| Event::None)
            }
            (Phase::Introducing, Message::Ack) if !self.outbox.fed_ids => {
                self.accepted(config, clock, now);
                Ok(Event::Accepted)
            }
            (Phase::Synchronizing, Message::T1(t1))
                if N::CLOCK_SYNC && clock.initial.begin(Instant::from_nanos(t1), now) =>
            {
                self.outbox.t3 = true;
                self.expect_clock_sync(config, now);
                Ok(Event::None)
            }
            (Phase::Synchronizing, Message::T4(t4)) if N::CLOCK_SYNC => {
                match clock.initial.complete(Instant::from_nanos(t4)) {
                    None => Err(FederateError::unexpected(message, self.phase)),
                    Some(seen) => Ok(self.exchanged(config, clock, now, seen)),
                }
            }
            (Phase::Meeting | Phase::Starting, Message::T1(_)) => Err(match config.clock_sync().trials() {
                0 => FederateError::unexpected(message, self.phase),
                trials => FederateError::TrialsDiffer { trials },
            }),
            (Phase::Starting, Message::Timestamp(start)) if self.outbox.timestamp.is_none() => {
                self.phase = Phase::Running;
                Ok(Event::Started(Instant::from_nanos(start)))
            }
            _ => Err(FederateError::unexpected(message, self.phase)),
        }
    }

    /// Handles that the RTI has kept this federate waiting beyond [`Session::poll_timeout`].
    pub(super) fn handle_timeout<N: Needs>(
        &mut self,
        config: &Config<'_, N>,
        clock: &mut Clock,
        now: Instant,
    ) -> Result<Event<'static>, FederateError> {
        if !self.deadline.is_due(now) {
            return Ok(Event::None);
        }
        match (self.phase, clock.initial.estimate()) {
            (Phase::Authenticating | Phase::Introducing, _) => Err(FederateError::NoAnswer),
            (Phase::Synchronizing, None) if N::CLOCK_SYNC => Err(FederateError::NoClockSync),
            // The RTI makes fewer exchanges than this federate expected; those that there were will do.
            (Phase::Synchronizing, Some(estimate)) if N::CLOCK_SYNC => {
                Ok(self.synchronized(config, clock, now, estimate))
            }
            (Phase::Meeting, _) if N::PEERS_OUT => {
                self.meet(config, clock, now);
                Ok(Event::None)
            }
            _ => {
                self.deadline = Deadline::Never;
                Ok(Event::None)
            }
        }
    }

    /// Handles the RTI's answer to this federate's nonce. The federate answers the RTI's nonce in return, and
    /// introduces itself.
    fn authenticate(
        &mut self,
        config: &Config<'_, impl Needs>,
        nonce: Nonce,
        proof: Proof,
    ) -> Result<(), FederateError> {
        let (key, id) = (config.federation_id, config.id.0);
        let response = config.answer().and_then(|answer| answer(key, id, self.nonce, &proof, nonce));
        self.outbox.fed_response = Some(response.ok_or(FederateError::RtiNotAuthentic)?);
        self.outbox.fed_ids = true;
        self.phase = Phase::Introducing;
        Ok(())
    }

    fn accepted(&mut self, config: &Config<'_, impl Needs>, clock: &Clock, now: Instant) {
        self.outbox.neighbor_structure = true;
        self.outbox.udp_port = true;
        match config.clock_sync() {
            ClockSync::Off => self.be_ready(config, clock, now),
            ClockSync::Init { .. } | ClockSync::On { .. } => {
                self.phase = Phase::Synchronizing;
                self.expect_clock_sync(config, now);
            }
        }
    }

    fn expect_clock_sync(&mut self, config: &Config<'_, impl Needs>, now: Instant) {
        self.deadline = Deadline::At(now + config.clock_sync_time_out);
    }

    /// Handles a complete exchange, the `seen`th.
    fn exchanged(
        &mut self,
        config: &Config<'_, impl Needs>,
        clock: &mut Clock,
        now: Instant,
        seen: u16,
    ) -> Event<'static> {
        match clock.initial.estimate() {
            Some(estimate) if seen >= config.clock_sync().trials() => self.synchronized(config, clock, now, estimate),
            _ => {
                self.expect_clock_sync(config, now);
                Event::None
            }
        }
    }

    fn synchronized(
        &mut self,
        config: &Config<'_, impl Needs>,
        clock: &mut Clock,
        now: Instant,
        estimate: Estimate,
    ) -> Event<'static> {
        clock.set(&estimate);
        self.be_ready(config, clock, now);
        Event::ClockCorrected(estimate)
    }

    /// Sends the RTI this federate's address, connects to others, and then sends the RTI the time, from which it
    /// chooses the start time.
    fn be_ready(&mut self, config: &Config<'_, impl Needs>, clock: &Clock, now: Instant) {
        self.outbox.t3 = false;
        // Without grants, there is nothing to revoke.
        self.outbox.ordered_stop = config.coordination() == Coordination::Centralized;
        self.outbox.advertisement = config.listening;
        self.meet(config, clock, now);
    }

    /// Asks for the next address, or goes on to the start barrier when all connections exist.
    fn meet(&mut self, config: &Config<'_, impl Needs>, clock: &Clock, now: Instant) {
        self.deadline = Deadline::Never;
        let next = self.meeting.ask(config.peers());
        if next.is_some() {
            self.phase = Phase::Meeting;
            self.outbox.address_query = next;
        } else {
            self.phase = Phase::Starting;
            let time = clock.correction().physical(now);
            #[cfg(feature = "transients")]
            let time = time + config.join_delay();
            self.outbox.timestamp = Some(time);
        }
    }

    fn handle_address(
        &mut self,
        config: &Config<'_, impl Needs>,
        clock: &Clock,
        now: Instant,
        port: i32,
        ip: IpAddress,
    ) -> Event<'static> {
        match self.meeting.handle_address(config.peers(), now, port, ip) {
            Address::Unasked => Event::None,
            Address::AskAgain(_) if self.meets_transient(config) => {
                self.meet_next(config, clock, now);
                Event::None
            }
            Address::AskAgain(time) => {
                self.deadline = Deadline::At(time);
                Event::None
            }
            Address::Found(federate, address) => Event::PeerFound { federate, address },
        }
    }

    /// Records that the federate of the last [`Event::PeerFound`] accepts this one's messages.
    pub(super) fn peer_connected(&mut self, config: &Config<'_, impl Needs>, clock: &Clock, now: Instant) {
        if self.phase == Phase::Meeting {
            self.meet_next(config, clock, now);
        }
    }

    /// Goes on to the next federate to which this one sends.
    fn meet_next(&mut self, config: &Config<'_, impl Needs>, clock: &Clock, now: Instant) {
        self.meeting.connected();
        self.meet(config, clock, now);
    }

    /// Returns whether the federate to connect to next may be absent.
    fn meets_transient(&self, config: &Config<'_, impl Needs>) -> bool {
        let next = self.meeting.next_index(config.peers()).and_then(|index| config.peers().get(index));
        next.is_some_and(|federate| config.may_be_absent(FederateId(*federate)))
    }

    /// Handles that the connection of [`Event::PeerFound`] could not be made, or ended before it was accepted.
    pub(super) fn peer_lost(
        &mut self,
        config: &Config<'_, impl Needs>,
        clock: &Clock,
        now: Instant,
    ) -> Result<(), FederateError> {
        if self.phase == Phase::Meeting && self.meets_transient(config) {
            self.meet_next(config, clock, now);
        } else if self.phase == Phase::Meeting {
            let again = self.meeting.lost(config.peers(), now);
            self.deadline = Deadline::At(again.map_err(|federate| FederateError::PeerUnreachable { federate })?);
        }
        Ok(())
    }

    /// Resigns after the last tag.
    pub(super) fn resign(&mut self) {
        self.phase = Phase::Resigning;
    }

    /// Fails because of this error, or of one of the program. Has no effect once the federate has ended: the RTI knows
    /// already that it has done so in order.
    pub(super) fn fail(&mut self, error: Option<FederateError>) {
        if self.phase == Phase::Ended {
            return;
        }
        // An RTI that rejected this federate does not know it, and an RTI that is gone receives nothing.
        let tell = !matches!(error, Some(FederateError::Rejected(_) | FederateError::RtiLost { .. }));
        self.outbox.clear();
        self.outbox.failed = tell && self.phase != Phase::Disconnected;
        if error == Some(FederateError::RtiNotAuthentic) {
            self.outbox.reject = Some(RejectCode::HmacMismatch);
        }
        self.phase = Phase::Failed;
        self.deadline = Deadline::Never;
    }
}
