// SPDX-License-Identifier: Apache-2.0
//! The tags of messages that are on their way to a federate.
//!
//! A federate that has announced its next event does not know of the messages that have been forwarded since. Until it
//! completes the tag of such a message, the RTI takes its next event to be no later than that tag; otherwise a third
//! federate could be granted a tag at which the message still causes something.
//!
//! Grants ask for the earliest of these tags only, but when it is done the next one is asked for, and how many there
//! are is up to the peers: a sender with a long `after` sends many before the first is due. The storage is bounded all
//! the same, and no sender is held up for it, because the federate that waits may well wait for that sender's next
//! announcement. Instead, the tags are kept exactly as long as they fit, the earliest first. What does not fit is kept
//! as a *fog*: one range from the earliest to the latest of them, anywhere in which there may be messages. Within the
//! fog the federate's next event counts as coming right after the tag that it has completed last.
//!
//! This is always safe, since the tag that counts is never later than the true one. Nobody waits for ever in a graph
//! without cycles: the federate in the fog does not depend on those who wait for it, and leaves the fog when it
//! completes its last tag. In a cycle, the capacity has to cover the tags that can be on their way at once, as that of
//! the federate's own input queue has to; a fog is therefore reported.

use lf_model::time::Tag;

use super::delay::earliest_after;

/// Which entries of its share of the storage a federate uses: a ring of rising tags, and the fog.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Ring {
    pub(super) head: usize,
    pub(super) len: usize,
    /// Earliest and latest tag that did not fit.
    fog: Option<(Tag, Tag)>,
}

impl Ring {
    /// Nothing is on its way.
    pub(super) const EMPTY: Self = Self { head: 0, len: 0, fog: None };
}

/// The ring of one federate with its storage, which is not empty.
pub(super) struct InTransit<'a> {
    pub(super) ring: &'a mut Ring,
    pub(super) storage: &'a mut [Tag],
}

impl InTransit<'_> {
    fn at(&mut self, index: usize) -> &mut Tag {
        let position = (self.ring.head + index) % self.storage.len();
        &mut self.storage[position]
    }

    /// The tag before which no message is on its way: FOREVER if there is none.
    pub(super) fn earliest(&mut self) -> Tag {
        let exact = if self.ring.len > 0 { *self.at(0) } else { Tag::FOREVER };
        self.ring.fog.map_or(exact, |(from, _)| exact.min(from))
    }

    /// Whether messages of at least `count` different tags before `limit` are on their way, as far as is known. A fog
    /// that ends before it holds more than are counted here.
    pub(super) fn has_before(&mut self, limit: Tag, count: usize) -> bool {
        let last = count.clamp(1, self.storage.len()) - 1;
        (last < self.ring.len && *self.at(last) < limit) || self.ring.fog.is_some_and(|(_, to)| to < limit)
    }

    /// Remembers a message. Returns whether a fog has come up by that.
    ///
    /// Costs one step if its tag is the latest so far, which is the rule; else a step for each later one.
    pub(super) fn insert(&mut self, tag: Tag) -> bool {
        let mut place = self.ring.len;
        while place > 0 && *self.at(place - 1) > tag {
            place -= 1;
        }
        if place > 0 && *self.at(place - 1) == tag {
            return false;
        }
        let mut new_fog = false;
        if self.ring.len == self.storage.len() {
            new_fog = self.ring.fog.is_none();
            if place == self.ring.len {
                self.cloud(tag);
                return new_fog;
            }
            self.ring.len -= 1;
            let last = *self.at(self.ring.len);
            self.cloud(last);
        }
        for index in (place..self.ring.len).rev() {
            let moved = *self.at(index);
            *self.at(index + 1) = moved;
        }
        *self.at(place) = tag;
        self.ring.len += 1;
        new_fog
    }

    fn cloud(&mut self, tag: Tag) {
        let (from, to) = self.ring.fog.unwrap_or((tag, tag));
        self.ring.fog = Some((from.min(tag), to.max(tag)));
    }

    /// The federate has completed `tag`, and with it all messages up to it.
    pub(super) fn complete(&mut self, tag: Tag) {
        while self.ring.len > 0 && *self.at(0) <= tag {
            self.ring.head = (self.ring.head + 1) % self.storage.len();
            self.ring.len -= 1;
        }
        self.ring.fog = match self.ring.fog {
            Some((_, to)) if to <= tag => None,
            Some((from, to)) if from <= tag => Some((earliest_after(tag), to)),
            other => other,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_model::time::Instant;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[derive(Clone, Debug)]
    enum Step {
        Insert(i64),
        Complete(i64),
    }

    fn steps(max: i64) -> impl Strategy<Value = std::vec::Vec<Step>> {
        let step = prop_oneof![(0..max).prop_map(Step::Insert), (0..max).prop_map(Step::Complete)];
        proptest::collection::vec(step, 0..60)
    }

    proptest! {
        /// With room for all it is exact; without, it is never later than exact, and clear again once all is done.
        #[test]
        fn the_earliest_tag_is_exact_or_too_early(steps in steps(40), capacity in 1usize..50) {
            let mut storage = std::vec![Tag::NEVER; capacity];
            let mut ring = Ring::default();
            let mut exact = BTreeSet::new();
            let mut fogged = false;
            for step in steps {
                let mut queue = InTransit { ring: &mut ring, storage: &mut storage };
                match step {
                    Step::Insert(time) => {
                        exact.insert(Tag::at(Instant(time)));
                        fogged |= queue.insert(Tag::at(Instant(time)));
                    }
                    Step::Complete(time) => {
                        exact.retain(|tag: &Tag| tag.time > Instant(time));
                        queue.complete(Tag::at(Instant(time)));
                    }
                }
                let expected = exact.first().copied().unwrap_or(Tag::FOREVER);
                prop_assert!(queue.earliest() <= expected);
                prop_assert!(fogged || queue.earliest() == expected);
                prop_assert!(fogged || exact.len() <= capacity);
            }
            let mut queue = InTransit { ring: &mut ring, storage: &mut storage };
            queue.complete(Tag::at(Instant(40)));
            prop_assert_eq!(queue.earliest(), Tag::FOREVER);
        }
    }
}
