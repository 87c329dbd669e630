// SPDX-License-Identifier: Apache-2.0
//! Which next event tags (NET) the RTI has to be told, given its grants and downstream next event tags (DNET).
//!
//! The rules are those of the stock federate, but for NETs that it sends twice: what the RTI has been told last is not
//! told again. A DNET says that no NET up to and including it matters to anybody downstream.

use lf_model::time::Tag;

/// What has been granted, asked for and told.
#[derive(Clone, Debug)]
pub(super) struct NetRules {
    has_upstream: bool,
    has_downstream: bool,
    /// The last TAG.
    granted: Tag,
    /// The last DNET, lowered by the messages that this federate has sent since.
    dnet: Tag,
    any_dnet: bool,
    /// The last NET sent.
    sent: Tag,
    /// The NET that was left out since.
    skipped: Option<Tag>,
}

impl NetRules {
    pub(super) fn new(has_upstream: bool, has_downstream: bool) -> Self {
        Self {
            has_upstream,
            has_downstream,
            granted: Tag::NEVER,
            dnet: Tag::NEVER,
            any_dnet: false,
            sent: Tag::NEVER,
            skipped: None,
        }
    }

    pub(super) fn has_downstream(&self) -> bool {
        self.has_downstream
    }

    pub(super) fn granted(&self) -> Tag {
        self.granted
    }

    /// Whether the RTI allows this tag. A federate to which nobody sends needs no grant.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        !self.has_upstream || tag <= self.granted
    }

    /// A grant; returns whether it is later than the last.
    pub(super) fn grant(&mut self, tag: Tag) -> bool {
        let later = tag > self.granted;
        self.granted = self.granted.max(tag);
        later
    }

    /// The next event is at `tag`; returns the NET to send, if any.
    pub(super) fn next_event(&mut self, tag: Tag) -> Option<Tag> {
        let needed = if tag <= self.granted {
            // This federate needs no further grant; those downstream may need its NET, if they have not had one that
            // is later than what they asked for.
            !self.any_dnet || (self.dnet < tag && self.dnet >= self.sent)
        } else {
            self.dnet < tag || self.has_upstream
        };
        self.announce(tag, needed)
    }

    /// Before `bound` this federate will do nothing, but a physical action may come then, before its next event.
    pub(super) fn bounded(&mut self, bound: Tag) -> Option<Tag> {
        let needed = self.dnet < bound || (self.has_upstream && self.granted < bound);
        self.announce(bound, needed)
    }

    /// A DNET; returns the NET to send, if one was left out that is needed now.
    pub(super) fn handle_dnet(&mut self, dnet: Tag) -> Option<Tag> {
        self.any_dnet = true;
        self.dnet = dnet;
        let due = self.skipped.filter(|skipped| dnet < *skipped)?;
        self.announce(due, true)
    }

    /// A message with this tag goes out: its receiver's next event is not later, whatever the RTI has said before.
    pub(super) fn message_sent(&mut self, tag: Tag) {
        self.dnet = self.dnet.min(tag);
    }

    /// The end: the NET to send before resigning, if any.
    pub(super) fn finish(&mut self) -> Option<Tag> {
        self.announce(Tag::FOREVER, true)
    }

    fn announce(&mut self, tag: Tag, needed: bool) -> Option<Tag> {
        if !(self.has_upstream || self.has_downstream) {
            // Nobody waits for a federate without neighbors, and it waits for nobody.
            return None;
        }
        self.skipped = None;
        if tag == self.sent {
            return None;
        }
        if !needed {
            self.skipped = Some(tag);
            return None;
        }
        self.sent = tag;
        Some(tag)
    }
}
