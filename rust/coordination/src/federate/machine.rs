// SPDX-License-Identifier: Apache-2.0
//! A federate as a whole: receives the calls of its event loop and passes them to the parts.
//!
//! Each part has a state of its own and knows none of the others; a part that needs another one receives it as an
//! argument. Decisions that depend on several parts (whether a tag may begin, which message is next) are made here.

use lf_derive::outlined;
use lf_model::time::{Instant, Tag};
use lf_wire::Message;

use super::clock_sync::{Clock, Received};
use super::config::{Config, Coordination};
use super::departure::Departure;
use super::error::{ConfigError, FederateError};
use super::event::{Disconnected, Event};
use super::flow_control::FlowControl;
use super::needs::{All, Needs};
use super::phase::Phase;
use super::physical::PhysicalActions;
use super::session::Session;
use super::stop::Stop;
use super::tags::{Arrival, Tags};
#[cfg(feature = "transients")]
use super::transient_state::Transients;
use crate::auth::Nonce;
use crate::tag::{from_wire, to_wire};
use crate::{Deadline, Endpoint, FederateId, IpAddress, flow};

/// One federate; see the module's description for how to drive it.
#[derive(Clone, Debug)]
pub struct Federate<'a, N: Needs = All> {
    pub(super) config: Config<'a, N>,
    pub(super) session: Session,
    pub(super) clock: Clock,
    pub(super) tags: Tags<N>,
    physical: PhysicalActions,
    flow_control: FlowControl,
    pub(super) departure: Departure,
    #[cfg(feature = "transients")]
    pub(super) transients: Transients,
    pub(super) stop: Stop,
}

impl<'a, N: Needs> Federate<'a, N> {
    /// Returns a federate that has not connected.
    ///
    /// # Errors
    /// When no federate can work with this configuration.
    pub fn new(config: Config<'a, N>) -> Result<Self, ConfigError> {
        config.check()?;
        // Without grants, the RTI receives no tags.
        let is_centralized = config.coordination() == Coordination::Centralized;
        let has_upstream = is_centralized && !config.upstream.is_empty();
        let has_downstream = is_centralized && !config.downstream.is_empty();
        let physical_delay = config.physical_delay.filter(|_| has_downstream);
        Ok(Self {
            session: Session::new(),
            clock: Clock::new(config.test_offset),
            tags: Tags::new(has_upstream, has_downstream),
            physical: PhysicalActions::new(physical_delay, config.advance_interval),
            flow_control: FlowControl::new(config.window() > 0),
            departure: Departure::default(),
            #[cfg(feature = "transients")]
            transients: Transients::new(),
            stop: Stop::new(),
            config,
        })
    }

    /// Returns the phase that this federate is in.
    pub fn phase(&self) -> Phase {
        self.session.phase()
    }

    /// Returns whether the federation allows this tag to begin now.
    ///
    /// Physical time does not matter here. A federate that has sent much must also wait until the RTI has taken it.
    pub fn may_advance(&self, tag: Tag) -> bool {
        let paced = !N::CENTRALIZED || self.flow_control.allows();
        self.phase() == Phase::Running && self.tags.allows(tag) && self.stop.allows(tag) && paced
    }

    /// Handles a new connection to the RTI.
    ///
    /// With [`Config::authentication`], `nonce` has to be unpredictable and new for each connection; otherwise it is
    /// not used. Has no effect when the RTI has accepted this federate before: it cannot come back to the federation.
    pub fn handle_connected(&mut self, now: Instant, nonce: Nonce) {
        self.session.handle_connected(&self.config, now, nonce);
    }

    /// Sets the RTI's address, one of several that were tried.
    pub fn set_rti(&mut self, address: IpAddress) {
        self.config.rti = Some(address);
    }

    /// Handles a message from the RTI.
    ///
    /// `now` is the time at which its last byte was read; clock synchronization is only as exact as this time.
    ///
    /// # Errors
    /// If this federate cannot go on. It has then failed: send FAILED if the connection still allows it.
    pub fn handle_message<'m>(&mut self, now: Instant, message: Message<'m>) -> Result<Event<'m>, FederateError> {
        #[cfg(feature = "transients")]
        if let Some(event) = self.handle_of_transients(&message) {
            return Ok(event);
        }
        let result = match self.phase() {
            Phase::Running => self.handle_running(now, message),
            // The RTI may not know yet that this federate has ended.
            Phase::Resigning | Phase::Ended | Phase::Failed => Ok(Event::None),
            _ => self.session.handle_message(&self.config, &mut self.clock, now, &message),
        };
        if let Ok(Event::Started(start)) = result {
            self.tags.start(start);
        }
        self.fail_on_error(result)
    }

    /// Handles a message after the start.
    #[outlined]
    fn handle_running<'m>(&mut self, now: Instant, message: Message<'m>) -> Result<Event<'m>, FederateError> {
        let is_decentralized = self.config.coordination() == Coordination::Decentralized;
        let unexpected = Err(FederateError::unexpected(&message, self.phase()));
        if !is_decentralized && let Some(window) = flow::answered_in(&message, self.config.id) {
            self.flow_control.answered(window);
            return Ok(Event::None);
        }
        Ok(match message {
            Message::TaggedMessage { .. } | Message::PortAbsent { .. } if !N::INPUTS || is_decentralized => {
                return unexpected;
            }
            Message::ProvisionalTagGrant(_) if !N::CYCLES => return unexpected,
            // A federate that waits for no grants ignores them.
            Message::TagGrant(_) if !N::INPUTS && !N::CYCLES => Event::None,
            Message::TagGrant(_) | Message::ProvisionalTagGrant(_) | Message::DownstreamNextEventTag(_)
                if is_decentralized =>
            {
                Event::None
            }
            Message::TaggedMessage { port, federate, tag, payload } => {
                self.check_destination(FederateId(federate))?;
                return self.handle_tagged(port, from_wire(tag), payload);
            }
            Message::PortAbsent { port, federate, tag } => {
                self.check_destination(FederateId(federate))?;
                Event::PortAbsent { port, tag: from_wire(tag) }
            }
            Message::TagGrant(tag) => {
                let tag = from_wire(tag);
                // The stock federate accepts a grant that is not later than the last one, with a warning, so this one
                // accepts it too.
                if self.tags.grant(tag) { Event::Granted(tag) } else { Event::None }
            }
            Message::ProvisionalTagGrant(tag) => {
                let tag = from_wire(tag);
                let stops = self.stop.is_open() || self.stop.granted() == Some(tag);
                self.tags.grant_provisionally(tag, stops);
                Event::GrantedProvisionally(tag)
            }
            Message::UpstreamDisconnected { federate } if N::CYCLES => Event::UpstreamLeft(FederateId(federate)),
            Message::UpstreamDisconnected { .. } => Event::None,
            Message::DownstreamNextEventTag(tag) => {
                self.tags.handle_dnet(from_wire(tag));
                Event::None
            }
            Message::StopRequest(tag) => {
                self.stop.asked(from_wire(tag), self.tags.earliest()).map_or(Event::None, Event::StopRequested)
            }
            Message::StopGranted(tag) => Event::StopGranted(self.stop.decided(from_wire(tag), self.tags.earliest())),
            Message::AddressQueryReply { port, address } => {
                if N::PEERS_IN {
                    self.departure.answered(now, port > 0, address != [0; 4]);
                }
                Event::None
            }
            #[cfg(feature = "ipv6")]
            Message::AddressQueryReplyIpv6 { port, address, .. } => {
                if N::PEERS_IN {
                    self.departure.answered(now, port > 0, address != [0; 16]);
                }
                Event::None
            }
            Message::Failed => return Err(FederateError::RtiFailed),
            _ => return unexpected,
        })
    }

    fn handle_tagged<'m>(&mut self, port: u16, tag: Tag, payload: &'m [u8]) -> Result<Event<'m>, FederateError> {
        if tag == Tag::FOREVER {
            return Err(FederateError::NoTag { port });
        }
        match self.tags.message_received(tag) {
            Arrival::BeforeStart(by) => Err(FederateError::BeforeStart { port, by }),
            Arrival::Late => {
                let (tag, current) = (self.tags.relative(tag), self.tags.relative(self.tags.current()));
                Err(FederateError::LateMessage { port, tag, current })
            }
            Arrival::InTime if tag > self.stop.last_tag() => Ok(Event::MessageAfterStop { port, tag }),
            Arrival::InTime => Ok(Event::Message { port, tag, payload }),
        }
    }

    fn check_destination(&self, federate: FederateId) -> Result<(), FederateError> {
        if federate == self.config.id { Ok(()) } else { Err(FederateError::WrongDestination { federate }) }
    }

    /// Handles a datagram on the port of [`Config::udp_port`](super::Config::udp_port); `now` is the time right after
    /// it was read.
    ///
    /// Never fails: a lost, false or strange datagram costs a round, and the clock goes on at its rate.
    pub fn handle_datagram(&mut self, now: Instant, from: Endpoint, datagram: &[u8]) -> Received {
        match self.phase() {
            Phase::Starting | Phase::Running | Phase::Resigning => {
                self.clock.handle_datagram(&self.config, now, from, datagram)
            }
            _ => Received::default(),
        }
    }

    /// Records that the answer to a datagram is sent at `now`, the time right before.
    pub fn answer_leaves(&mut self, now: Instant) {
        self.clock.answer_leaves(now);
    }

    /// Records that the federate of the last [`Event::PeerFound`] accepts this one's messages.
    pub fn peer_connected(&mut self, now: Instant) {
        #[cfg(feature = "transients")]
        self.transients.end_search();
        self.session.peer_connected(&self.config, &self.clock, now);
    }

    /// Handles that the connection of [`Event::PeerFound`] could not be made, or ended before it was accepted. Before
    /// the start the federate asks for the address again after a while, because it may have changed; but it goes on
    /// without a transient federate.
    ///
    /// # Errors
    /// When the time for it is over.
    pub fn peer_lost(&mut self, now: Instant) -> Result<(), FederateError> {
        #[cfg(feature = "transients")]
        self.transients.end_search();
        let result = self.session.peer_lost(&self.config, &self.clock, now);
        self.fail_on_error(result)
    }

    /// Returns whether a federate whose direct connection has ended without a word has left in order, as far as the RTI
    /// can tell. If the answer is not known, asks the RTI: call this function again whenever a message of the RTI has
    /// been handled.
    ///
    /// After its own last tag a federate has nothing to lose, and does not ask. A transient federate may leave in any
    /// way.
    pub fn has_left(&mut self, federate: FederateId) -> bool {
        let asks = N::PEERS_IN && self.phase() == Phase::Running && !self.config.may_be_absent(federate);
        !asks || self.departure.has_left(federate)
    }

    /// Handles the end or the break of the connection to the RTI.
    ///
    /// # Errors
    /// When this federate still needed it.
    pub fn handle_disconnected(&mut self) -> Result<Disconnected, FederateError> {
        let result = self.session.handle_disconnected();
        self.fail_on_error(result)
    }

    /// Handles that the time of [`Federate::poll_timeout`] has come. Does nothing at any other time.
    ///
    /// # Errors
    /// When the RTI has let this federate wait too long.
    pub fn handle_timeout(&mut self, now: Instant) -> Result<Event<'static>, FederateError> {
        if N::CENTRALIZED {
            if self.tags.is_renewal_due(now) {
                self.announce(now);
            }
            self.tags.handle_timeout(now);
        }
        if N::PEERS_IN {
            self.departure.handle_timeout(now);
        }
        let result = self.session.handle_timeout(&self.config, &mut self.clock, now);
        self.fail_on_error(result)
    }

    /// Returns the next message for the RTI that is due and no longer than `room` bytes; `None` if there is none, or no
    /// room.
    ///
    /// Without an event or command in between, at most twenty calls return a message.
    pub fn poll_transmit(&mut self, room: usize) -> Option<Message<'a>> {
        let message = self.next_transmit().filter(|message| message.encoded_len() <= room)?;
        match message {
            Message::LatestTagComplete(_) => self.tags.ltc_transmitted(),
            Message::NextEventTag(_) => self.tags.net_transmitted(),
            Message::StopRequest(_) | Message::StopReply(_) => self.stop.transmitted(),
            Message::PortAbsent { .. } => self.flow_control.asked(),
            Message::AddressAdvertisement { .. } | Message::AddressQuery { .. }
                if N::PEERS_IN && self.asks().is_some() =>
            {
                self.departure.transmitted(&message);
            }
            #[cfg(feature = "transients")]
            Message::AddressQuery { .. } if self.searches().is_some() => self.transients.transmitted(),
            Message::T3 { .. } if N::CLOCK_SYNC => {
                self.clock.initial.t3_leaves();
                self.session.transmitted(&message);
            }
            _ => self.session.transmitted(&message),
        }
        Some(message)
    }

    /// Returns whether [`Federate::poll_transmit`] has a message, given room.
    pub fn has_transmit(&self) -> bool {
        self.next_transmit().is_some()
    }

    fn next_transmit(&self) -> Option<Message<'a>> {
        let phase = self.phase();
        let early = self.session.due(&self.config);
        if early.is_some() || phase == Phase::Failed {
            // A federate that has failed has nothing to promise.
            return early;
        }
        if let Some(stop) = self.stop.due() {
            return Some(stop);
        }
        if N::CENTRALIZED {
            if let Some(tag) = self.tags.ltc() {
                return Some(Message::LatestTagComplete(to_wire(tag)));
            }
            if let Some(tag) = self.tags.net() {
                return Some(Message::NextEventTag(to_wire(tag)));
            }
        }
        match phase {
            Phase::Resigning => Some(Message::Resign),
            Phase::Running if N::PEERS_IN && self.asks().is_some() => self.asks(),
            #[cfg(feature = "transients")]
            Phase::Running if self.searches().is_some() => self.searches(),
            // The question comes last, so that it follows everything that the federate has to send.
            Phase::Running if N::CENTRALIZED && self.flow_control.is_question_due() => {
                Some(flow::question(self.config.id, self.config.window()))
            }
            _ => None,
        }
    }

    /// Returns the question for the RTI about a federate that may have left. An answer does not name its question, so
    /// only one question is open at a time.
    fn asks(&self) -> Option<Message<'static>> {
        let waits = self.phase() != Phase::Running || self.flow_control.is_asked();
        #[cfg(feature = "transients")]
        let waits = waits || self.transients.is_asked();
        self.departure.due(self.config.id).filter(|_| !waits)
    }

    /// Returns the question for the RTI about a transient federate that has come, unless another question is open.
    #[cfg(feature = "transients")]
    fn searches(&self) -> Option<Message<'static>> {
        let waits = self.phase() != Phase::Running || N::PEERS_IN && self.departure.is_asked();
        self.transients.due().filter(|_| N::PEERS_OUT && N::TRANSIENTS && !waits)
    }

    /// Records that everything from [`Federate::poll_transmit`] has been written to the socket; `now` is the time after
    /// that.
    pub fn handle_written(&mut self, now: Instant) {
        if N::CLOCK_SYNC {
            self.clock.initial.written(now);
        }
    }

    /// Returns the time at which to call [`Federate::handle_timeout`], by this participant's own clock.
    pub fn poll_timeout(&self) -> Deadline {
        let tags = if N::CENTRALIZED { self.tags.poll_timeout() } else { Deadline::Never };
        let departure = if N::PEERS_IN { self.departure.poll_timeout() } else { Deadline::Never };
        self.session.poll_timeout().min(tags).min(departure)
    }

    /// Announces the next tag at which this federate has something to do, `FOREVER` for none; returns whether it may
    /// begin.
    ///
    /// Call it whenever the next tag has changed, also for an earlier one, and after each [`Event::Granted`] and
    /// [`Event::StopGranted`]; more calls do no harm. A tag after the last one of this federate counts as the last one.
    /// While a tag is open nothing is announced, because it can still send. `now` is this participant's own clock.
    pub fn next_event(&mut self, now: Instant, tag: Tag) -> bool {
        let tag = tag.min(self.stop.last_tag());
        if self.phase() != Phase::Running || !self.tags.next_event(tag) {
            return false;
        }
        self.announce(now);
        self.may_advance(tag)
    }

    fn announce(&mut self, now: Instant) {
        let (physical, clock) = (&self.physical, self.clock.correction());
        let renewal = |tag: Tag| physical.renewal(clock, now, tag.time);
        let earliest = if N::PHYSICAL { physical.earliest_output(clock, now) } else { None };
        self.tags.announce(now, earliest, renewal);
    }

    /// Begins this tag.
    ///
    /// # Errors
    /// When the tag is not later than the last, or has not been granted. This federate has then failed, because its
    /// behavior at such a tag could be wrong.
    pub fn begin(&mut self, tag: Tag) -> Result<(), FederateError> {
        let (relative, current) = (|tag| self.tags.relative(tag), self.tags.current());
        let result = if tag <= current {
            Err(FederateError::NotLater { tag: relative(tag), current: relative(current) })
        } else if self.may_advance(tag) {
            self.tags.begin(tag);
            Ok(())
        } else {
            Err(FederateError::NotGranted { tag: relative(tag) })
        };
        self.fail_on_error(result)
    }

    /// Completes the tag that was begun last; all its messages are in the out-buffer. `had_network_input`: whether a
    /// value from another federate was present.
    ///
    /// The RTI receives an LTC if one was, because it tracks the messages in transit; and after a PTAG, because others
    /// may have to wait within the tag.
    pub fn complete(&mut self, had_network_input: bool) {
        if self.phase() == Phase::Running {
            if N::CENTRALIZED {
                self.flow_control.completed();
            }
            self.tags
                .complete(N::INPUTS && had_network_input && self.config.coordination() == Coordination::Centralized);
        }
    }

    /// Records that a tagged message has been put into the out-buffer.
    pub fn sent(&mut self) {
        self.tags.message_sent();
        self.flow_control.message_sent();
    }

    /// Sets whether anything outside of the program can cause physical actions. Until the first call the answer is yes.
    ///
    /// If nothing can, physical time does not bound the next event: a physical action that a reaction causes comes
    /// after that reaction's tag, which the RTI knows.
    pub fn set_physical_sources(&mut self, any: bool) {
        self.physical.set_sources(any);
    }

    /// Sets this federate's last tag by the program's time-out, without asking the RTI.
    pub fn limit_stop(&mut self, tag: Tag) {
        self.stop.limit(tag);
    }

    /// Asks the RTI to stop the federation at `tag`, or one microstep after the tag begun last if that is later.
    ///
    /// Until [`Event::StopGranted`], `tag` and later ones have to wait. Has no effect if this federate has asked, or
    /// been asked, before.
    pub fn request_stop(&mut self, tag: Tag) {
        if self.phase() == Phase::Running {
            self.stop.request(tag.max(self.tags.earliest()));
        }
    }

    /// Resigns after the last tag is complete. Before the start this is [`Federate::fail`], because the others wait for
    /// this federate unless it is transient. Has no effect once it has ended.
    pub fn finish(&mut self) {
        match self.phase() {
            Phase::Running => {
                if N::CENTRALIZED {
                    #[cfg(feature = "transients")]
                    if self.config.is_transient() && !self.misses(self.tags.current()) {
                        // The next incarnation begins after this tag.
                        self.tags.confirm_last();
                    }
                    self.tags.finish();
                }
                self.session.resign();
            }
            Phase::Resigning | Phase::Ended | Phase::Failed => {}
            phase if phase >= Phase::Synchronizing && self.config.is_transient() => self.session.resign(),
            _ => self.fail(),
        }
    }

    /// Ends this federate because of an error of its own: FAILED is sent instead of RESIGN.
    ///
    /// Has no effect once it has ended.
    pub fn fail(&mut self) {
        if !matches!(self.phase(), Phase::Ended | Phase::Failed) {
            self.end(None);
        }
    }

    /// Returns the result unchanged. After an error this federate has failed.
    fn fail_on_error<T>(&mut self, result: Result<T, FederateError>) -> Result<T, FederateError> {
        if let Err(error) = &result {
            self.end(Some(*error));
        }
        result
    }

    fn end(&mut self, error: Option<FederateError>) {
        self.session.fail(error);
        self.tags.halt();
    }
}
