// SPDX-License-Identifier: Apache-2.0
//! The macros of reaction bodies, for times and tags with LF's units.

/// Makes a [`Duration`](core::time::Duration) in LF's notation: `delay!(10 ms)`, `delay!((n * 2) usec)`, `delay!(0)`.
///
/// The amount is an integer literal, a variable, or an expression in parentheses, of any integer type. A negative one
/// is zero. Another unit than LF's does not compile:
///
/// ```compile_fail
/// lf_model::delay!(3 fortnight);
/// ```
#[macro_export]
macro_rules! delay {
    (0) => {
        ::core::time::Duration::ZERO
    };
    ($amount:tt $unit:ident) => {
        $crate::__private::duration($amount as i64, {
            const UNIT_NS: i64 = $crate::__private::unit_ns(
                ::core::stringify!($unit),
                ::core::concat!(
                    "`",
                    ::core::stringify!($unit),
                    "` is not a unit of time; use ns, us, ms, s, min, h, d, wk or one of LF's longer spellings"
                ),
            );
            UNIT_NS
        })
    };
}

/// Makes an [`Offset`](crate::Offset) for `schedule` in LF's notation: `after!(10 ms)`.
#[macro_export]
macro_rules! after {
    ($($time:tt)+) => {
        $crate::Offset::After($crate::delay!($($time)+))
    };
}

/// Makes an [`EventTag`](crate::EventTag): `tag!(T0)`, `tag!(T0, 3)`, `tag!(T0 + 10 ms)`, `tag!(T0 + (2 * n) ms, 3)`.
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

/// The targets of the macros; not for use by hand.
#[doc(hidden)]
pub mod __private {
    use core::time::Duration;

    /// Returns the length of a unit in nanoseconds.
    ///
    /// # Panics
    /// With `otherwise` if there is no such unit; the macros call it in constants, so this is an error of the compiler.
    pub const fn unit_ns(unit: &str, otherwise: &str) -> i64 {
        match crate::units::unit_ns(unit) {
            Some(unit_ns) => unit_ns,
            None => panic!("{}", otherwise),
        }
    }

    /// Returns `amount` units of `unit_ns` nanoseconds.
    pub const fn duration(amount: i64, unit_ns: i64) -> Duration {
        crate::Interval::from_nanos(amount.saturating_mul(unit_ns)).to_duration()
    }
}
