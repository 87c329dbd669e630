// SPDX-License-Identifier: Apache-2.0
//! The state of a federate as the bytes on its connection to the RTI show it.

use std::collections::BTreeSet;

use lf_model::time::Tag;

/// The state of one federate as its connection shows it.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(super) granted: Tag,
    pub(super) provisional: Tag,
    /// The tag before which the federate has completed all tags and the RTI has received all messages.
    pub(crate) announced: Tag,
    /// The tags of messages that the RTI has forwarded and the federate has not completed: a long `after` can keep very
    /// many.
    pub(super) in_transit: BTreeSet<Tag>,
    /// By port number: the tag of the last message, the number of messages with that tag, and the largest such number.
    pub(super) bursts: Vec<(Tag, usize, usize)>,
    /// The stop tag that it has proposed, while the RTI has not decided.
    pub(super) named: Option<Tag>,
    /// Whether it has proposed a stop tag or agreed to one.
    pub(crate) has_named: bool,
    /// The granted stop tag.
    pub(crate) stop: Option<Tag>,
    /// The time at which the RTI read that it has left.
    pub(crate) left: Option<u64>,
    /// Whether the RTI has announced that it continues without it, and reads no more of its messages.
    pub(crate) is_expelled: bool,
    /// The effective start of an instance of a transient federate.
    pub(crate) first: Option<Tag>,
    pub(crate) introduction: Introduction,
    /// The latest tag that it has reported complete.
    pub(crate) completed: Tag,
    /// Whether the RTI has told it to stop.
    pub(crate) is_told_to_stop: bool,
    /// The time at which its process or its connection ended, or the RTI read that it has failed.
    pub(super) lost: Option<u64>,
}

/// The introduction of an instance of a transient federate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Introduction {
    /// The RTI has not read all of it.
    NotYet,
    /// The RTI has read it.
    Read,
    /// It has waited for its place after that, while another instance has handed over its state.
    Next,
}

/// A message that the RTI has read and not forwarded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unpassed {
    /// The instance that has sent it, and the federate that it is for.
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) port: u16,
    pub(super) tag: Tag,
    /// The number of its value.
    pub(super) number: u64,
    /// The time at which the RTI has read it.
    pub(super) read: u64,
}

impl Seen {
    /// The state before the first message.
    pub(super) const NOTHING: Self = Self {
        granted: Tag::NEVER,
        provisional: Tag::NEVER,
        announced: Tag::NEVER,
        in_transit: BTreeSet::new(),
        bursts: Vec::new(),
        named: None,
        has_named: false,
        stop: None,
        left: None,
        is_expelled: false,
        first: None,
        introduction: Introduction::NotYet,
        completed: Tag::NEVER,
        is_told_to_stop: false,
        lost: None,
    };

    /// Returns the time from which on the instance takes no part.
    pub(crate) fn over(&self) -> Option<u64> {
        [self.left, self.lost].into_iter().flatten().min()
    }

    /// Notes a proposed stop tag: the federate will not begin it or a later tag before the RTI has decided, whatever is
    /// granted.
    pub(super) fn name_stop(&mut self, named: Tag) {
        (self.named, self.has_named) = (Some(named), true);
        // Its earlier announcements do not include the stop, at which it may have a message to send.
        self.announced = self.announced.min(named);
        self.limit();
    }

    /// Notes that all before this tag is complete; messages that the federate had not read by then may be earlier.
    ///
    /// A federate that has proposed a stop tag may have another event before the announced one: the stop.
    pub(super) fn announce(&mut self, tag: Tag) {
        let stop = self.stop.or(self.named).filter(|_| tag != Tag::FOREVER).unwrap_or(Tag::FOREVER);
        let tag = tag.min(stop);
        self.announced = self.in_transit.first().copied().unwrap_or(Tag::FOREVER).min(tag);
    }

    pub(super) fn count(&mut self, port: usize, tag: Tag) {
        if self.bursts.len() <= port {
            self.bursts.resize(port + 1, (Tag::NEVER, 0, 0));
        }
        let (last, count, most) = &mut self.bursts[port];
        *count = if *last == tag { *count + 1 } else { 1 };
        (*last, *most) = (tag, (*most).max(*count));
    }

    /// Returns the largest number of messages for one tag at the input with this port number.
    pub(crate) fn burst(&self, port: u16) -> usize {
        self.bursts.get(usize::from(port)).map_or(0, |(_, _, most)| *most)
    }

    pub(super) fn limit(&mut self) {
        if let Some(named) = self.named {
            self.granted = self.granted.min(named.before());
            self.provisional = self.provisional.min(named);
        }
    }
}
