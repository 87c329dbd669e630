// SPDX-License-Identifier: Apache-2.0
//! Raw superdense time in its form on the wire.

use core::fmt;

use lf_texts::say;

/// A tag on the wire: a time and a microstep, without any arithmetic. Ordered by time, then microstep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tag {
    /// Time in nanoseconds since 1970 by the clock of the federation.
    pub time: i64,
    /// Position within that time.
    pub microstep: u32,
}

impl Tag {
    /// Before every tag that can happen: (`i64::MIN`, 0).
    pub const NEVER: Self = Self { time: i64::MIN, microstep: 0 };
    /// After every tag that can happen: (`i64::MAX`, `u32::MAX`).
    pub const FOREVER: Self = Self { time: i64::MAX, microstep: u32::MAX };
    /// Bytes of a tag on the wire.
    pub const BYTES: usize = 12;

    /// Returns the tag at `time` nanoseconds and `microstep`.
    pub const fn new(time: i64, microstep: u32) -> Self {
        Self { time, microstep }
    }
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NEVER => say!(f, "NEVER"),
            Self::FOREVER => say!(f, "FOREVER"),
            Self { time, microstep } => say!(f, "({time}, {microstep})"),
        }
    }
}
