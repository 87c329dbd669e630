// SPDX-License-Identifier: Apache-2.0
//! The tags of messages that are in transit to a federate.
//!
//! A federate that has announced its next event does not know of the messages that the RTI has forwarded since. Until
//! the federate completes the tag of such a message, the RTI takes its next event to be no later than that tag.
//! Otherwise the RTI could grant a third federate a tag at which the message still causes something.
//!
//! A grant depends on the earliest of these tags only, but once that tag is complete the next one counts, and the peers
//! decide how many there are: a sender with a long `after` sends many before the first is due. The storage is bounded,
//! and the RTI holds up no sender for it, because the waiting federate may need that sender's next announcement. So the
//! ring stores as many tags as fit, the earliest first. The other tags are merged into *overflow ranges*: each range
//! has an earliest and a latest tag, and there may be messages anywhere between them.
//!
//! Ranges are exact enough, because the RTI has to remember a message only until its receiver has seen it. From then on
//! the receiver's announcements account for the message, even while it waits for room there. The receiver also shows
//! what it has seen: connections keep the order, so a federate that completes a tag has seen everything that was sent
//! to it before the grant of that tag. There are three overflow ranges:
//!
//! - *open*: messages later than every grant of the receiver. The earliest of their tags is exact, because the receiver
//!   can complete none of them. A grant that reaches the earliest tag closes the range.
//! - *closed*: messages sent before the grant that reached the earliest of them. The receiver has seen them all when it
//!   completes that tag. Two closed ranges that are joined keep the later of the two tags.
//! - *seen*: the receiver's next announcement stands for all of them. The end of the range is kept, because it shows
//!   how far the receiver is behind.
//!
//! **Safe**: the tag that counts is never later than the true one. **Live**: once a federate has done all that it may,
//! no range is closed, so its announcement counts, or the earliest message that is not due yet. No federate therefore
//! waits for a tag without a message, just as if all tags were stored. Only within a cycle without delay can two closed
//! ranges keep federates waiting at a PTAG; there the capacity has to cover the tags that can be in transit at once.
//! The RTI reports the first overflow, because overflow ranges also make flow control coarse (module `window`).

use lf_derive::outlined;
use lf_model::time::Tag;

use super::delay::earliest_after;

/// Messages somewhere between two tags. There is one at the later tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Range {
    from: Tag,
    to: Tag,
}

impl Range {
    fn joined(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| Self { from: self.from.min(other.from), to: self.to.max(other.to) })
    }

    /// Returns what remains of the range once a tag is complete.
    fn after(self, tag: Tag) -> Option<Self> {
        (self.to > tag).then(|| Self { from: self.from.max(earliest_after(tag)), to: self.to })
    }
}

/// The tags that did not fit into the ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct OverflowRanges {
    /// Messages later than all grants.
    open: Option<Range>,
    /// Messages sent before a grant, and the tag whose completion shows that the receiver has seen them.
    closed: Option<(Range, Tag)>,
    /// Messages that the receiver has seen. It has announced its next event since, or will.
    seen: Option<Range>,
}

impl OverflowRanges {
    const NONE: Self = Self { open: None, closed: None, seen: None };

    fn ranges(&self) -> impl Iterator<Item = Range> {
        [self.open, self.closed.map(|(range, _)| range), self.seen].into_iter().flatten()
    }

    fn close(&mut self, range: Range) {
        let (closed, shown_at) = self.closed.unzip();
        self.closed = Some((range.joined(closed), shown_at.unwrap_or(Tag::NEVER).max(range.from)));
    }
}

/// The part of its storage that a federate uses: a ring of rising tags, and the overflow ranges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Ring {
    pub(super) head: usize,
    pub(super) len: usize,
    overflow: OverflowRanges,
}

impl Ring {
    /// A ring without a message.
    pub(super) const EMPTY: Self = Self { head: 0, len: 0, overflow: OverflowRanges::NONE };
}

/// The ring of one federate and its storage, which has at least one entry.
pub(super) struct InTransit<'a> {
    pub(super) ring: &'a mut Ring,
    pub(super) storage: &'a mut [Tag],
}

impl InTransit<'_> {
    #[outlined]
    fn at(&mut self, index: usize) -> &mut Tag {
        let position = (self.ring.head + index) % self.storage.len();
        &mut self.storage[position]
    }

    /// Returns the tag before which the federate's announcements account for every message in transit: FOREVER if they
    /// account for all.
    pub(super) fn earliest(&mut self) -> Tag {
        let exact = if self.ring.len > 0 { *self.at(0) } else { Tag::FOREVER };
        self.ring.overflow.ranges().map(|range| range.from).fold(exact, Tag::min)
    }

    /// Returns whether messages of at least `count` different tags before `limit` may be in transit. An overflow range
    /// that ends before the limit counts as enough of them.
    pub(super) fn has_before(&mut self, limit: Tag, count: usize) -> bool {
        let last = count.clamp(1, self.storage.len()) - 1;
        (last < self.ring.len && *self.at(last) < limit) || self.ring.overflow.ranges().any(|range| range.to < limit)
    }

    /// Records a message to a federate whose last grant, provisional or not, is `granted`. Returns whether the first
    /// overflow range was made.
    ///
    /// Takes one step if its tag is the latest so far, which is the rule; else a step for each later tag.
    pub(super) fn insert(&mut self, tag: Tag, granted: Tag) -> bool {
        let mut position = self.ring.len;
        while position > 0 && *self.at(position - 1) > tag {
            position -= 1;
        }
        if position > 0 && *self.at(position - 1) == tag {
            return false;
        }
        let mut is_first = false;
        if self.ring.len == self.storage.len() {
            is_first = self.ring.overflow == OverflowRanges::NONE;
            if position == self.ring.len {
                self.add_to_overflow(tag, granted);
                return is_first;
            }
            self.ring.len -= 1;
            let last = *self.at(self.ring.len);
            self.add_to_overflow(last, granted);
        }
        for index in (position..self.ring.len).rev() {
            let moved = *self.at(index);
            *self.at(index + 1) = moved;
        }
        *self.at(position) = tag;
        self.ring.len += 1;
        is_first
    }

    fn add_to_overflow(&mut self, tag: Tag, granted: Tag) {
        let overflow = &mut self.ring.overflow;
        let range = Range { from: tag, to: tag };
        if tag > granted {
            overflow.open = Some(range.joined(overflow.open));
        } else {
            // The message is at the tag of a PTAG: a receiver that completes this tag has seen the message.
            overflow.close(range);
        }
    }

    /// Handles that a grant of `tag`, provisional or not, was sent to the federate.
    pub(super) fn grant(&mut self, tag: Tag) {
        let overflow = &mut self.ring.overflow;
        if let Some(range) = overflow.open.take_if(|range| range.from <= tag) {
            overflow.close(range);
        }
    }

    /// Handles that the federate has announced its next event.
    pub(super) fn announce(&mut self, tag: Tag) {
        if let Some(range) = &mut self.ring.overflow.seen {
            range.from = tag.min(range.to);
        }
    }

    /// Handles that the federate has completed `tag`, and thereby all messages up to it.
    pub(super) fn complete(&mut self, tag: Tag) {
        while self.ring.len > 0 && *self.at(0) <= tag {
            self.ring.head = (self.ring.head + 1) % self.storage.len();
            self.ring.len -= 1;
        }
        let overflow = &mut self.ring.overflow;
        overflow.open = overflow.open.and_then(|range| range.after(tag));
        overflow.seen = overflow.seen.and_then(|range| range.after(tag));
        let closed = overflow.closed.take();
        match closed.and_then(|(range, shown_at)| Some((range.after(tag)?, shown_at))) {
            Some((range, shown_at)) if shown_at <= tag => overflow.seen = Some(range.joined(overflow.seen)),
            other => overflow.closed = other,
        }
    }

    /// Moves the tags to the front of the storage and clears the rest.
    pub(super) fn normalize(&mut self) {
        self.storage.rotate_left(self.ring.head);
        self.ring.head = 0;
        if let Some(unused) = self.storage.get_mut(self.ring.len..) {
            unused.fill(Tag::NEVER);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_model::time::Instant;
    use proptest::prelude::*;
    use std::collections::{BTreeSet, VecDeque};

    fn at(time: i64) -> Tag {
        Tag::at(Instant::from_nanos(time))
    }

    #[derive(Clone, Debug)]
    enum Step {
        /// A message is forwarded, this much after the last grant.
        Forward(i64),
        /// This much more is granted.
        Grant(i64),
        /// The federate takes the earliest message.
        Take,
        /// The federate executes its next event, if it may, which makes another one this much later.
        Do(Option<i64>),
        /// The RTI takes the earliest announcement of the federate.
        Hear,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            3 => (1..30i64).prop_map(Step::Forward),
            2 => (1..12i64).prop_map(Step::Grant),
            5 => Just(Step::Take),
            3 => proptest::option::weighted(0.3, 1..20i64).prop_map(Step::Do),
            6 => Just(Step::Hear),
        ]
    }

    enum Sent {
        Message(i64),
        Grant(i64),
    }

    enum Said {
        Complete(i64),
        Next(Tag),
    }

    /// A federate, as seen from the RTI, and as it is.
    struct Federate {
        granted: i64,
        announced: Tag,
        /// The forwarded tags that were not completed, as if there were room for all.
        exact: BTreeSet<i64>,
        sent: VecDeque<Sent>,
        said: VecDeque<Said>,
        may: i64,
        events: BTreeSet<i64>,
        inputs: BTreeSet<i64>,
    }

    impl Federate {
        fn new() -> Self {
            Self {
                granted: 0,
                announced: Tag::FOREVER,
                exact: BTreeSet::new(),
                sent: VecDeque::new(),
                said: VecDeque::new(),
                may: 0,
                events: BTreeSet::new(),
                inputs: BTreeSet::new(),
            }
        }

        fn next(&self) -> Tag {
            self.events.first().map_or(Tag::FOREVER, |time| at(*time))
        }

        fn forward(&mut self, queue: &mut InTransit<'_>, after: i64) {
            let time = self.granted + after;
            self.exact.insert(time);
            self.sent.push_back(Sent::Message(time));
            queue.insert(at(time), at(self.granted));
        }

        fn grant(&mut self, queue: &mut InTransit<'_>, more: i64) {
            self.granted += more;
            self.sent.push_back(Sent::Grant(self.granted));
            queue.grant(at(self.granted));
        }

        fn take(&mut self) {
            match self.sent.pop_front() {
                Some(Sent::Message(time)) => {
                    let before = self.next();
                    self.inputs.insert(time);
                    self.events.insert(time);
                    if self.next() < before {
                        self.said.push_back(Said::Next(self.next()));
                    }
                }
                Some(Sent::Grant(time)) => self.may = time,
                None => {}
            }
        }

        fn act(&mut self, another: Option<i64>) {
            let may = self.may;
            let Some(time) = self.events.first().copied().filter(|time| *time <= may) else { return };
            self.events.remove(&time);
            self.events.extend(another.map(|later| time + later));
            if self.inputs.remove(&time) {
                self.said.push_back(Said::Complete(time));
            }
            self.said.push_back(Said::Next(self.next()));
        }

        fn hear(&mut self, queue: &mut InTransit<'_>) {
            match self.said.pop_front() {
                Some(Said::Complete(time)) => {
                    self.exact.retain(|message| *message > time);
                    queue.complete(at(time));
                }
                Some(Said::Next(tag)) => {
                    self.announced = tag;
                    queue.announce(tag);
                }
                None => {}
            }
        }

        /// Returns the next event as the RTI knows it, and as it would be if all tags were stored.
        fn counts(&self, queue: &mut InTransit<'_>) -> (Tag, Tag) {
            let exact = self.exact.first().map_or(Tag::FOREVER, |time| at(*time));
            (self.announced.min(queue.earliest()), self.announced.min(exact))
        }
    }

    fn with_queue(capacity: usize, look: impl FnOnce(&mut InTransit<'_>)) {
        let mut storage = std::vec![Tag::NEVER; capacity];
        let mut ring = Ring::default();
        look(&mut InTransit { ring: &mut ring, storage: &mut storage });
    }

    #[test]
    fn a_tag_is_stored_once_in_any_order() {
        with_queue(4, |queue| {
            for time in [5, 7, 5, 7, 6, 5, 6, 7] {
                assert!(!queue.insert(at(time), Tag::NEVER));
            }
            assert_eq!(queue.ring.len, 3);
            assert!(queue.has_before(at(8), 3) && !queue.has_before(at(8), 4) && !queue.has_before(at(7), 3));
        });
    }

    #[test]
    fn the_first_tag_beyond_the_storage_is_told() {
        with_queue(2, |queue| {
            let told = [3, 4, 5, 1, 6].map(|time| queue.insert(at(time), Tag::NEVER));
            assert_eq!(told, [false, false, true, false, false]);
        });
    }

    /// A receiver that completes the tag of its PTAG has seen the messages of that tag, and the others are later.
    #[test]
    fn a_message_at_the_granted_tag_is_not_among_the_later_ones() {
        with_queue(1, |queue| {
            queue.insert(at(1), at(5));
            queue.insert(at(5), at(5));
            queue.insert(at(9), at(5));
            assert_eq!(queue.earliest(), at(1));
            queue.complete(at(5));
            assert_eq!(queue.earliest(), at(9));
        });
    }

    #[test]
    fn the_same_messages_have_the_same_form() {
        let forms = [&[1, 2, 5][..], &[5], &[4, 5]].map(|times| {
            let mut form = None;
            with_queue(3, |queue| {
                for time in times {
                    queue.insert(at(*time), Tag::NEVER);
                }
                queue.complete(at(4));
                queue.normalize();
                form = Some((*queue.ring, queue.storage.to_vec()));
            });
            form
        });
        assert_eq!(forms[0], Some((Ring { len: 1, ..Ring::EMPTY }, std::vec![at(5), Tag::NEVER, Tag::NEVER])));
        assert!(forms[1] == forms[0] && forms[2] == forms[0]);
    }

    proptest! {
        /// The next event is never later than if all tags were stored; it is the same if they fit, and whenever the
        /// federate has done all that it may and the RTI knows it.
        #[test]
        fn the_next_event_is_never_too_late_and_exact_at_rest(
            steps in proptest::collection::vec(step(), 0..200),
            capacity in 1usize..6,
        ) {
            let mut storage = std::vec![Tag::NEVER; capacity];
            let mut ring = Ring::default();
            let mut queue = InTransit { ring: &mut ring, storage: &mut storage };
            let mut federate = Federate::new();
            let mut fits = true;
            for step in steps {
                match step {
                    Step::Forward(after) => federate.forward(&mut queue, after),
                    Step::Grant(more) => federate.grant(&mut queue, more),
                    Step::Take => federate.take(),
                    Step::Do(another) => federate.act(another),
                    Step::Hear => federate.hear(&mut queue),
                }
                fits &= federate.exact.len() <= capacity;
                let (counts, exact) = federate.counts(&mut queue);
                prop_assert!(counts <= exact);
                prop_assert!(!fits || counts == exact);
                let at_rest = federate.sent.is_empty()
                    && federate.said.is_empty()
                    && federate.next() > at(federate.may);
                prop_assert!(!at_rest || (counts, exact) == (federate.next(), federate.next()));
            }
        }
    }
}
