// SPDX-License-Identifier: Apache-2.0
//! Which next event tags (NET) the RTI has to be told, given its grants and downstream next event tags (DNET).
//!
//! The rules are those of the stock federate, but for NETs that it sends twice: what the RTI knows is not told again.
//! A DNET says that no NET up to and including it matters to anybody downstream.
//!
//! One rule is left out. The stock federate also takes a message that it sends for a DNET of that tag, as its receiver
//! will need the NETs up to there. But the RTI, the stock one too, knows that as soon as it forwards the message: the
//! receiver's next event is that of the message, where it was later, and each change of a next event sends those
//! upstream of it their new DNETs. It withholds one only where it knows a later NET already, and what it knows of a
//! sender when it forwards its message is not later than the tag at which that was sent, so not later than this DNET.
//! Then what was left out meanwhile is told. So nobody waits for more than that, and what both sides take for the last
//! DNET stays the same, for the RTI does not send the same one twice. The federates of the model check do without the
//! rule, too.
//!
//! Two rules are added. The NET after a tag with messages is told in any case. Only then the RTI knows that this
//! federate has left that tag, and can tell a receiver that is too far behind from one whose messages have tags to
//! come.
//!
//! And a federate that has told a NET later than the last DNET does not keep silent for ever until there is another
//! DNET. The RTI sends none as long as somebody downstream has an earlier event, and relies on that federate to get
//! on. But it may be held up by a third one, which needs to know that this one has got on; so that is told after a
//! while.
//!
//! One NET at most is due. A later one replaces it, for it says all that the earlier one said.

use core::marker::PhantomData;

use lf_model::time::Tag;

use super::needs::Needs;

/// What has been granted, asked for and told.
#[derive(Clone, Debug)]
pub(super) struct NetRules<N> {
    has_upstream: bool,
    has_downstream: bool,
    /// The last TAG.
    granted: Tag,
    /// The last DNET.
    dnet: Tag,
    any_dnet: bool,
    /// The last NET that was due, or what the RTI made of it: it lowers a NET when it forwards an earlier message.
    sent: Tag,
    /// What the RTI knows for certain to be the last NET: transmitted, and not lowered.
    told: Option<Tag>,
    /// The NET to be transmitted.
    due: Option<Tag>,
    /// The tag begun last.
    current: Tag,
    /// The latest tag at which messages have been sent, if no NET has been transmitted that is later.
    untold: Option<Tag>,
    /// The NET that was left out since.
    skipped: Option<Tag>,
    needs: PhantomData<N>,
}

impl<N: Needs> NetRules<N> {
    pub(super) const fn new(has_upstream: bool, has_downstream: bool) -> Self {
        Self {
            has_upstream,
            has_downstream,
            granted: Tag::NEVER,
            dnet: Tag::NEVER,
            any_dnet: false,
            sent: Tag::NEVER,
            told: None,
            due: None,
            current: Tag::NEVER,
            untold: None,
            skipped: None,
            needs: PhantomData,
        }
    }

    /// Whether grants matter.
    fn has_upstream(&self) -> bool {
        N::INPUTS && self.has_upstream
    }

    pub(super) fn granted(&self) -> Tag {
        self.granted
    }

    /// Whether the RTI allows this tag. A federate to which nobody sends needs no grant.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        !self.has_upstream() || tag <= self.granted
    }

    /// A grant; returns whether it is later than the last.
    pub(super) fn grant(&mut self, tag: Tag) -> bool {
        let later = tag > self.granted;
        self.granted = self.granted.max(tag);
        later
    }

    /// Whether a NET is left out though it is later than the last DNET.
    pub(super) fn is_silent(&self) -> bool {
        self.skipped.is_some_and(|skipped| skipped > self.dnet)
    }

    /// What is left out is told.
    pub(super) fn break_silence(&mut self) {
        if let Some(skipped) = self.skipped {
            self.announce(skipped, true);
        }
    }

    /// No grant counts from this tag on.
    pub(super) fn take_back(&mut self, tag: Tag) {
        self.granted = self.granted.min(tag.before());
    }

    /// Whether the RTI takes this tag for this federate's next event, or will when the NET that is due has come.
    pub(super) fn is_last(&self, tag: Tag) -> bool {
        self.sent == tag
    }

    /// The NET to be transmitted.
    pub(super) fn due(&self) -> Option<Tag> {
        self.due
    }

    /// The NET has been transmitted.
    pub(super) fn transmitted(&mut self) {
        self.told = self.due.take();
        self.untold = self.untold.filter(|at| self.told <= Some(*at));
    }

    /// The next event is at `tag`.
    pub(super) fn next_event(&mut self, tag: Tag) {
        let needed = if (N::INPUTS || N::CYCLES) && tag <= self.granted {
            // This federate needs no further grant; those downstream may need its NET, if they have not had one that
            // is later than what they asked for.
            !self.any_dnet || self.dnet == Tag::NEVER || (self.dnet < tag && self.dnet >= self.sent)
        } else {
            self.dnet < tag || self.has_upstream()
        };
        self.announce(tag, needed || self.untold.is_some());
    }

    /// The next event is at `tag`, and is not told yet. Nor is a later one that was to be told, for it would promise
    /// more.
    pub(super) fn withhold(&mut self, tag: Tag) {
        self.skipped = self.skipped.filter(|skipped| *skipped <= tag);
        if self.due.is_some_and(|due| due > tag) {
            self.due = None;
            self.sent = self.told.unwrap_or(Tag::NEVER);
        }
    }

    /// Before `bound` this federate will do nothing, but a physical action may come then, before its next event.
    pub(super) fn bounded(&mut self, bound: Tag) {
        let needed = self.dnet < bound || (self.has_upstream() && self.granted < bound);
        self.announce(bound, needed || self.untold.is_some());
    }

    /// A DNET. A NET that was left out may be needed now.
    pub(super) fn handle_dnet(&mut self, dnet: Tag) {
        self.any_dnet = true;
        self.dnet = dnet;
        if let Some(skipped) = self.skipped.filter(|skipped| dnet < *skipped) {
            self.announce(skipped, true);
        }
    }

    /// A message for this federate has come. If it is earlier than this federate's NET, the RTI takes its tag for the
    /// NET until it is told another one, be it the same as before.
    pub(super) fn message_received(&mut self, tag: Tag) {
        self.sent = self.sent.min(tag);
        self.told = self.told.filter(|told| *told <= tag);
    }

    /// A message goes out.
    pub(super) fn message_sent(&mut self) {
        self.untold = Some(self.current);
    }

    /// This tag has been begun: the NET of an earlier one would tell of an event that is over.
    pub(super) fn begun(&mut self, tag: Tag) {
        self.current = tag;
        self.due = self.due.filter(|due| *due >= tag);
        self.skipped = self.skipped.filter(|skipped| *skipped >= tag);
    }

    /// The RTI is about to be told that this tag is complete.
    pub(super) fn completed(&mut self, tag: Tag) {
        self.due = self.due.filter(|due| *due > tag);
        self.skipped = self.skipped.filter(|skipped| *skipped > tag);
    }

    /// The end: nothing will come from this federate any more.
    pub(super) fn finish(&mut self) {
        self.announce(Tag::FOREVER, true);
    }

    fn announce(&mut self, tag: Tag, needed: bool) {
        if !(self.has_upstream() || self.has_downstream) {
            // Nobody waits for a federate without neighbors, and it waits for nobody.
            return;
        }
        self.skipped = None;
        if self.told == Some(tag) {
            self.due = None;
            self.sent = tag;
        } else if needed || self.due.is_some() {
            // A NET that is still due must not go out any more: it may promise more than this one.
            self.due = Some(tag);
            self.sent = tag;
        } else {
            self.skipped = Some(tag);
        }
    }
}
