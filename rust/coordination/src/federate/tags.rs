// SPDX-License-Identifier: Apache-2.0
//! The state of tags of a federate: granted, provisionally granted and revoked tags; the current and the completed tag;
//! the tags that were announced, and when to announce again what was left out.
//!
//! This part knows neither connections nor messages, clocks or stops: it receives tags, and says which of them may
//! begin and which LTC and NET are due. [`NetRules`] decides which NETs the RTI needs at all.

use lf_derive::outlined;
use lf_model::time::{EventTag, Instant, Interval, Tag};

use super::needs::Needs;
use super::net_rules::NetRules;
use crate::Deadline;

/// The time for which a federate leaves out next event tags that the RTI did not request.
const SILENCE: Interval = Interval::from_millis(10);

/// The meaning of a message's tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Arrival {
    /// The tag is to come, or is open and not all inputs were known there.
    InTime,
    /// The tag is this long before the start.
    BeforeStart(Interval),
    /// The tag is over.
    Late,
}

/// The state of tags of one federate.
#[derive(Clone, Debug)]
pub(super) struct Tags<N> {
    start: Option<Instant>,
    net: NetRules<N>,
    /// The last PTAG.
    provisional: Option<Tag>,
    /// The PTAG that this federate has not followed yet.
    demanded: Option<Tag>,
    /// The tag from which on the RTI has revoked grants, until the federate confirms that everything before it is
    /// complete.
    revoked: Option<Tag>,
    /// Whether the RTI expects an LTC when the open tag is complete, because it was granted by a PTAG.
    confirm: bool,
    /// The last LTC that was due.
    confirmed: Tag,
    /// The LTC to be transmitted.
    ltc: Option<Tag>,
    /// The last tag begun.
    current: Tag,
    /// Whether the current tag has not been completed.
    open: bool,
    /// The next event that was announced last, unless it has begun.
    next: Option<Tag>,
    /// The last bound of the NET by physical time that was announced while grants were provisional.
    bound: Option<Tag>,
    /// The time at which to renew the bound of the NET by physical time.
    renewal: Deadline,
    /// The time at which to announce what was left out, because others may need it after all.
    silence: Deadline,
}

impl<N: Needs> Tags<N> {
    /// Returns a state without grants and tags, of a federate with or without federates upstream and downstream.
    pub(super) const fn new(has_upstream: bool, has_downstream: bool) -> Self {
        Self {
            start: None,
            net: NetRules::new(has_upstream, has_downstream),
            provisional: None,
            demanded: None,
            revoked: None,
            confirm: false,
            confirmed: Tag::NEVER,
            ltc: None,
            current: Tag::NEVER,
            open: false,
            next: None,
            bound: None,
            renewal: Deadline::Never,
            silence: Deadline::Never,
        }
    }

    /// Sets the start of logical time.
    pub(super) fn start(&mut self, start: Instant) {
        self.start = Some(start);
    }

    /// Sets the start of logical time and the first tag of this federate, which joins later.
    #[cfg(feature = "transients")]
    pub(super) fn join(&mut self, start: Instant, first: Tag) {
        self.start = Some(start);
        self.current = first.before();
    }

    /// Returns the start of logical time; `None` while it is not known.
    pub(super) fn start_time(&self) -> Option<Instant> {
        self.start
    }

    /// Returns the last TAG, or the tag before a later PTAG.
    pub(super) fn granted(&self) -> Tag {
        self.net.granted()
    }

    /// Returns the last PTAG, if nothing later has been granted.
    pub(super) fn granted_provisionally(&self) -> Option<Tag> {
        self.provisional().filter(|tag| *tag > self.net.granted())
    }

    /// Returns the last PTAG.
    fn provisional(&self) -> Option<Tag> {
        if N::CYCLES { self.provisional } else { None }
    }

    /// Returns the last tag begun.
    pub(super) fn current(&self) -> Tag {
        self.current
    }

    /// Returns the tag that a PTAG demands, unless it has begun.
    pub(super) fn demanded_tag(&self) -> Option<Tag> {
        if N::CYCLES { self.demanded.filter(|tag| *tag > self.current) } else { None }
    }

    /// Returns whether all inputs are known at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.net.allows(self.current)
    }

    /// Returns whether grants allow this tag to begin.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        tag > self.current && (self.net.allows(tag) || self.provisional() == Some(tag))
    }

    /// Returns the earliest tag at which this federate can still do something new: the start, before the first tag.
    pub(super) fn earliest(&self) -> Tag {
        match self.start {
            _ if self.current != Tag::NEVER => self.current.next_microstep(),
            start => start.map_or(Tag::NEVER, Tag::at),
        }
    }

    /// Converts a tag for people. It has to be after the start.
    pub(super) fn relative(&self, tag: Tag) -> EventTag {
        EventTag::relative(tag, self.start.unwrap_or_default())
    }

    /// Handles a TAG. Returns whether it is later than the last.
    pub(super) fn grant(&mut self, tag: Tag) -> bool {
        self.net.grant(tag)
    }

    /// Handles a PTAG: nothing comes before this tag any more, but messages may come at it, from federates in a cycle
    /// without delay with this one, which may wait for it likewise.
    ///
    /// `stops` says that it is the tag of a stop, or that one is being agreed upon. The stop tag may have been granted
    /// before it was one. Then this PTAG revokes that grant (see module `rti::stop`).
    #[outlined]
    pub(super) fn grant_provisionally(&mut self, tag: Tag, stops: bool) {
        if stops && tag > self.current && tag <= self.net.granted() {
            self.net.revoke(tag);
            self.provisional = self.provisional.filter(|provisional| *provisional < tag);
            self.demanded = self.demanded.filter(|demanded| *demanded < tag);
            self.revoked = Some(tag);
            return;
        }
        self.net.grant(tag.before());
        if tag != Tag::FOREVER {
            self.provisional = self.provisional.max(Some(tag));
        }
        if tag > self.current {
            // A federate that waits within an earlier tag learns what it waits for from messages at the later one. A
            // PTAG of FOREVER demands no tag, and neither does one that comes after a later one.
            if self.provisional == Some(tag) {
                self.demanded = Some(tag);
            }
        } else if tag == self.current && self.open {
            self.confirm = true;
        } else {
            // It has crossed with the messages of this tag, or there were none.
            self.confirm_tag(tag);
        }
    }

    /// Handles a DNET.
    pub(super) fn handle_dnet(&mut self, tag: Tag) {
        self.net.handle_dnet(tag);
    }

    /// Handles a message for this federate.
    pub(super) fn message_received(&mut self, tag: Tag) -> Arrival {
        self.net.message_received(tag);
        let start = self.start.unwrap_or(Instant::NEVER);
        // A message for the open tag may be in time, depending on the reactions that have run, unless all inputs were
        // known.
        let over = tag < self.current || tag == self.current && (!self.open || self.knows_all_inputs());
        match over {
            _ if tag < Tag::at(start) => Arrival::BeforeStart(start.since(tag.time)),
            true => Arrival::Late,
            false => Arrival::InTime,
        }
    }

    /// Records that a message of the open tag goes out.
    pub(super) fn message_sent(&mut self) {
        self.net.message_sent();
    }

    /// Sets the next event; call [`Tags::announce`] then. Returns false, and does nothing, if the tag has begun or
    /// while a tag is open, because that can still change the next event.
    pub(super) fn next_event(&mut self, tag: Tag) -> bool {
        let takes = !self.open && tag > self.current;
        if takes {
            self.next = Some(tag);
        }
        takes
    }

    /// Computes the NET, if the rules require one.
    ///
    /// `physical` is the earliest physical time of an output that a physical action can cause, if one can; then
    /// `renewal` returns when to compute it again, while the next event is at the tag in its argument.
    pub(super) fn announce(&mut self, now: Instant, physical: Option<Instant>, renewal: impl FnOnce(Tag) -> Instant) {
        let Some(tag) = self.next else {
            // A tag is open, and the next event is announced after it anyway.
            self.renewal = Deadline::Never;
            return;
        };
        if self.owes_tag_before(tag) {
            self.renewal = Deadline::Never;
            self.net.withhold(tag);
            return;
        }
        match physical.and_then(|earliest| self.physical_bound(earliest, tag)) {
            None => {
                self.renewal = Deadline::Never;
                if N::CYCLES && self.revoked == Some(tag) {
                    // The RTI may remember what this federate would have confirmed at later tags.
                    self.revoked = None;
                    self.confirm_tag(tag.before());
                }
                self.net.next_event(tag);
                if !self.net.is_silent() {
                    self.silence = Deadline::Never;
                } else if self.silence == Deadline::Never {
                    self.silence = Deadline::At(now + SILENCE);
                }
            }
            // The bound was announced a short while ago and is not due again, so as not to flood the RTI.
            Some(_) if matches!(self.renewal, Deadline::At(_)) && !self.renewal.is_due(now) => {}
            Some(bound) => {
                self.renewal = Deadline::At(renewal(tag));
                self.net.bounded(bound);
                self.bound = self.net.due().filter(|due| *due == bound && self.provisional().is_some());
            }
        }
    }

    /// Returns whether a next event at `tag` must not be announced yet, because a PTAG may demand an earlier tag of the
    /// federates of a cycle without delay: a tag that a PTAG demands of this federate, or a bound that was announced
    /// and not granted. The next event is announced when that is over.
    ///
    /// If it was announced before, the RTI would conclude that this federate is beyond the earlier tag, and could
    /// demand a later tag of the others before they have received this federate's messages of the earlier one. The
    /// stock federate takes such an old absence for an absence at the later tag. It does not announce such bounds
    /// itself, but has an event there. No federate waits longer because of this: the event at `tag` cannot be granted
    /// before the earlier tag.
    ///
    /// The first NET goes out in any case. LF 0.13's RTI takes the start for the next event of a federate that has
    /// announced nothing, so it may demand the start of this federate alone, and what this one waits for there would
    /// never come.
    fn owes_tag_before(&self, tag: Tag) -> bool {
        let bound = self.bound.filter(|bound| self.net.is_last(*bound) && !self.net.allows(*bound));
        N::CYCLES && self.net.any_net() && self.demanded_tag().or(bound).is_some_and(|owed| owed < tag)
    }

    /// Returns the tag before which no physical action can cause an output, if that is earlier than the next event.
    ///
    /// The bound is one ns earlier than the earliest time, as in the stock federate, but not before a tag that is over.
    fn physical_bound(&self, earliest: Instant, tag: Tag) -> Option<Tag> {
        if earliest >= tag.time {
            return None;
        }
        let bound = Tag::at(earliest + Interval::from_nanos(-1)).max(self.earliest());
        (bound < tag).then_some(bound)
    }

    /// Begins a tag that [`Tags::allows`].
    pub(super) fn begin(&mut self, tag: Tag) {
        self.current = tag;
        self.open = true;
        self.confirm = self.provisional() == Some(tag);
        if !N::CYCLES || self.demanded != Some(tag) || self.next == Some(tag) {
            // The next event is announced at once. But a federate of which only a PTAG demands the tag waits until the
            // renewal, because a bound that it announces demands its tag of the whole cycle.
            self.renewal = Deadline::Never;
        }
        self.demanded = self.demanded_tag();
        self.bound = self.bound.filter(|bound| *bound > tag);
        self.net.begun(tag);
        self.next = None;
    }

    /// Completes the open tag. An LTC is due if `had_input` says that a message was present, because the RTI tracks
    /// those in transit; and after a PTAG, because others may have to wait within the tag.
    pub(super) fn complete(&mut self, had_input: bool) {
        if core::mem::take(&mut self.open) && (had_input || N::CYCLES && self.confirm) {
            self.net.completed(self.current);
            self.confirm_tag(self.current);
        }
    }

    /// Makes the LTC of a tag due whose messages are all in the out-buffer.
    fn confirm_tag(&mut self, tag: Tag) {
        if tag > self.confirmed {
            self.confirmed = tag;
            self.ltc = Some(tag);
        }
    }

    /// Returns whether this federate has announced that nothing happens here at this tag, nor at later ones before its
    /// next event.
    #[cfg(feature = "transients")]
    pub(super) fn has_announced_beyond(&self, tag: Tag) -> bool {
        self.net.is_beyond(tag)
    }

    /// Makes the LTC of the last tag due, whether it had inputs or not.
    #[cfg(feature = "transients")]
    pub(super) fn confirm_last(&mut self) {
        self.confirm_tag(self.current);
    }

    /// Announces that nothing will come from this federate any more.
    pub(super) fn finish(&mut self) {
        self.halt();
        self.next = None;
        self.net.finish();
    }

    /// Stops all announcements by time.
    pub(super) fn halt(&mut self) {
        self.renewal = Deadline::Never;
        self.silence = Deadline::Never;
    }

    /// Returns the LTC that is due. It comes before the NET.
    pub(super) fn ltc(&self) -> Option<Tag> {
        self.ltc
    }

    /// Records that the LTC has been transmitted.
    pub(super) fn ltc_transmitted(&mut self) {
        self.ltc = None;
    }

    /// Returns the NET that is due.
    pub(super) fn net(&self) -> Option<Tag> {
        self.net.due()
    }

    /// Records that the NET has been transmitted.
    pub(super) fn net_transmitted(&mut self) {
        self.net.transmitted();
    }

    /// Returns the time at which to call [`Tags::announce`] or [`Tags::handle_timeout`].
    pub(super) fn poll_timeout(&self) -> Deadline {
        self.renewal.min(self.silence)
    }

    /// Returns whether [`Tags::announce`] is due, because the last bound is no longer valid.
    pub(super) fn is_renewal_due(&self, now: Instant) -> bool {
        self.renewal.is_due(now)
    }

    /// Announces what was left out for a while.
    pub(super) fn handle_timeout(&mut self, now: Instant) {
        if self.silence.is_due(now) {
            self.silence = Deadline::Never;
            self.net.break_silence();
        }
    }
}

#[cfg(test)]
mod tests;
