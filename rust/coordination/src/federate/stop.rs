// SPDX-License-Identifier: Apache-2.0
//! The agreement on a common stop tag.
//!
//! Whoever asks to stop, or is asked, names the earliest tag at which it can, and from then on does not begin this tag
//! or a later one until the RTI has said which tag it is: the latest of all that were named.

use lf_model::time::Tag;
use lf_wire::Message;

use crate::tag::to_wire;

/// How far the agreement is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Agreement {
    /// Nobody has asked.
    None,
    /// This federate has named a tag, in a request or a reply.
    Named(Tag),
    /// The RTI has decided.
    Granted(Tag),
}

/// The tag that this federate has named and is to tell. It does so once.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Due {
    Request(Tag),
    Reply(Tag),
}

/// When this federate stops, as far as is known.
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

    /// The last tag, as far as is known.
    pub(super) fn last_tag(&self) -> Tag {
        match self.agreement {
            Agreement::Granted(tag) => self.limit.min(tag),
            Agreement::None | Agreement::Named(_) => self.limit,
        }
    }

    /// The tag that all have agreed upon.
    pub(super) fn granted(&self) -> Option<Tag> {
        match self.agreement {
            Agreement::Granted(tag) => Some(tag),
            Agreement::None | Agreement::Named(_) => None,
        }
    }

    /// Whether a tag was named, and the RTI has not decided: grants from that tag on do not count before it has.
    pub(super) fn is_open(&self) -> bool {
        matches!(self.agreement, Agreement::Named(_))
    }

    /// Whether this tag may be begun as far as stopping is concerned.
    pub(super) fn allows(&self, tag: Tag) -> bool {
        tag <= self.last_tag() && !matches!(self.agreement, Agreement::Named(named) if named <= tag)
    }

    /// The program's own time-out; the earliest one counts.
    pub(super) fn limit(&mut self, tag: Tag) {
        self.limit = self.limit.min(tag);
    }

    /// This federate wants to stop, at `earliest` or later. Without effect if it has named a tag before.
    pub(super) fn request(&mut self, earliest: Tag) {
        if self.agreement == Agreement::None {
            self.agreement = Agreement::Named(earliest);
            self.due = Some(Due::Request(earliest));
        }
    }

    /// The RTI asks for a stop at `tag`; this federate can stop at `earliest` or later. Returns the tag that it names,
    /// if it does so now: who has asked or replied before has named its tag already.
    pub(super) fn asked(&mut self, tag: Tag, earliest: Tag) -> Option<Tag> {
        if self.agreement != Agreement::None {
            return None;
        }
        let named = tag.max(earliest);
        self.agreement = Agreement::Named(named);
        self.due = Some(Due::Reply(named));
        Some(named)
    }

    /// The RTI has decided on `tag`; this federate can stop at `earliest` or later. Returns its last tag.
    ///
    /// The RTI takes the latest of all tags that were named, so `earliest` is later only if the RTI is mistaken. Then
    /// the federate stops as soon as it can, as the stock one does.
    pub(super) fn decided(&mut self, tag: Tag, earliest: Tag) -> Tag {
        self.agreement = Agreement::Granted(tag.max(earliest));
        self.last_tag()
    }

    /// The message that is due.
    pub(super) fn due(&self) -> Option<Message<'static>> {
        self.due.map(|due| match due {
            Due::Request(tag) => Message::StopRequest(to_wire(tag)),
            Due::Reply(tag) => Message::StopReply(to_wire(tag)),
        })
    }

    /// The message has been transmitted.
    pub(super) fn transmitted(&mut self) {
        self.due = None;
    }
}
