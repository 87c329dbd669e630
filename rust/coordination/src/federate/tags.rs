// SPDX-License-Identifier: Apache-2.0
//! The state of tags of a federate: what was granted, provisionally granted and taken back; what was begun, completed
//! and told; and when what was told, or left out, is to be told again.
//!
//! It knows nothing of connections, messages, clocks or stops: it is told of tags, and says which of them may be begun
//! and which LTC and NET are due. Which NETs the RTI needs at all is the business of [`NetRules`].

use lf_model::time::{EventTag, Instant, Interval, Tag};

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
pub(super) struct Tags {
    start: Option<Instant>,
    net: NetRules,
    /// The last PTAG.
    provisional: Option<Tag>,
    /// The PTAG that this federate has not followed yet.
    summons: Option<Tag>,
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
    /// When the bound of the NET by physical time is to be renewed.
    renewal: Deadline,
    /// When what was left out is to be told, because others may need it after all.
    silence: Deadline,
}

impl Tags {
    /// Nothing has been granted or begun. Whether there are federates that this one has to hear of, and that have to
    /// hear of it.
    pub(super) const fn new(has_upstream: bool, has_downstream: bool) -> Self {
        Self {
            start: None,
            net: NetRules::new(has_upstream, has_downstream),
            provisional: None,
            summons: None,
            taken_back: None,
            confirm: false,
            confirmed: Tag::NEVER,
            ltc: None,
            current: Tag::NEVER,
            open: false,
            next: None,
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
        self.provisional.filter(|tag| *tag > self.net.granted())
    }

    /// The last tag begun.
    pub(super) fn current(&self) -> Tag {
        self.current
    }

    /// The tag to which a PTAG calls, unless it has been begun.
    pub(super) fn summons(&self) -> Option<Tag> {
        self.summons.filter(|tag| *tag > self.current)
    }

    /// Whether it is known of all inputs what comes at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.net.allows(self.current)
    }

    /// Whether this tag may be begun, as far as grants are concerned.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        tag > self.current && (self.net.allows(tag) || self.provisional == Some(tag))
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
    pub(super) fn grant_provisionally(&mut self, tag: Tag, stops: bool) {
        if stops && tag > self.current && tag <= self.net.granted() {
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

    /// The next event is at `tag`: to be followed by [`Tags::announce`]. Returns false, and does nothing, while a tag is
    /// open, which can still make another next event, and if the tag has been begun.
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
        match physical.and_then(|earliest| self.physical_bound(earliest, tag)) {
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
                self.renewal = Deadline::At(renewal(tag));
                self.net.bounded(bound);
            }
        }
    }

    /// The tag before which no physical action can cause an output, if that is earlier than the next event.
    ///
    /// The bound is one ns earlier than the earliest time, as the stock federate has it, but not before a tag that is
    /// over.
    fn physical_bound(&self, earliest: Instant, tag: Tag) -> Option<Tag> {
        if earliest >= tag.time {
            return None;
        }
        let bound = Tag::at(earliest + Interval(-1)).max(self.earliest());
        (bound < tag).then_some(bound)
    }

    /// A tag that [`Tags::allows`] is begun.
    pub(super) fn begin(&mut self, tag: Tag) {
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
    }

    /// The open tag is complete. The RTI is told (LTC) if `had_input` says that a message was present, for it keeps
    /// account of those that are under way; and after a PTAG, for others may have to wait within the tag.
    pub(super) fn complete(&mut self, had_input: bool) {
        if core::mem::take(&mut self.open) && (had_input || self.confirm) {
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
mod tests {
    use std::vec;

    use lf_model::time::Microstep;
    use proptest::prelude::*;

    use super::*;

    const START: Instant = Instant(1_000);

    fn tag(time: i64, microstep: u32) -> Tag {
        Tag::new(START + Interval(time), Microstep(microstep))
    }

    fn started() -> Tags {
        let mut tags = Tags::new(true, true);
        tags.start(START);
        tags
    }

    /// Announces without physical actions.
    fn announce(tags: &mut Tags, next: Tag) {
        assert!(tags.next_event(next));
        tags.announce(START, None, |_| unreachable!("nothing bounds the next event"));
    }

    #[test]
    fn a_provisional_grant_allows_its_tag_and_what_is_before_and_has_it_confirmed() {
        let mut tags = started();
        tags.grant_provisionally(tag(5, 0), false);
        let allowed = [tag(4, 9), tag(5, 0), tag(5, 1)].map(|tag| tags.allows(tag));
        assert_eq!((allowed, tags.summons()), ([true, true, false], Some(tag(5, 0))));
        tags.begin(tag(5, 0));
        assert!(!tags.knows_all_inputs() && tags.summons().is_none());
        assert_eq!(tags.message_received(tag(5, 0)), Arrival::InTime);
        tags.complete(false);
        assert_eq!((tags.ltc(), tags.message_received(tag(5, 0))), (Some(tag(5, 0)), Arrival::Late));
    }

    #[test]
    fn a_provisional_grant_that_comes_too_late_is_confirmed_at_once_or_when_the_tag_is_complete() {
        let mut tags = started();
        tags.grant(tag(9, 0));
        tags.begin(tag(5, 0));
        tags.grant_provisionally(tag(3, 0), false);
        assert_eq!(tags.ltc(), Some(tag(3, 0)));
        tags.ltc_transmitted();
        tags.grant_provisionally(tag(5, 0), false);
        assert_eq!(tags.ltc(), None);
        tags.complete(false);
        assert_eq!(tags.ltc(), Some(tag(5, 0)));
    }

    #[test]
    fn what_a_stop_takes_back_has_to_be_asked_for_again() {
        let mut tags = started();
        tags.grant(Tag::FOREVER);
        tags.begin(tag(1, 0));
        tags.complete(false);
        tags.grant_provisionally(tag(5, 0), true);
        assert!(tags.allows(tag(4, 0)) && !tags.allows(tag(5, 0)) && tags.summons().is_none());
        announce(&mut tags, tag(5, 0));
        assert_eq!((tags.ltc(), tags.net()), (Some(tag(5, 0).before()), Some(tag(5, 0))));
        assert!(tags.grant(tag(5, 0)) && tags.allows(tag(5, 0)));
    }

    #[test]
    fn what_is_left_out_is_told_after_a_while() {
        let mut tags = started();
        announce(&mut tags, tag(1, 0));
        tags.net_transmitted();
        // Nothing up to there matters to anybody, so the RTI knows more than it has asked for.
        tags.handle_dnet(tag(0, 0));
        tags.grant(tag(9, 0));
        tags.begin(tag(1, 0));
        tags.complete(false);
        announce(&mut tags, tag(7, 0));
        let due = Deadline::At(START + SILENCE);
        assert_eq!((tags.net(), tags.poll_timeout()), (None, due));
        tags.handle_timeout(START + SILENCE + Interval(-1));
        assert_eq!((tags.net(), tags.poll_timeout()), (None, due));
        tags.handle_timeout(START + SILENCE);
        assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(7, 0)), Deadline::Never));
    }

    #[test]
    fn a_bound_is_told_once_until_it_is_renewed() {
        let mut tags = started();
        assert!(tags.next_event(Tag::FOREVER));
        let at = |time: i64| START + Interval(time);
        let bound = |tags: &mut Tags, now: i64| tags.announce(at(now), Some(at(now + 2)), |_| at(now + 10));
        bound(&mut tags, 0);
        assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(1, 0)), Deadline::At(at(10))));
        tags.net_transmitted();
        bound(&mut tags, 9);
        assert_eq!((tags.net(), tags.is_renewal_due(at(9))), (None, false));
        bound(&mut tags, 10);
        assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(11, 0)), Deadline::At(at(20))));
        tags.finish();
        assert_eq!((tags.net(), tags.poll_timeout()), (Some(Tag::FOREVER), Deadline::Never));
    }

    #[derive(Clone, Debug)]
    enum Step {
        Grant(Tag),
        GrantProvisionally(Tag),
        TakeBack(Tag),
        Dnet(Tag),
        Receive(Tag),
        Next(Tag, Option<i64>),
        Begin(Tag),
        Send,
        Complete(bool),
        Transmit,
        Pass(i64),
    }

    fn step() -> impl Strategy<Value = Step> {
        let tags = || (0..40i64, 0..3u32).prop_map(|(time, microstep)| tag(time, microstep));
        prop_oneof![
            2 => tags().prop_map(Step::Grant),
            2 => tags().prop_map(Step::GrantProvisionally),
            1 => tags().prop_map(Step::TakeBack),
            1 => tags().prop_map(Step::Dnet),
            2 => tags().prop_map(Step::Receive),
            4 => (tags(), prop::option::of(0..40i64)).prop_map(|(tag, physical)| Step::Next(tag, physical)),
            4 => tags().prop_map(Step::Begin),
            1 => Just(Step::Send),
            3 => any::<bool>().prop_map(Step::Complete),
            3 => Just(Step::Transmit),
            1 => (0..SILENCE.as_nanos()).prop_map(Step::Pass),
        ]
    }

    proptest! {
        /// Whatever comes in whatever order: what may be begun has been granted and not been taken back, tags rise, no
        /// LTC is told twice or of a tag that is to come, and a NET is neither of a tag that is over nor later than what
        /// is next.
        #[test]
        fn no_promise_is_broken(steps in prop::collection::vec(step(), 0..120)) {
            let mut tags = started();
            let (mut granted, mut provisional) = (Tag::NEVER, Tag::NEVER);
            let (mut ltc, mut now) = (Tag::NEVER, START);
            // The least of what has been announced since a tag was begun, with what bounded it.
            let mut next = Tag::FOREVER;
            for step in steps {
                let before = tags.current();
                match step {
                    Step::Grant(tag) => {
                        prop_assert_eq!(tags.grant(tag), tag > granted);
                        granted = granted.max(tag);
                    }
                    Step::GrantProvisionally(tag) => {
                        tags.grant_provisionally(tag, false);
                        granted = granted.max(tag.before());
                        provisional = provisional.max(tag);
                    }
                    Step::TakeBack(tag) => {
                        if tag > tags.current() && tag <= granted {
                            granted = tag.before();
                            provisional = if provisional < tag { provisional } else { Tag::NEVER };
                            tags.grant_provisionally(tag, true);
                            prop_assert!(!tags.allows(tag) && tags.summons().is_none_or(|summons| summons < tag));
                        }
                    }
                    Step::Dnet(tag) => tags.handle_dnet(tag),
                    Step::Receive(tag) => {
                        let late = tags.message_received(tag) == Arrival::Late;
                        let may_be_known = tag == before && granted < tag;
                        prop_assert_eq!(late, tag <= before && !(may_be_known && tags.open));
                    }
                    Step::Next(tag, physical) => {
                        let was_open = tags.open;
                        prop_assert_eq!(tags.next_event(tag), !was_open && tag > before);
                        if !was_open && tag > before {
                            next = tag;
                            tags.announce(now, physical.map(|time| START + Interval(time)), |_| now + Interval(5));
                        }
                    }
                    Step::Begin(tag) => {
                        let may = tag > before && (tag <= granted || tag == provisional);
                        prop_assert_eq!(tags.allows(tag), may);
                        if may && !tags.open {
                            tags.begin(tag);
                            next = Tag::FOREVER;
                        }
                    }
                    Step::Send => tags.message_sent(),
                    Step::Complete(had_input) => {
                        let confirms = tags.open && (had_input || provisional == before) && before > ltc;
                        tags.complete(had_input);
                        prop_assert!(!confirms || tags.ltc() == Some(before));
                    }
                    Step::Transmit => {
                        if let Some(tag) = tags.ltc() {
                            prop_assert!(tag > ltc && tag <= tags.current().max(next.before()));
                            ltc = tag;
                            tags.ltc_transmitted();
                        }
                        if let Some(tag) = tags.net() {
                            prop_assert!(tag >= tags.current() && tag <= next);
                            tags.net_transmitted();
                        }
                    }
                    Step::Pass(time) => {
                        now = now + Interval(time);
                        tags.handle_timeout(now);
                    }
                }
                prop_assert!(tags.current() >= before);
                prop_assert_eq!(tags.granted(), granted);
                prop_assert!(tags.summons().is_none_or(|summons| tags.allows(summons)));
            }
        }
    }
}
