// SPDX-License-Identifier: Apache-2.0
//! The agreement on a common stop tag.
//!
//! A federate that asks to stop, or is asked, names the earliest tag at which it can stop. From then on it begins
//! neither this tag nor a later one until the RTI has decided on the stop tag: the latest of all that were named.

use lf_model::time::Tag;
use lf_wire::Message;

use crate::tag::to_wire;

/// The state of the agreement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Agreement {
    /// No federate has asked.
    None,
    /// This federate has named a tag, in a request or a reply.
    Named(Tag),
    /// The RTI has decided.
    Granted(Tag),
}

/// The tag that this federate has named and still has to send, once.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Due {
    Request(Tag),
    Reply(Tag),
}

/// The time at which this federate stops, as far as it is known.
#[derive(Clone, Debug)]
pub(super) struct Stop {
    agreement: Agreement,
    due: Option<Due>,
    /// The last tag by the program's own time-out.
    limit: Tag,
}

impl Stop {
    pub(super) const fn new() -> Self {
        Self { agreement: Agreement::None, due: None, limit: Tag::FOREVER }
    }

    /// Returns the last tag, as far as it is known.
    pub(super) fn last_tag(&self) -> Tag {
        match self.agreement {
            Agreement::Granted(tag) => self.limit.min(tag),
            Agreement::None | Agreement::Named(_) => self.limit,
        }
    }

    /// Returns the tag that all federates have agreed upon.
    pub(super) fn granted(&self) -> Option<Tag> {
        match self.agreement {
            Agreement::Granted(tag) => Some(tag),
            Agreement::None | Agreement::Named(_) => None,
        }
    }

    /// Returns whether a tag was named and the RTI has not decided. Until then grants from that tag on do not count.
    pub(super) fn is_open(&self) -> bool {
        matches!(self.agreement, Agreement::Named(_))
    }

    /// Returns whether the agreement allows this tag to begin.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        tag <= self.last_tag() && !matches!(self.agreement, Agreement::Named(named) if named <= tag)
    }

    /// Sets the program's own time-out; the earliest one counts.
    pub(super) fn limit(&mut self, tag: Tag) {
        self.limit = self.limit.min(tag);
    }

    /// Asks to stop at `earliest` or later. Has no effect if this federate has named a tag before.
    pub(super) fn request(&mut self, earliest: Tag) {
        if self.agreement == Agreement::None {
            self.agreement = Agreement::Named(earliest);
            self.due = Some(Due::Request(earliest));
        }
    }

    /// Handles the RTI's request to stop at `tag`; this federate can stop at `earliest` or later. Returns the tag that
    /// it names, unless it has named one before.
    pub(super) fn asked(&mut self, tag: Tag, earliest: Tag) -> Option<Tag> {
        if self.agreement != Agreement::None {
            return None;
        }
        let named = tag.max(earliest);
        self.agreement = Agreement::Named(named);
        self.due = Some(Due::Reply(named));
        Some(named)
    }

    /// Handles the RTI's decision on `tag`; this federate can stop at `earliest` or later. Returns its last tag.
    ///
    /// The RTI takes the latest of all tags that were named, so `earliest` is later only if the RTI is mistaken. Then
    /// the federate stops as soon as it can, as the stock one does.
    pub(super) fn decided(&mut self, tag: Tag, earliest: Tag) -> Tag {
        self.agreement = Agreement::Granted(tag.max(earliest));
        self.last_tag()
    }

    /// Returns the message that is due.
    pub(super) fn due(&self) -> Option<Message<'static>> {
        self.due.map(|due| match due {
            Due::Request(tag) => Message::StopRequest(to_wire(tag)),
            Due::Reply(tag) => Message::StopReply(to_wire(tag)),
        })
    }

    /// Records that the message has been transmitted.
    pub(super) fn transmitted(&mut self) {
        self.due = None;
    }
}
