// SPDX-License-Identifier: Apache-2.0
//! The rules for next event tags (NET): which of them the RTI needs, given its grants and downstream next event tags
//! (DNET).
//!
//! The rules are those of the stock federate, except that a NET is not sent twice. A DNET says that no NET up to and
//! including it matters downstream.
//!
//! One rule is left out. The stock federate also treats a message that it sends as a DNET of that tag, as its receiver
//! will need the NETs up to there. But every RTI, the stock one too, knows that as soon as it forwards the message: the
//! receiver's next event becomes that of the message, if it was later, and each change of a next event sends new DNETs
//! to those upstream of it. The RTI withholds a DNET only if it knows a later NET already, and what it knows of a
//! sender when it forwards its message is not later than the tag at which that was sent, so not later than this DNET.
//! Then the federate sends the NET that it left out. So no federate waits for more than that, and both sides agree on
//! the last DNET, because the RTI does not send the same one twice. The federates of the model check work without this
//! rule, too.
//!
//! Two rules are added. The federate always sends the NET after a tag with messages. Only then does the RTI know that
//! this federate has left that tag, and can tell a receiver that is too far behind from one whose messages have tags to
//! come.
//!
//! And a federate whose last NET was later than the last DNET does not stay silent until the next DNET. The RTI sends
//! none while a federate downstream has an earlier event, and relies on that federate to proceed. But a third federate
//! may hold it up, which needs to know that this one has proceeded; so the NET follows after a while.
//!
//! At most one NET is due. A later one replaces it, because it implies the earlier one.

use core::marker::PhantomData;

use lf_model::time::Tag;

use super::needs::Needs;

/// The tags that were granted, requested and announced.
#[derive(Clone, Debug)]
pub(super) struct NetRules<N> {
    has_upstream: bool,
    has_downstream: bool,
    /// The last TAG.
    granted: Tag,
    /// The last DNET.
    dnet: Tag,
    /// Whether a NET has been transmitted. Until then an RTI may take the start for this federate's next event.
    any_net: bool,
    /// The last NET that was due, or the RTI's version of it: it lowers a NET when it forwards an earlier message.
    sent: Tag,
    /// The NET that the RTI knows for certain to be the last one: transmitted, and not lowered.
    announced: Option<Tag>,
    /// The NET to be transmitted.
    due: Option<Tag>,
    /// The tag begun last.
    current: Tag,
    /// The latest tag at which messages were sent, if no later NET has been transmitted.
    unannounced: Option<Tag>,
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
            any_net: false,
            sent: Tag::NEVER,
            announced: None,
            due: None,
            current: Tag::NEVER,
            unannounced: None,
            skipped: None,
            needs: PhantomData,
        }
    }

    /// Returns whether grants matter.
    fn has_upstream(&self) -> bool {
        N::INPUTS && self.has_upstream
    }

    pub(super) fn granted(&self) -> Tag {
        self.granted
    }

    /// Returns whether the RTI allows this tag. A federate without inputs needs no grant.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        !self.has_upstream() || tag <= self.granted
    }

    /// Handles a grant; returns whether it is later than the last.
    pub(super) fn grant(&mut self, tag: Tag) -> bool {
        let later = tag > self.granted;
        self.granted = self.granted.max(tag);
        later
    }

    /// Returns whether a NET is left out though it is later than the last DNET.
    pub(super) fn is_silent(&self) -> bool {
        self.skipped.is_some_and(|skipped| skipped > self.dnet)
    }

    /// Makes the NET due that was left out.
    pub(super) fn break_silence(&mut self) {
        if let Some(skipped) = self.skipped {
            self.announce(skipped, true);
        }
    }

    /// Revokes all grants from this tag on.
    pub(super) fn revoke(&mut self, tag: Tag) {
        self.granted = self.granted.min(tag.before());
    }

    /// Returns whether the RTI takes this tag for this federate's next event, or will when the NET that is due has
    /// come.
    pub(super) fn is_last(&self, tag: Tag) -> bool {
        self.sent == tag
    }

    /// Returns whether the RTI takes a later tag than this for this federate's next event, or will.
    #[cfg(feature = "transients")]
    pub(super) fn is_beyond(&self, tag: Tag) -> bool {
        self.sent > tag
    }

    /// Returns whether the RTI knows a NET of this federate.
    pub(super) fn any_net(&self) -> bool {
        self.any_net
    }

    /// Returns the NET to be transmitted.
    pub(super) fn due(&self) -> Option<Tag> {
        self.due
    }

    /// Records that the NET has been transmitted.
    pub(super) fn transmitted(&mut self) {
        self.announced = self.due.take();
        self.any_net = true;
        self.unannounced = self.unannounced.filter(|at| self.announced <= Some(*at));
    }

    /// Sets the next event.
    pub(super) fn next_event(&mut self, tag: Tag) {
        let needed = if (N::INPUTS || N::CYCLES) && tag <= self.granted {
            // This federate needs no further grant. Those downstream may need its NET, if they have not had one that is
            // later than what they requested.
            self.dnet == Tag::NEVER || (self.dnet < tag && self.dnet >= self.sent)
        } else {
            self.dnet < tag || self.has_upstream()
        };
        self.announce(tag, needed || self.unannounced.is_some());
    }

    /// Sets the next event without sending a NET yet. A later NET that is due is dropped, because it would promise
    /// more.
    pub(super) fn withhold(&mut self, tag: Tag) {
        self.skipped = self.skipped.filter(|skipped| *skipped <= tag);
        if self.due.is_some_and(|due| due > tag) {
            self.due = None;
            self.sent = self.announced.unwrap_or(Tag::NEVER);
        }
    }

    /// Announces that this federate does nothing before `bound`, at which a physical action may come before its next
    /// event.
    pub(super) fn bounded(&mut self, bound: Tag) {
        let needed = self.dnet < bound || (self.has_upstream() && self.granted < bound);
        self.announce(bound, needed || self.unannounced.is_some());
    }

    /// Handles a DNET. A NET that was left out may be needed now.
    pub(super) fn handle_dnet(&mut self, dnet: Tag) {
        self.dnet = dnet;
        if let Some(skipped) = self.skipped.filter(|skipped| dnet < *skipped) {
            self.announce(skipped, true);
        }
    }

    /// Handles a message for this federate. If it is earlier than this federate's NET, the RTI takes its tag for the
    /// NET until it receives another NET, even an equal one.
    pub(super) fn message_received(&mut self, tag: Tag) {
        self.sent = self.sent.min(tag);
        self.announced = self.announced.filter(|announced| *announced <= tag);
    }

    /// Records that a message goes out.
    pub(super) fn message_sent(&mut self) {
        self.unannounced = Some(self.current);
    }

    /// Begins this tag: the NET of an earlier one would announce an event that is over.
    pub(super) fn begun(&mut self, tag: Tag) {
        self.current = tag;
        self.due = self.due.filter(|due| *due >= tag);
        self.skipped = self.skipped.filter(|skipped| *skipped >= tag);
    }

    /// Records that the RTI is about to receive the LTC of this tag.
    pub(super) fn completed(&mut self, tag: Tag) {
        self.due = self.due.filter(|due| *due > tag);
        self.skipped = self.skipped.filter(|skipped| *skipped > tag);
    }

    /// Announces that nothing will come from this federate any more.
    pub(super) fn finish(&mut self) {
        self.announce(Tag::FOREVER, true);
    }

    fn announce(&mut self, tag: Tag, needed: bool) {
        if !N::CENTRALIZED || !(self.has_upstream() || self.has_downstream) {
            // A federate without neighbors waits for no other, and no other waits for it.
            return;
        }
        self.skipped = None;
        if self.announced == Some(tag) {
            self.due = None;
            self.sent = tag;
        } else if needed || self.due.is_some() {
            // An earlier NET that is still due must not go out any more: it may promise more than this one.
            self.due = Some(tag);
            self.sent = tag;
        } else {
            self.skipped = Some(tag);
        }
    }
}
