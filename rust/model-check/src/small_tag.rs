// SPDX-License-Identifier: Apache-2.0
//! Tags in few bits.

use lf_model::time::{Instant, Microstep, Tag};

/// The start time of every federation: the federates' clocks show 0 before.
pub(crate) const START: Instant = Instant::from_nanos(1_000_000_000);

/// The number of microsteps of each time.
const MICROSTEPS: u8 = 4;

/// A tag within the bounds. Later ones are greater.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SmallTag(u8);

impl SmallTag {
    /// The first tag.
    pub const FIRST: Self = Self(0);

    /// Returns the tag `time` ticks after the start. `microstep` is at most 3.
    pub(crate) const fn new(time: u8, microstep: u8) -> Self {
        Self(time * MICROSTEPS + microstep)
    }

    /// Returns the ticks after the start.
    pub const fn time(self) -> u8 {
        self.0 / MICROSTEPS
    }

    /// Returns the microstep.
    pub const fn microstep(self) -> u8 {
        self.0 % MICROSTEPS
    }

    /// Returns the tag that the RTI sees: a tick is a nanosecond, so that no tag is between two times.
    pub fn tag(self) -> Tag {
        Tag::new(Instant::from_nanos(START.as_nanos() + i64::from(self.time())), Microstep(self.microstep().into()))
    }

    const fn bit(self) -> u16 {
        1 << self.0
    }
}

impl std::fmt::Debug for SmallTag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.time(), self.microstep())
    }
}

/// A tag in readable form: relative to the start.
#[derive(Clone, Copy)]
pub(crate) struct Short(pub(crate) Tag);

impl std::fmt::Debug for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Tag::NEVER => f.write_str("NEVER"),
            Tag::FOREVER => f.write_str("FOREVER"),
            Tag { time, microstep: Microstep(u32::MAX) } => write!(f, "({}, MAX)", time.as_nanos() - START.as_nanos()),
            Tag { time, microstep } => write!(f, "({}, {})", time.as_nanos() - START.as_nanos(), microstep.0),
        }
    }
}

/// A set of tags.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(crate) struct SmallTags(u16);

impl SmallTags {
    pub(crate) fn insert(&mut self, tag: SmallTag) {
        self.0 |= tag.bit();
    }

    /// Removes a tag, and returns whether it was in the set.
    pub(crate) fn remove(&mut self, tag: SmallTag) -> bool {
        let there = self.0 & tag.bit() != 0;
        self.0 &= !tag.bit();
        there
    }

    pub(crate) fn contains(self, tag: SmallTag) -> bool {
        self.0 & tag.bit() != 0
    }

    pub(crate) fn first(self) -> Option<SmallTag> {
        (self.0 != 0).then(|| SmallTag(u8::try_from(self.0.trailing_zeros()).unwrap_or(u8::MAX)))
    }
}

impl std::fmt::Debug for SmallTags {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries((0..16).map(SmallTag).filter(|tag| self.0 & tag.bit() != 0)).finish()
    }
}

/// Returns the tag to announce for a next event; FOREVER without one, because NEVER would mean unknown.
pub(crate) fn next_tag(next: Option<SmallTag>) -> Tag {
    next.map_or(Tag::FOREVER, SmallTag::tag)
}
