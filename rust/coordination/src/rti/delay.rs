// SPDX-License-Identifier: Apache-2.0
//! Delays of connections and of paths of connections, and the arithmetic of tags that goes with them.

use lf_model::time::{Instant, Interval, Microstep, Tag};
use lf_wire::DELAY_NONE;

/// The minimum delay of a path of connections: a time in nanoseconds, then microsteps.
///
/// No delay at all is (0, 0), one microstep is (0, 1). Joining paths is not commutative, because a delay with a time
/// resets the microstep of the tag that it delays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct PathDelay {
    time: i64,
    microsteps: u32,
}

impl PathDelay {
    /// The value for a path that does not exist, greater than every delay.
    pub(super) const NO_PATH: Self = Self { time: i64::MAX, microsteps: u32::MAX };
    /// No delay.
    pub(super) const ZERO: Self = Self { time: 0, microsteps: 0 };

    /// Returns the delay of a connection by its number in a neighbor structure: [`DELAY_NONE`] without `after`, 0 for a
    /// microstep, else nanoseconds. `None` if it is neither.
    pub(super) const fn of_connection(wire: i64) -> Option<Self> {
        match wire {
            DELAY_NONE => Some(Self::ZERO),
            0 => Some(Self { time: 0, microsteps: 1 }),
            i64::MAX => None,
            time if time > 0 => Some(Self { time, microsteps: 0 }),
            _ => None,
        }
    }

    /// Returns its time in nanoseconds, and its microsteps.
    pub(super) const fn parts(self) -> (i64, u32) {
        (self.time, self.microsteps)
    }

    /// Returns the delay of a time in nanoseconds and microsteps.
    pub(super) const fn of_parts(time: i64, microsteps: u32) -> Self {
        Self { time, microsteps }
    }

    pub(super) fn is_path(self) -> bool {
        self != Self::NO_PATH
    }

    /// Returns the delay of this path with `rest` after it.
    pub(super) fn then(self, rest: Self) -> Self {
        if !self.is_path() || !rest.is_path() {
            return Self::NO_PATH;
        }
        let own = if rest.time > 0 { 0 } else { self.microsteps };
        match (self.time.checked_add(rest.time), own.checked_add(rest.microsteps)) {
            (Some(time), Some(microsteps)) if time < i64::MAX => Self { time, microsteps },
            _ => Self::NO_PATH,
        }
    }

    /// Returns the earliest tag at which a message arrives that is sent at `tag`.
    ///
    /// A microstep at its maximum stays there: too early is safe for a grant, too late is not.
    pub(super) fn after(self, tag: Tag) -> Tag {
        if tag.time == Instant::NEVER {
            return Tag::NEVER;
        }
        if tag.time == Instant::FOREVER || !self.is_path() {
            return Tag::FOREVER;
        }
        match tag.time.saturating_add(Interval::from_nanos(self.time)) {
            Instant::FOREVER => Tag::FOREVER,
            time if self.time > 0 => Tag::new(time, Microstep(self.microsteps)),
            time => Tag::new(time, Microstep(tag.microstep.0.saturating_add(self.microsteps))),
        }
    }

    /// Returns the latest tag up to which nothing can arrive any more if the sender has completed `tag`: like
    /// [`after`](Self::after), but one step earlier if there is a time, when the sender's next tag arrives.
    pub(super) fn after_strictly(self, tag: Tag) -> Tag {
        let delayed = self.after(tag);
        let finite = delayed.time != Instant::NEVER && delayed.time != Instant::FOREVER;
        if self.time > 0 && finite { Tag::at(delayed.time).before() } else { delayed }
    }

    /// Returns the latest tag of a sender that can matter to a receiver at `tag`. NEVER if there is none.
    pub(super) fn before(self, tag: Tag) -> Tag {
        if tag.time == Instant::NEVER || tag < Tag::new(Instant::from_nanos(self.time), Microstep(self.microsteps)) {
            return Tag::NEVER;
        }
        if tag.time == Instant::FOREVER {
            return Tag::FOREVER;
        }
        let time = Instant::from_nanos(tag.time.as_nanos().saturating_sub(self.time));
        match tag.microstep.0.checked_sub(self.microsteps) {
            None => Tag::at(time).before(),
            Some(_) if self.time > 0 => Tag::new(time, Microstep(u32::MAX)),
            Some(microstep) => Tag::new(time, Microstep(microstep)),
        }
    }
}

/// Returns the latest tag before `tag`. NEVER and FOREVER stay unchanged.
pub(super) fn latest_before(tag: Tag) -> Tag {
    if tag == Tag::FOREVER { tag } else { tag.before() }
}

/// Returns the earliest tag after `tag`. FOREVER stays unchanged.
pub(super) fn earliest_after(tag: Tag) -> Tag {
    if tag.time == Instant::FOREVER { Tag::FOREVER } else { tag.next_microstep() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn tag_at(time: i64, microstep: u32) -> Tag {
        Tag::new(Instant::from_nanos(time), Microstep(microstep))
    }

    fn delay() -> impl Strategy<Value = PathDelay> {
        (prop_oneof![Just(0i64), 1..50i64], 0..4u32).prop_map(|(time, microsteps)| PathDelay { time, microsteps })
    }

    fn tag() -> impl Strategy<Value = Tag> {
        (1000..2000i64, 0..5u32).prop_map(|(time, microstep)| tag_at(time, microstep))
    }

    #[test]
    fn a_connection_delay_is_none_a_microstep_or_a_time() {
        assert_eq!(PathDelay::of_connection(DELAY_NONE), Some(PathDelay::ZERO));
        assert_eq!(PathDelay::of_connection(0), Some(PathDelay { time: 0, microsteps: 1 }));
        assert_eq!(PathDelay::of_connection(7), Some(PathDelay { time: 7, microsteps: 0 }));
        assert_eq!(PathDelay::of_connection(-1), None);
        assert_eq!(PathDelay::of_connection(i64::MAX), None);
    }

    #[test]
    fn a_tag_before_the_first_microstep_ends_the_nanosecond_before() {
        assert_eq!(latest_before(tag_at(5, 0)), tag_at(4, u32::MAX));
        assert_eq!(latest_before(tag_at(5, 3)), tag_at(5, 2));
        assert_eq!(earliest_after(tag_at(4, u32::MAX)), tag_at(5, 0));
    }

    #[test]
    fn a_path_as_long_as_time_is_none() {
        let [one, rest] = [1, i64::MAX - 1].map(|time| PathDelay { time, microsteps: 0 });
        assert_eq!((one.then(rest).is_path(), rest.then(PathDelay::ZERO)), (false, rest));
    }

    #[test]
    fn nothing_leads_to_a_tag_before_the_delay() {
        let delay = PathDelay { time: 5, microsteps: 2 };
        for tag in [Tag::NEVER, tag_at(4, 9), tag_at(5, 1)] {
            assert_eq!(delay.before(tag), Tag::NEVER);
        }
        assert_eq!(delay.before(tag_at(5, 2)), tag_at(0, u32::MAX));
    }

    #[test]
    fn a_delay_that_overflows_is_never_too_late() {
        let microstep = PathDelay { time: 0, microsteps: 1 };
        assert_eq!(microstep.after(tag_at(5, u32::MAX)), tag_at(5, u32::MAX));
        assert_eq!(microstep.after(Tag::FOREVER), Tag::FOREVER);
        assert_eq!(microstep.after(Tag::NEVER), Tag::NEVER);
    }

    proptest! {
        /// A message over a path arrives when it arrives over the parts of the path one after the other.
        #[test]
        fn a_path_delays_like_its_pieces(tag in tag(), pieces in proptest::collection::vec(delay(), 0..5)) {
            let folded = pieces.iter().rev().fold(PathDelay::ZERO, |rest, piece| piece.then(rest));
            let stepwise = pieces.iter().fold(tag, |tag, piece| piece.after(tag));
            prop_assert_eq!(folded.after(tag), stepwise);
        }

        /// A longer path is never faster, which the search for the minimum delay relies on.
        #[test]
        fn a_longer_path_is_not_faster(pieces in proptest::collection::vec(delay(), 1..5)) {
            let folded: Vec<_> = pieces.iter().rev().scan(PathDelay::ZERO, |rest, piece| {
                *rest = piece.then(*rest);
                Some(*rest)
            }).collect();
            prop_assert!(folded.is_sorted());
        }

        /// Messages that a sender sends after the tag of `before` arrive after the tag in question.
        #[test]
        fn nothing_after_the_downstream_next_event_tag_matters(delay in delay(), tag in tag()) {
            prop_assert!(delay.after(earliest_after(delay.before(tag))) > tag);
        }

        /// Completing a tag allows every tag that the next tag of the sender cannot reach.
        #[test]
        fn a_completed_tag_allows_what_the_next_one_cannot_reach(time in 0..60i64, tag in tag()) {
            let delay = PathDelay::of_connection(if time == 0 { DELAY_NONE } else { time - 1 }).unwrap();
            prop_assert!(delay.after_strictly(tag) < delay.after(earliest_after(tag)));
        }
    }
}
