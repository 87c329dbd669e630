// SPDX-License-Identifier: Apache-2.0
//! The state of a federate that comes and goes, beside what the RTI knows of every federate.

use lf_model::time::Tag;

/// The knowledge of the RTI about a federate that may come and go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Incarnation {
    /// Whether the federate is transient. From the start on this is true for all that have not started then.
    pub(super) is_transient: bool,
    /// Whether its connections are known. They are the same in each of its incarnations.
    pub(super) has_neighbors: bool,
    /// The first tag of its current incarnation.
    pub(super) begin: Tag,
    /// The latest tag that it has completed in an earlier incarnation, or of a message that was sent to it.
    pub(super) past: Tag,
    /// The latest tag at which it can have sent the messages of its current incarnation.
    pub(super) sent: Tag,
}

impl Incarnation {
    /// The state of an id that no federate has had.
    pub(super) const NONE: Self =
        Self { is_transient: false, has_neighbors: false, begin: Tag::NEVER, past: Tag::NEVER, sent: Tag::NEVER };

    /// Records that a federate takes this id.
    pub(super) fn join(&mut self, is_transient: bool) {
        self.is_transient = is_transient;
    }

    /// Returns whether a message with this tag lies before the effective start.
    pub(super) fn misses(&self, tag: Tag) -> bool {
        tag < self.begin
    }

    /// Records that it has sent a message, at this tag or earlier.
    pub(super) fn record_sent(&mut self, tag: Tag) {
        self.sent = self.sent.max(tag);
    }

    /// Records a tag of the past: the next incarnation begins after it.
    pub(super) fn record(&mut self, tag: Tag) {
        self.past = self.past.max(tag);
    }
}

/// The notifications about transient federates that are pending for a federate. A range has the first and the last id
/// of federates about which there may be something to tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Notifications {
    /// Federates upstream that have come.
    pub(super) upstream_came: Option<(u16, u16)>,
    /// Federates that have left, of those for which the receiver is registered.
    pub(super) outbound_left: Option<(u16, u16)>,
    /// The same of those that have come.
    pub(super) outbound_came: Option<(u16, u16)>,
    /// Whether the federate has to stop alone.
    pub(super) stop: bool,
}

impl Notifications {
    /// Nothing to tell.
    pub(super) const NONE: Self = Self { upstream_came: None, outbound_left: None, outbound_came: None, stop: false };
}

/// Returns what is left of a range without its first id.
pub(super) fn rest(first: u16, last: u16) -> Option<(u16, u16)> {
    (first < last).then(|| (first + 1, last))
}
