// SPDX-License-Identifier: Apache-2.0
//! Superdense time: instants, intervals and tags, in integer nanoseconds.
//!
//! Reaction bodies see durations as [`core::time::Duration`], LF's `time`; everything inside the model, on the wire
//! and in the plan counts in signed 64-bit nanoseconds, and saturates at both ends instead of wrapping.
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, AddAssign, Sub};
use core::time::Duration;

use lf_derive::outlined;
use lf_texts::say;

const NS_PER_SEC: i64 = 1_000_000_000;

/// A number of nanoseconds in memory.
///
/// On processors with 32-bit registers it is two halves with their alignment. A tag is then three words, which the
/// compiler passes by address. With a number of 64 bits in it, it would pass the words, and an RTI's flash was 3 %
/// larger.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
struct Nanos {
    #[cfg(target_pointer_width = "32")]
    low: u32,
    #[cfg(target_pointer_width = "32")]
    high: u32,
    #[cfg(not(target_pointer_width = "32"))]
    number: i64,
}

#[cfg(target_pointer_width = "32")]
const _: () = assert!(size_of::<Tag>() == 12, "a tag is three words");

#[cfg(target_pointer_width = "32")]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the halves are cut off")]
impl Nanos {
    const fn new(number: i64) -> Self {
        Self { low: number as u32, high: (number >> 32) as u32 }
    }

    const fn get(self) -> i64 {
        ((self.high as u64) << 32 | self.low as u64).cast_signed()
    }
}

#[cfg(not(target_pointer_width = "32"))]
impl Nanos {
    const fn new(number: i64) -> Self {
        Self { number }
    }

    const fn get(self) -> i64 {
        self.number
    }
}

impl fmt::Debug for Nanos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl Ord for Nanos {
    fn cmp(&self, other: &Self) -> Ordering {
        self.get().cmp(&other.get())
    }
}

impl PartialOrd for Nanos {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A length of time in nanoseconds. Arithmetic on it saturates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
// Aligned as two halves are, which saves what would be left free beside it; as two halves it would take more flash.
#[cfg_attr(target_pointer_width = "32", repr(Rust, packed(4)))]
pub struct Interval(i64);

impl Interval {
    /// No time at all.
    pub const ZERO: Self = Self::from_nanos(0);
    /// Longer than any other interval.
    pub const FOREVER: Self = Self::from_nanos(i64::MAX);

    /// Returns an interval of `n` nanoseconds.
    pub const fn from_nanos(n: i64) -> Self {
        Self(n)
    }

    /// Returns an interval of `n` microseconds.
    pub const fn from_micros(n: i64) -> Self {
        Self::from_nanos(n.saturating_mul(1_000))
    }

    /// Returns an interval of `n` milliseconds.
    pub const fn from_millis(n: i64) -> Self {
        Self::from_nanos(n.saturating_mul(1_000_000))
    }

    /// Returns an interval of `n` seconds.
    pub const fn from_secs(n: i64) -> Self {
        Self::from_nanos(n.saturating_mul(NS_PER_SEC))
    }

    /// Converts a [`Duration`], cut at 292 years.
    pub const fn from_duration(duration: Duration) -> Self {
        let secs = duration.as_secs();
        if secs >= (i64::MAX / NS_PER_SEC) as u64 {
            return Self::FOREVER;
        }
        // Both casts are exact: the seconds were just compared, and the rest is below one second.
        #[allow(clippy::cast_possible_wrap)]
        Self::from_nanos(secs as i64 * NS_PER_SEC + duration.subsec_nanos() as i64)
    }

    /// Converts to a [`Duration`]; a negative interval becomes zero.
    pub const fn to_duration(self) -> Duration {
        let nanos = self.as_nanos();
        Duration::from_nanos(if nanos < 0 { 0 } else { nanos.unsigned_abs() })
    }

    /// Returns the length in nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// Returns the sum, limited to the range of intervals.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self::from_nanos(self.as_nanos().saturating_add(other.as_nanos()))
    }
}

impl From<Duration> for Interval {
    fn from(duration: Duration) -> Self {
        Self::from_duration(duration)
    }
}

/// A point in time, in nanoseconds since the epoch of the federation's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instant(Nanos);

impl Instant {
    /// Earlier than any other instant.
    pub const NEVER: Self = Self::from_nanos(i64::MIN);
    /// Later than any other instant.
    pub const FOREVER: Self = Self::from_nanos(i64::MAX);

    /// Returns the instant `ns` nanoseconds after the epoch.
    pub const fn from_nanos(ns: i64) -> Self {
        Self(Nanos::new(ns))
    }

    /// Returns the nanoseconds since the epoch.
    pub const fn as_nanos(self) -> i64 {
        self.0.get()
    }

    /// Returns this instant plus `interval`, limited to the range of instants. NEVER and FOREVER stay unchanged.
    #[must_use]
    #[outlined]
    pub const fn saturating_add(self, interval: Interval) -> Self {
        match self {
            Self::NEVER | Self::FOREVER => self,
            _ => Self::from_nanos(self.as_nanos().saturating_add(interval.as_nanos())),
        }
    }

    /// Returns the interval from `earlier` to this instant; negative when `earlier` is later.
    #[outlined]
    pub const fn since(self, earlier: Self) -> Interval {
        Interval::from_nanos(self.as_nanos().saturating_sub(earlier.as_nanos()))
    }

    /// Returns the time from `earlier` to this instant; zero when `earlier` is later.
    pub const fn duration_since(self, earlier: Self) -> Duration {
        self.since(earlier).to_duration()
    }
}

impl Add<Interval> for Instant {
    type Output = Self;
    fn add(self, interval: Interval) -> Self {
        self.saturating_add(interval)
    }
}

impl Add<Duration> for Instant {
    type Output = Self;
    fn add(self, duration: Duration) -> Self {
        self.saturating_add(Interval::from_duration(duration))
    }
}

impl AddAssign<Duration> for Instant {
    fn add_assign(&mut self, duration: Duration) {
        *self = *self + duration;
    }
}

impl Sub for Instant {
    type Output = Duration;
    /// Returns the time between, like `std::time::Instant`: zero when `earlier` is later.
    fn sub(self, earlier: Self) -> Duration {
        self.duration_since(earlier)
    }
}

impl Sub<Interval> for Instant {
    type Output = Self;
    fn sub(self, interval: Interval) -> Self {
        match self {
            Self::NEVER | Self::FOREVER => self,
            _ => Self::from_nanos(self.as_nanos().saturating_sub(interval.as_nanos())),
        }
    }
}

impl Sub<Duration> for Instant {
    type Output = Self;
    fn sub(self, duration: Duration) -> Self {
        self - Interval::from_duration(duration)
    }
}

/// The step within one instant. Steps that differ in their microstep only are apart in logic, not in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Microstep(pub u32);

impl Microstep {
    /// The last step that an instant can have.
    pub const MAX: Self = Self(u32::MAX);
}

impl fmt::Display for Microstep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A point in superdense time: an instant and a microstep, ordered by the instant first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tag {
    /// The instant.
    pub time: Instant,
    /// The step within the instant.
    pub microstep: Microstep,
}

impl Tag {
    /// Before every tag that a program can reach; on the wire (`i64::MIN`, 0).
    pub const NEVER: Self = Self { time: Instant::NEVER, microstep: Microstep(0) };
    /// After every tag that a program can reach; on the wire (`i64::MAX`, `u32::MAX`).
    pub const FOREVER: Self = Self { time: Instant::FOREVER, microstep: Microstep::MAX };

    /// Returns the tag at `time` and `microstep`.
    pub const fn new(time: Instant, microstep: Microstep) -> Self {
        Self { time, microstep }
    }

    /// Returns the first tag at `time`; that of [`Instant::FOREVER`] is FOREVER.
    #[outlined]
    pub const fn at(time: Instant) -> Self {
        match time {
            Instant::FOREVER => Self::FOREVER,
            time => Self { time, microstep: Microstep(0) },
        }
    }

    /// Returns the smallest tag that is greater. FOREVER stays unchanged.
    #[must_use]
    #[outlined]
    pub const fn next_microstep(self) -> Self {
        match (self.microstep.0.checked_add(1), self.time) {
            (Some(microstep), time) => Self { time, microstep: Microstep(microstep) },
            (None, Instant::FOREVER) => Self::FOREVER,
            (None, time) => Self::at(Instant::from_nanos(time.as_nanos() + 1)),
        }
    }

    /// Returns the tag whose distance from `to` is that of this one from `from`: in nanoseconds, and at that instant
    /// itself in microsteps. NEVER and FOREVER stay unchanged.
    #[must_use]
    pub(crate) fn moved(self, from: Self, to: Self) -> Self {
        let microsteps = |steps: Microstep| to.microstep.0.saturating_add(steps.0).saturating_sub(from.microstep.0);
        let microstep = if self.time == from.time { Microstep(microsteps(self.microstep)) } else { self.microstep };
        if self.is_finite() { Self { time: to.time + self.time.since(from.time), microstep } } else { self }
    }

    /// Returns whether a program can reach this tag: its time is neither NEVER nor FOREVER.
    pub const fn is_finite(self) -> bool {
        !matches!(self.time, Instant::NEVER | Instant::FOREVER)
    }

    /// Returns the greatest tag that is smaller: the last microstep of the nanosecond before, if there is none in this
    /// one.
    #[must_use]
    #[outlined]
    pub const fn before(self) -> Self {
        match (self.microstep.0.checked_sub(1), self.time) {
            (Some(microstep), time) => Self { time, microstep: Microstep(microstep) },
            (None, Instant::NEVER) => self,
            (None, time) => Self { time: Instant::from_nanos(time.as_nanos() - 1), microstep: Microstep::MAX },
        }
    }

    /// Returns the tag after a delay of `interval`: a delay of zero is one microstep, any other leads to microstep 0.
    /// NEVER and FOREVER stay unchanged.
    #[must_use]
    #[outlined]
    pub const fn after(self, interval: Interval) -> Self {
        match (self.time, interval.as_nanos()) {
            (Instant::NEVER | Instant::FOREVER, _) => self,
            (_, i64::MIN..=0) => self.next_microstep(),
            (time, _) => Self::at(time.saturating_add(interval)),
        }
    }

    /// Returns the tag at the other end of a connection: the same one without `after` (`None`), else
    /// [`after`](Self::after) it.
    #[must_use]
    pub const fn delayed(self, after: Option<Interval>) -> Self {
        match after {
            None => self,
            Some(interval) => self.after(interval),
        }
    }
}

impl Ord for Tag {
    #[outlined]
    fn cmp(&self, other: &Self) -> Ordering {
        self.time.cmp(&other.time).then(self.microstep.cmp(&other.microstep))
    }
}

impl PartialOrd for Tag {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for Tag {
    /// Writes `(nanoseconds since the epoch, microstep)`, or `NEVER` or `FOREVER`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NEVER => say!(f, "NEVER"),
            Self::FOREVER => say!(f, "FOREVER"),
            Self { time, microstep } => say!(f, "({} ns, {microstep})", time.as_nanos()),
        }
    }
}

/// The current tag as reaction bodies see it: relative to the start of the program.
///
/// It is written `(T0 + 40000000 ns = 40 ms, 0)`, and can be compared with the tags of [`tag!`](crate::tag).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EventTag {
    /// The logical time since the start.
    pub offset_from_t0: Duration,
    /// The step within that time.
    pub microstep: u32,
}

impl EventTag {
    /// Returns the tag at an offset from the start.
    pub const fn new(offset_from_t0: Duration, microstep: u32) -> Self {
        Self { offset_from_t0, microstep }
    }

    /// Returns `tag` as seen from a program that started at `start`.
    pub const fn relative(tag: Tag, start: Instant) -> Self {
        Self { offset_from_t0: tag.time.duration_since(start), microstep: tag.microstep.0 }
    }
}

impl fmt::Display for EventTag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Counted in 64 bits, because 128-bit division is large code on small processors.
        let ns = Interval::from_duration(self.offset_from_t0).as_nanos();
        say!(f, "(T0 + {ns} ns = {} ms, {})", ns / 1_000_000, self.microstep)
    }
}

/// The offset of a scheduled event, in addition to the action's minimum delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Offset {
    /// As soon as possible.
    #[default]
    Asap,
    /// This much later.
    After(Duration),
}

impl Offset {
    /// Returns the additional delay.
    pub const fn to_interval(self) -> Interval {
        match self {
            Self::Asap => Interval::ZERO,
            Self::After(duration) => Interval::from_duration(duration),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_tag_keeps_its_distance() {
        let tag = |ns, microstep| Tag::new(Instant::from_nanos(ns), Microstep(microstep));
        assert_eq!(tag(7, 5).moved(tag(7, 2), tag(20, 4)), tag(20, 7), "in microsteps at one instant");
        assert_eq!(tag(9, 5).moved(tag(7, 2), tag(20, 4)), tag(22, 5), "in nanoseconds otherwise");
        for endless in [Tag::NEVER, Tag::FOREVER] {
            assert_eq!(endless.moved(tag(7, 2), tag(20, 4)), endless);
        }
    }
}
