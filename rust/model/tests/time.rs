// SPDX-License-Identifier: Apache-2.0
//! Superdense time: its order, its ends, and LF's notation for it.
use lf_model::prelude::*;
use lf_model::{Interval, Microstep, Tag};
use proptest::prelude::*;

fn any_tag() -> impl Strategy<Value = Tag> {
    (any::<i64>(), any::<u32>()).prop_map(|(time, microstep)| Tag::new(Instant::from_nanos(time), Microstep(microstep)))
}

proptest! {
    #[test]
    fn the_next_microstep_and_the_tag_before_are_neighbours(tag in any_tag()) {
        prop_assert!(tag.next_microstep() > tag);
        prop_assert_eq!(tag.next_microstep().before(), tag);
        prop_assert!(tag.before() < tag);
        prop_assert_eq!(tag.before().next_microstep(), tag);
    }

    #[test]
    fn a_delay_leads_to_a_later_tag_or_for_ever(tag in any_tag(), delay in 0..=i64::MAX) {
        let later = tag.after(Interval::from_nanos(delay));
        prop_assert!(later > tag || later == Tag::FOREVER);
        prop_assert_eq!(tag.delayed(Some(Interval::from_nanos(delay))), later);
        prop_assert_eq!(tag.delayed(None), tag);
        if delay > 0 && later != Tag::FOREVER {
            prop_assert_eq!(later, Tag::at(tag.time + Interval::from_nanos(delay)));
        }
    }

    #[test]
    fn durations_and_intervals_agree_within_292_years(
        ns in 0..=i64::MAX,
        secs in 0..20_000_000_000_u64,
        nanos in 0..1_000_000_000u32,
    ) {
        let last_second = ns / 1_000_000_000 == i64::MAX / 1_000_000_000;
        let expected = if last_second { Interval::FOREVER } else { Interval::from_nanos(ns) };
        prop_assert_eq!(Interval::from_duration(Interval::from_nanos(ns).to_duration()), expected);
        let duration = Duration::new(secs, nanos);
        let exact = i64::try_from(duration.as_nanos()).ok().filter(|_| secs < 9_223_372_036);
        prop_assert_eq!(Interval::from(duration), exact.map_or(Interval::FOREVER, Interval::from_nanos));
        let there_and_back = if exact.is_some() { Instant::from_nanos(0) } else { Instant::FOREVER };
        prop_assert_eq!(Instant::from_nanos(0) + duration - duration, there_and_back);
        let (mut advanced, first) = (Instant::from_nanos(0), Instant::from_nanos(0));
        advanced += duration;
        prop_assert_eq!(advanced, first + duration);
        prop_assert_eq!(first - duration, first - Interval::from(duration));
    }

    #[test]
    fn instants_saturate(time: i64, other: i64) {
        let (time, other) = (Instant::from_nanos(time), Instant::from_nanos(other));
        prop_assert_eq!((time - other).is_zero(), time <= other, "{:?}", time - other);
        prop_assert!(time.since(other).as_nanos() > 0 || time <= other);
    }
}

#[test]
fn never_and_forever_stay_what_they_are() {
    for end in [Tag::NEVER, Tag::FOREVER] {
        assert_eq!(end.after(Interval::from_secs(1)), end);
        assert_eq!(end.after(Interval::ZERO), end);
        assert!(!end.is_finite());
    }
    assert_eq!(Tag::FOREVER.next_microstep(), Tag::FOREVER);
    assert_eq!(Tag::NEVER.before(), Tag::NEVER);
    assert_eq!(Tag::at(Instant::from_nanos(5)).after(Interval::FOREVER), Tag::FOREVER);
    assert_eq!(Instant::FOREVER - Interval::from_nanos(1), Instant::FOREVER);
    assert_eq!(Instant::NEVER + delay!(1 s), Instant::NEVER);
}

#[test]
fn intervals_of_all_units_saturate() {
    for (of, ns) in [(Interval::from_micros as fn(i64) -> _, 1_000), (Interval::from_millis, 1_000_000)] {
        assert_eq!((of(3), of(i64::MAX)), (Interval::from_nanos(3 * ns), Interval::FOREVER));
    }
    assert_eq!(Interval::from_secs(-3), Interval::from_nanos(-3_000_000_000));
}

#[test]
fn a_time_that_is_none_is_refused_by_what_is_wrong_with_it() {
    let refusal = |amount, unit| lf_model::units::nanoseconds(amount, unit).unwrap_err().to_string();
    assert_eq!(refusal("x", "ms"), "`x` is no number; write a time like `1.5 s`");
    assert_eq!(refusal("1", "m"), "`m` is no unit of time; try ns, us, ms, s, min, h, d or wk");
    assert_eq!(refusal("99999", "weeks"), "`99999 weeks` is longer than 292 years");
}

#[test]
fn the_strict_predecessor_borrows_a_nanosecond() {
    let tag = |time, microstep| Tag::new(Instant::from_nanos(time), Microstep(microstep));
    assert_eq!(tag(5, 0).before(), tag(4, u32::MAX));
    assert_eq!(tag(4, u32::MAX).next_microstep(), tag(5, 0));
}

#[test]
fn all_spellings_of_units_are_understood() {
    macro_rules! spellings {
        ($($ns:literal: $($unit:ident)+;)+) => {$($(
            assert_eq!(delay!(3 $unit), Duration::from_nanos(3 * $ns), stringify!($unit));
        )+)+};
    }
    spellings! {
        1: nsec ns nsecs;
        1_000: usec us usecs;
        1_000_000: msec ms msecs;
        1_000_000_000: sec s secs second seconds;
        60_000_000_000: minute min mins minutes;
        3_600_000_000_000: hour h hours;
        86_400_000_000_000: day d days;
        604_800_000_000_000: week wk weeks;
    }
    assert_eq!(delay!(0), Duration::ZERO);
}

#[test]
fn amounts_are_literals_variables_or_expressions_of_any_integer_type() {
    const PERIOD: Duration = delay!(25 msec);
    let (signed, unsigned, long) = (4i32, 2u8, 3u64);
    assert_eq!(delay!(signed ms), Duration::from_millis(4));
    assert_eq!(delay!((40 * long) ms), Duration::from_millis(120));
    assert_eq!(delay!((unsigned + 1) us), Duration::from_micros(3));
    assert_eq!(delay!((signed - 10) ms), Duration::ZERO, "there is no negative delay");
    assert_eq!(after!(10 ms), After(Duration::from_millis(10)));
    assert_eq!(after!(0), After(Duration::ZERO));
    assert_eq!(PERIOD, Duration::from_millis(25));
    assert_eq!(delay!((i64::MAX) weeks).as_secs(), 9_223_372_036, "it saturates");
}

#[test]
fn tags_compare_and_are_written_as_in_the_rust_target() {
    let n = 3u32;
    assert_eq!(tag!(T0), EventTag::new(Duration::ZERO, 0));
    assert_eq!(tag!(T0, n), EventTag::new(Duration::ZERO, 3));
    assert_eq!(tag!(T0 + 10 ms), EventTag::new(Duration::from_millis(10), 0));
    assert_eq!(tag!(T0 + (40 * n) ms, n + 1), EventTag::new(Duration::from_millis(120), 4));
    assert!(tag!(T0 + 10 ms, 8) < tag!(T0 + 10 ms, 9) && tag!(T0 + 10 ms, 9) < tag!(T0 + 11 ms));
    assert_eq!(tag!(T0 + 40 ms, 2).to_string(), "(T0 + 40000000 ns = 40 ms, 2)");
    assert_eq!(EventTag::relative(Tag::at(Instant::from_nanos(7)), Instant::from_nanos(5)), tag!(T0 + 2 ns));
    assert_eq!(Tag::new(Instant::from_nanos(12), Microstep(3)).to_string(), "(12 ns, 3)");
    assert_eq!(format!("{} {}", Tag::NEVER, Tag::FOREVER), "NEVER FOREVER");
}
