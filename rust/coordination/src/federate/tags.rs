// SPDX-License-Identifier: Apache-2.0
//! The state of tags of a federate: what was granted, provisionally granted and taken back; what was begun, completed
//! and told; and when what was told, or left out, is to be told again.
//!
//! It knows nothing of connections, messages, clocks or stops: it is told of tags, and says which of them may be begun
//! and which LTC and NET are due. Which NETs the RTI needs at all is the business of [`NetRules`].

use lf_model::time::{EventTag, Instant, Interval, Tag};

use super::needs::Needs;
use super::net_rules::NetRules;
use crate::Deadline;

/// How long a federate leaves out next event tags that it has not been asked for.
const SILENCE: Interval = Interval::from_millis(10);

/// What the tag of a message that has come means.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Arrival {
    /// The tag is to come, or is open and not all was known of its inputs.
    InTime,
    /// The tag is so long before the start.
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
    /// The tag from which on grants have been taken back, until it is confirmed that all before it is complete.
    taken_back: Option<Tag>,
    /// The RTI is to be told when the open tag is complete, for it has been granted by a PTAG.
    confirm: bool,
    /// The last LTC that was due.
    confirmed: Tag,
    /// The LTC to be transmitted.
    ltc: Option<Tag>,
    /// The last tag begun.
    current: Tag,
    /// Whether it has not been completed.
    open: bool,
    /// The next event, as last told and not begun since.
    next: Option<Tag>,
    /// The last bound of the NET by physical time, told while grants were provisional.
    bound: Option<Tag>,
    /// When the bound of the NET by physical time is to be renewed.
    renewal: Deadline,
    /// When what was left out is to be told, because others may need it after all.
    silence: Deadline,
}

impl<N: Needs> Tags<N> {
    /// Nothing has been granted or begun. Whether there are federates that this one has to hear of, and that have to
    /// hear of it.
    pub(super) const fn new(has_upstream: bool, has_downstream: bool) -> Self {
        Self {
            start: None,
            net: NetRules::new(has_upstream, has_downstream),
            provisional: None,
            demanded: None,
            taken_back: None,
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

    /// Logical time begins.
    pub(super) fn start(&mut self, start: Instant) {
        self.start = Some(start);
    }

    /// When logical time begins; `None` as long as that is not known.
    pub(super) fn start_time(&self) -> Option<Instant> {
        self.start
    }

    /// The last TAG, or what is before a later PTAG.
    pub(super) fn granted(&self) -> Tag {
        self.net.granted()
    }

    /// The last PTAG, if nothing later has been granted.
    pub(super) fn granted_provisionally(&self) -> Option<Tag> {
        self.provisional().filter(|tag| *tag > self.net.granted())
    }

    /// The last PTAG.
    fn provisional(&self) -> Option<Tag> {
        if N::CYCLES { self.provisional } else { None }
    }

    /// The last tag begun.
    pub(super) fn current(&self) -> Tag {
        self.current
    }

    /// The tag to which a PTAG calls, unless it has been begun.
    pub(super) fn demanded_tag(&self) -> Option<Tag> {
        if N::CYCLES { self.demanded.filter(|tag| *tag > self.current) } else { None }
    }

    /// Whether it is known of all inputs what comes at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.net.allows(self.current)
    }

    /// Whether this tag may be begun, as far as grants are concerned.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        tag > self.current && (self.net.allows(tag) || self.provisional() == Some(tag))
    }

    /// The earliest tag at which this federate can still do something new: the start, as long as nothing has been
    /// begun.
    pub(super) fn earliest(&self) -> Tag {
        match self.start {
            _ if self.current != Tag::NEVER => self.current.next_microstep(),
            start => start.map_or(Tag::NEVER, Tag::at),
        }
    }

    /// A tag as people read it. Only tags after the start are of interest.
    pub(super) fn relative(&self, tag: Tag) -> EventTag {
        EventTag::relative(tag, self.start.unwrap_or_default())
    }

    /// A TAG. Returns whether it is later than the last.
    pub(super) fn grant(&mut self, tag: Tag) -> bool {
        self.net.grant(tag)
    }

    /// A PTAG: nothing can come any more before this tag, but at it something may, from federates that are in a cycle
    /// without delay with this one, and that may be waiting for it likewise.
    ///
    /// `stops` says that it is the tag of a stop, or that one is being agreed upon. The stop tag may have been granted
    /// before it was one. Then this takes that back (see module `rti::stop`).
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn grant_provisionally(&mut self, tag: Tag, stops: bool) {
        if stops && tag > self.current && tag <= self.net.granted() {
            self.net.take_back(tag);
            self.provisional = self.provisional.filter(|provisional| *provisional < tag);
            self.demanded = self.demanded.filter(|demanded| *demanded < tag);
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
                self.demanded = Some(tag);
            }
        } else if tag == self.current && self.open {
            self.confirm = true;
        } else {
            // It has crossed with what was sent at this tag, or nothing was.
            self.confirm_tag(tag);
        }
    }

    /// A DNET.
    pub(super) fn handle_dnet(&mut self, tag: Tag) {
        self.net.handle_dnet(tag);
    }

    /// A message for this federate has come.
    pub(super) fn message_received(&mut self, tag: Tag) -> Arrival {
        self.net.message_received(tag);
        let start = self.start.unwrap_or(Instant::NEVER);
        // A message for the open tag may be in time, which depends on what has run, unless it was known of all inputs
        // what comes.
        let over = tag < self.current || tag == self.current && (!self.open || self.knows_all_inputs());
        match over {
            _ if tag < Tag::at(start) => Arrival::BeforeStart(start.since(tag.time)),
            true => Arrival::Late,
            false => Arrival::InTime,
        }
    }

    /// A message of the open tag goes out.
    pub(super) fn message_sent(&mut self) {
        self.net.message_sent();
    }

    /// The next event is at `tag`: to be followed by [`Tags::announce`]. Returns false, and does nothing, while a tag
    /// is open, which can still make another next event, and if the tag has been begun.
    pub(super) fn next_event(&mut self, tag: Tag) -> bool {
        let takes = !self.open && tag > self.current;
        if takes {
            self.next = Some(tag);
        }
        takes
    }

    /// Works out the NET, if the rules say that it is to be told.
    ///
    /// `physical` is the earliest physical time of an output that a physical action can cause, if one can; then
    /// `renewal` says when to look at it again, as long as the next event is at the tag that it is given.
    pub(super) fn announce(&mut self, now: Instant, physical: Option<Instant>, renewal: impl FnOnce(Tag) -> Instant) {
        let Some(tag) = self.next else {
            // A tag is open, and after it the next event is told anyway.
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
                if N::CYCLES && self.taken_back == Some(tag) {
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
                self.renewal = Deadline::At(renewal(tag));
                self.net.bounded(bound);
                self.bound = self.net.due().filter(|due| *due == bound && self.provisional().is_some());
            }
        }
    }

    /// Whether nothing is to be told of a next event at `tag`, because the federates of a cycle without delay may be
    /// called to an earlier tag: one to which a PTAG calls this federate, or a bound that has been told and not been
    /// granted. The next event is told when that is over.
    ///
    /// If it was told before, the RTI would take this federate for one that is beyond the earlier tag, and could call
    /// the others to a later one before they have got what this one sends at the earlier one. The stock federate takes
    /// such old word of an absent input for word of the later tag. It does not tell such bounds itself, but has an
    /// event there. Nobody waits longer because of this: the event at `tag` cannot be granted before the earlier tag.
    fn owes_tag_before(&self, tag: Tag) -> bool {
        let bound = self.bound.filter(|bound| self.net.is_last(*bound) && !self.net.allows(*bound));
        N::CYCLES && self.demanded_tag().or(bound).is_some_and(|owed| owed < tag)
    }

    /// The tag before which no physical action can cause an output, if that is earlier than the next event.
    ///
    /// The bound is one ns earlier than the earliest time, as the stock federate has it, but not before a tag that is
    /// over.
    fn physical_bound(&self, earliest: Instant, tag: Tag) -> Option<Tag> {
        if earliest >= tag.time {
            return None;
        }
        let bound = Tag::at(earliest + Interval::from_nanos(-1)).max(self.earliest());
        (bound < tag).then_some(bound)
    }

    /// A tag that [`Tags::allows`] is begun.
    pub(super) fn begin(&mut self, tag: Tag) {
        self.current = tag;
        self.open = true;
        self.confirm = self.provisional() == Some(tag);
        if !N::CYCLES || self.demanded != Some(tag) || self.next == Some(tag) {
            // What is next is told at once. But who is only called to a tag waits for its time to tell again, for a
            // bound that is told calls the whole cycle to its tag.
            self.renewal = Deadline::Never;
        }
        self.demanded = self.demanded_tag();
        self.bound = self.bound.filter(|bound| *bound > tag);
        self.net.begun(tag);
        self.next = None;
    }

    /// The open tag is complete. The RTI is told (LTC) if `had_input` says that a message was present, for it keeps
    /// account of those that are under way; and after a PTAG, for others may have to wait within the tag.
    pub(super) fn complete(&mut self, had_input: bool) {
        if core::mem::take(&mut self.open) && (had_input || N::CYCLES && self.confirm) {
            self.net.completed(self.current);
            self.confirm_tag(self.current);
        }
    }

    /// A tag is over, and all its messages are in the out-buffer.
    fn confirm_tag(&mut self, tag: Tag) {
        if tag > self.confirmed {
            self.confirmed = tag;
            self.ltc = Some(tag);
        }
    }

    /// The end: nothing will come from this federate any more.
    pub(super) fn finish(&mut self) {
        self.halt();
        self.next = None;
        self.net.finish();
    }

    /// Nothing is told any more at its time.
    pub(super) fn halt(&mut self) {
        self.renewal = Deadline::Never;
        self.silence = Deadline::Never;
    }

    /// The LTC that is due. It comes before the NET.
    pub(super) fn ltc(&self) -> Option<Tag> {
        self.ltc
    }

    /// The LTC has been transmitted.
    pub(super) fn ltc_transmitted(&mut self) {
        self.ltc = None;
    }

    /// The NET that is due.
    pub(super) fn net(&self) -> Option<Tag> {
        self.net.due()
    }

    /// The NET has been transmitted.
    pub(super) fn net_transmitted(&mut self) {
        self.net.transmitted();
    }

    /// When [`Tags::announce`] or [`Tags::handle_timeout`] is to be called.
    pub(super) fn poll_timeout(&self) -> Deadline {
        self.renewal.min(self.silence)
    }

    /// Whether [`Tags::announce`] is due, because the time for which a bound is good is over.
    pub(super) fn is_renewal_due(&self, now: Instant) -> bool {
        self.renewal.is_due(now)
    }

    /// What was left out for a while is told.
    pub(super) fn handle_timeout(&mut self, now: Instant) {
        if self.silence.is_due(now) {
            self.silence = Deadline::Never;
            self.net.break_silence();
        }
    }
}

#[cfg(test)]
mod tests;
