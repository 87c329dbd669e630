// SPDX-License-Identifier: Apache-2.0
//! What the bytes on a federate's connection to the RTI tell of the federate.

use std::collections::BTreeSet;

use lf_model::time::Tag;

/// What is known of one federate from its connection.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(super) granted: Tag,
    pub(super) provisional: Tag,
    /// Before this tag all is complete, and all that was sent has come to the RTI.
    pub(crate) announced: Tag,
    /// The tags of messages that were sent to it, and that it has not completed: a long `after` can keep very many.
    pub(super) in_transit: BTreeSet<Tag>,
    /// By port number: the tag of the last message, how many there were for it, and the most for any.
    pub(super) bursts: Vec<(Tag, usize, usize)>,
    /// The stop that it has named, while the RTI has not decided.
    pub(super) named: Option<Tag>,
    /// It has had its say about the stop.
    pub(crate) has_named: bool,
    /// The stop that was granted.
    pub(crate) stop: Option<Tag>,
    /// When the RTI heard that it has left.
    pub(crate) left: Option<u64>,
    /// The RTI has told it that it goes on without it, and takes nothing from it any more.
    pub(super) is_expelled: bool,
}

/// A message that the RTI has read and not passed on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unpassed {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) port: u16,
    pub(super) tag: Tag,
}

impl Seen {
    /// Nothing has been said.
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
    };

    /// It will not begin this tag or a later one before the RTI has decided, whatever is granted.
    pub(super) fn name_stop(&mut self, named: Tag) {
        (self.named, self.has_named) = (Some(named), true);
        // What it has told before does not count the stop, at which it may have something to send.
        self.announced = self.announced.min(named);
        self.limit();
    }

    /// It says that all before this tag is complete; messages that it had not seen then may come before.
    ///
    /// One that has named a tag to stop at may have another event before what it tells: the stop.
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

    /// The most messages that came for one tag at the input with this port number.
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
