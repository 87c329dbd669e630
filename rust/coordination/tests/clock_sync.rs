// SPDX-License-Identifier: Apache-2.0
//! The guarantees of clock synchronization, for any network and any clocks.

use lf_coordination::clock_sync::{ClockCorrection, DRIFT_PPB_MAX, Estimator, Exchange};
use lf_model::time::{Instant, Interval};
use proptest::collection::vec;
use proptest::prelude::*;

/// Returns an exchange that begins at `t1` of the RTI's clock, which is `ahead` of the federate's.
fn exchange(t1: i64, ahead: i64, there: i64, hold: i64, back: i64) -> Exchange {
    let t2 = t1 - ahead + there;
    let t4 = t1 + there + hold + back;
    Exchange {
        t1: Instant::from_nanos(t1),
        t2: Instant::from_nanos(t2),
        t3: Instant::from_nanos(t2 + hold),
        t4: Instant::from_nanos(t4),
    }
}

#[test]
fn a_few_true_exchanges_win_over_many_disturbed_ones() {
    // Jitter of 0 to 4 ms, with which the stock federate discards all it has measured; two exchanges got through.
    let ahead = 1_790_000_000_000_000_000;
    let mut estimator = Estimator::new();
    assert_eq!(estimator.estimate(), None);
    for (index, jitter) in [4_000, 900, 0, 3_100, 2_000, 10, 3_900, 1_500, 2_500, 700].into_iter().enumerate() {
        let t1 = 1_790_000_000_000_000_000 + 10_000_000 * i64::try_from(index).unwrap();
        estimator.record(exchange(t1, ahead, 40_000 + 1_000 * jitter, 5_000, 40_000));
    }
    let estimate = estimator.estimate().unwrap();
    assert_eq!((estimate.used, estimate.seen), (2, 10));
    assert_eq!(estimate.round_trip, Interval::from_nanos(80_000));
    let error = estimate.offset.as_nanos() - ahead;
    assert!((-5_000..=0).contains(&error), "{error}");
}

#[test]
fn an_interruption_after_the_write_does_not_pass_for_a_quick_exchange() {
    let mut estimator = Estimator::new();
    let good = exchange(0, 0, 40_000, 5_000, 40_000);
    let interrupted = Exchange { t3: good.t3 + Interval::from_nanos(60_000), ..good };
    assert!(interrupted.round_trip() < good.round_trip());
    estimator.record(interrupted);
    estimator.record(good);
    assert_eq!(estimator.estimate().unwrap().offset, Interval::from_nanos(0));
}

#[test]
fn an_impossible_exchange_is_used_only_when_there_is_no_other() {
    let good = exchange(0, 7, 1_000_000, 0, 1_000_000);
    let impossible = Exchange { t4: Instant::from_nanos(-5), ..exchange(0, 7, 10, 0, 10) };
    let mut estimator = Estimator::new();
    estimator.record(impossible);
    assert!(estimator.estimate().is_some());
    estimator.record(good);
    assert_eq!(estimator.estimate().unwrap().offset, Interval::from_nanos(7));
}

/// Exchanges count that take up to half as long again as the fastest, which may take no time at all.
#[test]
fn similar_exchanges_are_averaged() {
    let mut estimator = Estimator::new();
    // The sum of what both sides measure is 100, 150 and 152 ns.
    for (there, back) in [(50, 50), (60, 90), (152, 0)] {
        estimator.record(exchange(1_000, 7, there, 0, back));
    }
    let estimate = estimator.estimate().unwrap();
    assert_eq!((estimate.used, estimate.seen), (2, 3));
    assert_eq!(estimate.offset, Interval::from_nanos(7 + 15 / 2));
    assert_eq!(estimate.to_string(), "own clock off by -14 ns, round trip 100 ns, from the best 2 of 3 exchanges");
    estimator.record(exchange(2_000, 9, 0, 0, 0));
    let estimate = estimator.estimate().unwrap();
    assert_eq!((estimate.used, estimate.offset), (1, Interval::from_nanos(9)));
}

#[derive(Clone, Copy, Debug)]
enum Change {
    Slew(i64),
    Drift(i32),
    Read,
}

fn any_change() -> impl Strategy<Value = Change> {
    prop_oneof![
        prop_oneof![-1_000_000..1_000_000i64, any::<i64>()].prop_map(Change::Slew),
        prop_oneof![-100_000..100_000i32, any::<i32>()].prop_map(Change::Drift),
        Just(Change::Read),
    ]
}

fn any_elapsed() -> impl Strategy<Value = i64> {
    prop_oneof![0..100i64, 0..10_000_000_000i64]
}

fn any_error() -> impl Strategy<Value = i64> {
    prop_oneof![-20..20i64, -1_000_000_000..1_000_000_000i64]
}

/// Asserts that a clock with this remaining error and this drift reaches a time that is `ahead` exactly at the
/// predicted one.
fn is_exact(error: i64, drift: i32, ahead: i64) -> Result<(), String> {
    let mut clock = ClockCorrection::with_offset(Interval::from_nanos(1_790_000_000_000_000_000));
    clock.slew(Instant::from_nanos(0), Interval::from_nanos(error));
    clock.set_drift(Instant::from_nanos(0), drift);
    // Before the change of rate, too.
    for target in [ahead, -ahead].map(|ahead| clock.physical(Instant::from_nanos(0)) + Interval::from_nanos(ahead)) {
        let local = clock.local(target);
        let [before, then] = [local + Interval::from_nanos(-1), local].map(|local| clock.physical(local));
        if before >= target || target > then {
            return Err(format!("{target:?} is not between {before:?} and {then:?}"));
        }
    }
    Ok(())
}

#[test]
fn roundings_of_drift_and_slew_do_not_add_up() {
    let assert_exact =
        |error, drift, ahead| assert_eq!(is_exact(error, drift, ahead), Ok(()), "{error} {drift} {ahead}");
    assert_exact(-49_487_626, -46_416_304, 894_324_223);
    assert_exact(-732_180_099, -42_106_208, 13_294_784_598);
    // Both would go one back at once.
    assert_exact(-1_000_000_000, -DRIFT_PPB_MAX, 18);
    // The error comes to be made up for.
    for ahead in 0..100 {
        assert_exact(2, DRIFT_PPB_MAX, ahead);
        assert_exact(-2, DRIFT_PPB_MAX, ahead);
    }
}

proptest! {
    /// The offset is wrong by no more than half of what the exchanges that were used took.
    #[test]
    fn the_estimate_is_as_good_as_the_quickest_exchange(
        ahead in -2_000_000_000_000_000_000..2_000_000_000_000_000_000i64,
        delays in vec((0..5_000_000i64, 0..1_000_000i64, 0..5_000_000i64), 1..30),
    ) {
        let mut estimator = Estimator::new();
        for (there, hold, back) in &delays {
            estimator.record(exchange(0, ahead, *there, *hold, *back));
        }
        let quickest = delays.iter().map(|(there, hold, back)| there + 2 * hold + back).min().unwrap();
        let estimate = estimator.estimate().unwrap();
        let error = (estimate.offset.as_nanos() - ahead).abs();
        prop_assert!(error <= quickest / 4 * 3 + 4, "{error} {quickest}");
        prop_assert!(estimate.used >= 1 && estimate.used <= estimate.seen);
        prop_assert_eq!(usize::from(estimate.seen), delays.len());
    }

    /// Clocks that show anything at all give an estimate, and no panic.
    #[test]
    fn any_instants_are_survived(instants in vec(any::<[i64; 4]>(), 1..20)) {
        let mut estimator = Estimator::new();
        for [t1, t2, t3, t4] in instants {
            let [t1, t2, t3, t4] = [t1, t2, t3, t4].map(Instant::from_nanos);
            estimator.record(Exchange { t1, t2, t3, t4 });
        }
        prop_assert!(estimator.estimate().is_some());
    }

    /// Physical time never runs backwards, whatever was learnt about the clock, and does not stand still for long.
    #[test]
    fn physical_time_never_runs_backwards(
        offset in -2_000_000_000_000_000_000..2_000_000_000_000_000_000i64,
        changes in vec((any_elapsed(), any_change()), 1..60),
    ) {
        let mut clock = ClockCorrection::with_offset(Interval::from_nanos(offset));
        let mut local = Instant::from_nanos(0);
        let mut last = clock.physical(local);
        for (elapsed, change) in changes {
            local = local + Interval::from_nanos(elapsed);
            let physical = clock.physical(local);
            prop_assert!(physical.since(last).as_nanos() >= elapsed * 85 / 100 - 1, "{:?} -> {:?}", last, physical);
            prop_assert!(clock.physical(local + Interval::from_nanos(1)) >= physical, "backwards from {:?}", physical);
            match change {
                Change::Slew(error) => clock.slew(local, Interval::from_nanos(error)),
                Change::Drift(ppb) => clock.set_drift(local, ppb),
                Change::Read => {}
            }
            prop_assert_eq!(clock.physical(local), physical, "a change of rate is no step");
            last = physical;
        }
    }

    /// No wait is longer than necessary, and no thread is woken too early.
    #[test]
    fn a_physical_time_is_reached_at_its_local_time_and_not_before(
        (error, drift) in (any_error(), -DRIFT_PPB_MAX..=DRIFT_PPB_MAX),
        ahead in any_elapsed(),
    ) {
        prop_assert_eq!(is_exact(error, drift, ahead), Ok(()));
    }

    /// An error is made up for in full, and no more.
    #[test]
    fn an_error_is_made_up_for(error in -1_000_000_000..1_000_000_000i64) {
        let mut clock = ClockCorrection::with_offset(Interval::from_nanos(5));
        clock.slew(Instant::from_nanos(100), Interval::from_nanos(error));
        // 20 s per second of error, at 50 ms in a second.
        let later = Instant::from_nanos(100) + Interval::from_nanos(error.abs() * 20 + 100);
        prop_assert_eq!(clock.physical(later), later + Interval::from_nanos(5 + error));
    }
}
