// SPDX-License-Identifier: Apache-2.0
//! From the start to the end: grants, tags, messages, stop, resign.

use lf_model::time::{EventTag, Instant, Interval, Tag};
use lf_wire::Message;

use super::config::Coordination;
use super::error::FederateError;
use super::event::Event;
use super::machine::Federate;
use super::phase::Phase;
use crate::tag::from_wire;
use crate::{Deadline, FederateId};

/// How long a federate leaves out next event tags that it has not been asked for.
const SILENCE: Interval = Interval::from_millis(10);

impl Federate<'_> {
    /// Tells the next tag at which this federate has something to do, `FOREVER` for none; returns whether it may be
    /// begun.
    ///
    /// Call it whenever the next tag has changed, also for an earlier one, and after each [`Event::Granted`] and
    /// [`Event::StopGranted`]; calling it more often does no harm. A tag after the last one of this federate counts as
    /// the last one. As long as a tag is open nothing is told, for it can still send. `now` is this participant's own
    /// clock.
    pub fn next_event(&mut self, now: Instant, tag: Tag) -> bool {
        if self.phase != Phase::Running || self.open {
            return false;
        }
        let tag = tag.min(self.stop.last_tag());
        if tag <= self.current {
            return false;
        }
        self.next = Some(tag);
        self.announce(now);
        self.may_advance(tag)
    }

    /// The event loop begins this tag.
    ///
    /// # Errors
    /// When the tag is not later than the last, or has not been granted. This federate has then failed, for what it
    /// does at such a tag could be wrong.
    pub fn begin(&mut self, tag: Tag) -> Result<(), FederateError> {
        if tag <= self.current {
            return self
                .refuse(FederateError::NotLater { tag: self.relative(tag), current: self.relative(self.current) });
        }
        if !self.may_advance(tag) {
            return self.refuse(FederateError::NotGranted { tag: self.relative(tag) });
        }
        self.current = tag;
        self.open = true;
        self.confirm = self.provisional == Some(tag);
        if self.summons != Some(tag) || self.next == Some(tag) {
            // What is next is told at once. But who is only called to a tag waits for its time to tell again, for a
            // bound that is told calls the whole cycle to its tag.
            self.renewal = Deadline::Never;
        }
        self.summons = self.summons.filter(|summons| *summons > tag);
        self.net.begun(tag);
        self.next = None;
        Ok(())
    }

    /// The tag begun last is complete, and all its messages are in the out-buffer. `had_network_input`: whether a value
    /// from another federate was present.
    ///
    /// The RTI is told (LTC) if that is so, for it keeps account of the messages that are under way; and after a PTAG,
    /// for others may have to wait within the tag.
    pub fn complete(&mut self, had_network_input: bool) {
        let was_open = core::mem::take(&mut self.open);
        self.pace.completed();
        let is_told = self.config.coordination == Coordination::Centralized && (had_network_input || self.confirm);
        if self.phase == Phase::Running && was_open && is_told {
            self.net.completed(self.current);
            self.confirm_tag(self.current);
        }
    }

    /// A tag is over, and all its messages are in the out-buffer.
    fn confirm_tag(&mut self, tag: Tag) {
        if tag > self.confirmed {
            self.confirmed = tag;
            self.outbox.ltc = Some(tag);
        }
    }

    /// A tagged message has been put into the out-buffer.
    pub fn sent(&mut self) {
        self.net.message_sent();
        self.pace.message_sent();
    }

    /// Whether anything outside of the program can cause physical actions; it can before this is said.
    ///
    /// Where nothing can, physical time does not bound the next event: a physical action that a reaction causes comes
    /// after that reaction's tag, which the RTI knows of.
    pub fn set_physical_sources(&mut self, any: bool) {
        self.has_physical_sources = any;
    }

    /// This federate's last tag by the program's time-out; the RTI is not asked.
    pub fn limit_stop(&mut self, tag: Tag) {
        self.stop.limit(tag);
    }

    /// The program wants to stop: asks for it at `tag`, or one microstep after the tag begun last where that is later.
    ///
    /// Until [`Event::StopGranted`], `tag` and later ones have to wait. Without effect when this federate has asked, or
    /// been asked, before.
    pub fn request_stop(&mut self, tag: Tag) {
        if self.phase != Phase::Running {
            return;
        }
        let earliest = tag.max(self.earliest_stop());
        if self.stop.request(earliest) {
            self.outbox.stop_request = Some(earliest);
        }
    }

    /// The last tag is complete: resigns. Before the start this is [`Federate::fail`], for the others wait for this
    /// federate; without effect once it has ended.
    pub fn finish(&mut self) {
        match self.phase {
            Phase::Running => {
                self.next = None;
                self.renewal = Deadline::Never;
                self.silence = Deadline::Never;
                self.net.finish();
                self.outbox.resign = true;
                self.phase = Phase::Resigning;
            }
            Phase::Disconnected
            | Phase::Authenticating
            | Phase::Introducing
            | Phase::Synchronizing
            | Phase::Meeting
            | Phase::Starting => self.fail(),
            Phase::Resigning | Phase::Ended | Phase::Failed => {}
        }
    }

    /// A message after the start.
    pub(super) fn handle_running<'m>(&mut self, message: Message<'m>) -> Result<Event<'m>, FederateError> {
        let is_decentralized = self.config.coordination == Coordination::Decentralized;
        match message {
            Message::TaggedMessage { .. } | Message::PortAbsent { .. } if is_decentralized => {
                Err(self.unexpected(&message))
            }
            // A grant says nothing to a federate that does not wait for any.
            Message::TagGrant(_) | Message::ProvisionalTagGrant(_) | Message::DownstreamNextEventTag(_)
                if is_decentralized =>
            {
                Ok(Event::None)
            }
            Message::TaggedMessage { port, federate, tag, payload } => {
                self.handle_tagged(port, FederateId(federate), from_wire(tag), payload)
            }
            Message::TagGrant(tag) => {
                let tag = from_wire(tag);
                // The stock federate takes a grant that says nothing new with a warning, so this one does likewise.
                Ok(if self.net.grant(tag) { Event::Granted(tag) } else { Event::None })
            }
            Message::ProvisionalTagGrant(tag) => {
                let tag = from_wire(tag);
                self.handle_provisional_grant(tag);
                Ok(Event::GrantedProvisionally(tag))
            }
            Message::DownstreamNextEventTag(tag) => {
                self.net.handle_dnet(from_wire(tag));
                Ok(Event::None)
            }
            Message::StopRequest(tag) => Ok(match self.stop.asked(from_wire(tag), self.earliest_stop()) {
                Some(reply) => {
                    self.outbox.stop_reply = Some(reply);
                    Event::StopRequested(reply)
                }
                None => Event::None,
            }),
            Message::StopGranted(tag) => {
                let earliest = self.earliest_stop();
                Ok(Event::StopGranted(self.stop.decided(from_wire(tag), earliest)))
            }
            Message::PortAbsent { port, federate, tag } => {
                self.check_destination(FederateId(federate))?;
                Ok(Event::PortAbsent { port, tag: from_wire(tag) })
            }
            Message::AddressQueryReply { .. } => {
                self.pace.answered();
                Ok(Event::None)
            }
            Message::Failed => Err(FederateError::RtiFailed),
            _ => Err(self.unexpected(&message)),
        }
    }

    /// Tells the RTI the next event, if the rules say so.
    pub(super) fn announce(&mut self, now: Instant) {
        let Some(tag) = self.next else {
            // A tag is open, and after it the next event is told anyway.
            self.renewal = Deadline::Never;
            return;
        };
        match self.physical_bound(now, tag) {
            None => {
                self.renewal = Deadline::Never;
                if self.taken_back == Some(tag) {
                    // The RTI may remember what this federate would have confirmed at later tags.
                    self.taken_back = None;
                    self.confirm_tag(tag.before());
                }
                self.net.next_event(tag);
                if !self.net.is_silent() {
                    self.silence = Deadline::Never;
                } else if self.silence == Deadline::Never {
                    self.silence = Deadline::At(now + SILENCE);
                }
            }
            // Told a short while ago, and not renewed yet, so as not to flood the RTI.
            Some(_) if matches!(self.renewal, Deadline::At(_)) && !self.renewal.is_due(now) => {}
            Some(bound) => {
                self.renewal = Deadline::At(self.renewal_time(now, tag));
                self.net.bounded(bound);
            }
        }
    }

    /// A PTAG: nothing can come any more before this tag, but at it something may, from federates that are in a cycle
    /// without delay with this one, and that may be waiting for it likewise.
    ///
    /// The stop tag may have been granted before it was one. Then this takes that back (see module `rti::stop`).
    fn handle_provisional_grant(&mut self, tag: Tag) {
        let is_stop_tag = self.stop.is_open() || self.stop.granted() == Some(tag);
        if is_stop_tag && tag > self.current && tag <= self.net.granted() {
            self.net.take_back(tag);
            self.provisional = self.provisional.filter(|provisional| *provisional < tag);
            self.summons = self.summons.filter(|summons| *summons < tag);
            self.taken_back = Some(tag);
            return;
        }
        self.net.grant(tag.before());
        if tag != Tag::FOREVER {
            self.provisional = self.provisional.max(Some(tag));
        }
        if tag > self.current {
            // A federate that waits within an earlier tag learns what it waits for from what comes at the later one.
            // A PTAG of for ever calls to no tag, and one that comes after a later one does not any more.
            if self.provisional == Some(tag) {
                self.summons = Some(tag);
            }
        } else if tag == self.current && self.open {
            self.confirm = true;
        } else {
            // It has crossed with what was sent at this tag, or nothing was.
            self.confirm_tag(tag);
        }
    }

    fn handle_tagged<'m>(
        &mut self,
        port: u16,
        federate: FederateId,
        tag: Tag,
        payload: &'m [u8],
    ) -> Result<Event<'m>, FederateError> {
        self.check_destination(federate)?;
        self.net.message_received(tag);
        let start = self.start.map_or(Tag::NEVER, Tag::at);
        // A message for the open tag may be in time, which depends on what has run, unless it was known of all inputs
        // what comes.
        let over = tag < self.current || tag == self.current && (!self.open || self.knows_all_inputs());
        if tag < start {
            return Err(FederateError::BeforeStart { port, by: start.time.since(tag.time) });
        }
        if over {
            let (tag, current) = (self.relative(tag), self.relative(self.current));
            return Err(FederateError::LateMessage { port, tag, current });
        }
        if tag > self.stop.last_tag() {
            return Ok(Event::MessageAfterStop { port, tag });
        }
        Ok(Event::Message { port, tag, payload })
    }

    fn check_destination(&self, federate: FederateId) -> Result<(), FederateError> {
        if federate == self.config.id { Ok(()) } else { Err(FederateError::WrongDestination { federate }) }
    }

    /// A tag as people read it. Only tags after the start are of interest.
    fn relative(&self, tag: Tag) -> EventTag {
        EventTag::relative(tag, self.start.unwrap_or_default())
    }

    /// The earliest tag at which this federate can stop.
    fn earliest_stop(&self) -> Tag {
        if self.current == Tag::NEVER {
            // Nothing has been begun: it can stop at the start.
            return self.start.map_or(Tag::NEVER, Tag::at);
        }
        self.current.next_microstep()
    }

    /// The tag before which no physical action can cause an output, if that is earlier than the next event.
    ///
    /// A physical action that comes now has at least the time now + its delay. The bound is one ns earlier, as the
    /// stock federate has it, but not before a tag that is over.
    fn physical_bound(&self, now: Instant, tag: Tag) -> Option<Tag> {
        let delay = self.config.physical_delay.filter(|_| self.has_physical_sources && self.net.has_downstream())?;
        let earliest = self.clock.physical(now) + delay;
        if earliest >= tag.time {
            return None;
        }
        let bound = Tag::at(earliest + Interval(-1)).max(self.earliest_stop());
        (bound < tag).then_some(bound)
    }

    /// When the bound is to be renewed: after the advance interval, or when physical time no longer bounds the NET.
    fn renewal_time(&self, now: Instant, tag: Tag) -> Instant {
        let renewal = now + self.config.advance_interval;
        match self.config.physical_delay {
            Some(delay) => renewal
                .min(self.clock.local(tag.time + Interval(delay.as_nanos().saturating_neg())).max(now + Interval(1))),
            None => renewal,
        }
    }
}
