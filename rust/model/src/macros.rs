// SPDX-License-Identifier: Apache-2.0
//! The macros of reaction bodies, for times and tags with LF's units.

/// A [`Duration`](core::time::Duration) in LF's notation: `delay!(10 ms)`, `delay!((n * 2) usec)`, `delay!(0)`.
///
/// The amount is an integer literal, a variable, or an expression in parentheses, of any integer type. A negative one
/// is zero.
#[macro_export]
macro_rules! delay {
    (0) => {
        ::core::time::Duration::ZERO
    };
    ($amount:tt $unit:ident) => {
        $crate::__private::duration($amount as i64, $crate::__unit_ns!($unit))
    };
}

/// An [`Offset`](crate::Offset) for `schedule` in LF's notation: `after!(10 ms)`.
#[macro_export]
macro_rules! after {
    ($($time:tt)+) => {
        $crate::Offset::After($crate::delay!($($time)+))
    };
}

/// An [`EventTag`](crate::EventTag): `tag!(T0)`, `tag!(T0, 3)`, `tag!(T0 + 10 ms)`, `tag!(T0 + (2 * n) ms, 3)`.
#[macro_export]
macro_rules! tag {
    (T0) => {
        $crate::tag!(T0, 0)
    };
    (T0, $microstep:expr) => {
        $crate::EventTag::new(::core::time::Duration::ZERO, $microstep)
    };
    (T0 + $amount:tt $unit:ident) => {
        $crate::tag!(T0 + $amount $unit, 0)
    };
    (T0 + $amount:tt $unit:ident, $microstep:expr) => {
        $crate::EventTag::new($crate::delay!($amount $unit), $microstep)
    };
}

/// Asserts the current tag of a context: `assert_tag_is!(ctx, T0 + 10 ms)`, `assert_tag_is!(ctx, (T0 + 10 ms, 1))`.
#[macro_export]
macro_rules! assert_tag_is {
    ($ctx:expr, ($($tag:tt)+)) => {
        ::core::assert_eq!($ctx.get_tag(), $crate::tag!($($tag)+))
    };
    ($ctx:expr, $($tag:tt)+) => {
        ::core::assert_eq!($ctx.get_tag(), $crate::tag!($($tag)+))
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __unit_ns {
    (nsec) => {
        1
    };
    (ns) => {
        1
    };
    (nsecs) => {
        1
    };
    (usec) => {
        1_000
    };
    (us) => {
        1_000
    };
    (usecs) => {
        1_000
    };
    (msec) => {
        1_000_000
    };
    (ms) => {
        1_000_000
    };
    (msecs) => {
        1_000_000
    };
    (sec) => {
        1_000_000_000
    };
    (s) => {
        1_000_000_000
    };
    (secs) => {
        1_000_000_000
    };
    (second) => {
        1_000_000_000
    };
    (seconds) => {
        1_000_000_000
    };
    (minute) => {
        60_000_000_000
    };
    (min) => {
        60_000_000_000
    };
    (mins) => {
        60_000_000_000
    };
    (minutes) => {
        60_000_000_000
    };
    (hour) => {
        3_600_000_000_000
    };
    (h) => {
        3_600_000_000_000
    };
    (hours) => {
        3_600_000_000_000
    };
    (day) => {
        86_400_000_000_000
    };
    (d) => {
        86_400_000_000_000
    };
    (days) => {
        86_400_000_000_000
    };
    (week) => {
        604_800_000_000_000
    };
    (wk) => {
        604_800_000_000_000
    };
    (weeks) => {
        604_800_000_000_000
    };
    ($other:ident) => {
        ::core::compile_error!(::core::concat!(
            "`",
            ::core::stringify!($other),
            "` is not a unit of time; use ns, us, ms, s, min, h, d, week or one of LF's longer spellings"
        ))
    };
}

/// What the macros expand to; not for use by hand.
#[doc(hidden)]
pub mod __private {
    use core::time::Duration;

    /// `amount` units of `unit_ns` nanoseconds.
    pub const fn duration(amount: i64, unit_ns: i64) -> Duration {
        crate::Interval(amount.saturating_mul(unit_ns)).to_duration()
    }
}
