// SPDX-License-Identifier: Apache-2.0
//! Clocks that are far from what they should be: those of boards whose frequency is configured wrong, and of simulated
//! ones, which lose time as often as they are interrupted. Synchronization holds them as far as there are exchanges, or
//! says what is wrong.

use std::fmt::Write;

use lf_coordination::clock_sync::{ClockCorrection, ClockFault, DRIFT_PPB_MAX, Exchange, Line, Round, Tracker};
use lf_model::time::{Instant, Interval};
use lf_testkit::random::Random;
use proptest::prelude::*;

const US: i64 = 1_000;
const MS: i64 = 1_000_000;
const SEC: i64 = 1_000_000_000;
/// The time for which each clock is observed.
const LASTS: i64 = 120;
/// The default attenuation of federates.
const ATTENUATION: u16 = 10;

/// A federate and its way to the RTI.
#[derive(Clone, Copy, Debug)]
struct Board {
    /// The drift of its clock in a second, in ns.
    gains: i64,
    /// The maximum change of that in a second, in ns.
    wanders: i64,
    /// Time between two exchanges.
    period: i64,
    /// The maximum difference between the times that two messages take.
    jitter: i64,
    /// Whether one message of twenty is held up by up to 20 ms, as on a busy computer.
    is_busy: bool,
    seed: u64,
}

/// The outcome.
struct Watched {
    tracker: Tracker,
    /// When, and how far federation time was off then.
    errors: Vec<(i64, i64)>,
    /// The line after each exchange.
    lines: Vec<Option<Line>>,
}

impl Board {
    /// Returns the time of the federate's clock at the beginning of each second.
    fn seconds(&self, random: &mut Random) -> Vec<i64> {
        let (mut shows, mut more) = (7 * SEC, 0);
        (0..LASTS + 2)
            .map(|_| {
                let now = shows;
                more = (more + random.time(-self.wanders, self.wanders)).clamp(-self.wanders, self.wanders);
                shows += SEC + self.gains + more;
                now
            })
            .collect()
    }

    fn delay(&self, random: &mut Random) -> i64 {
        let held_up = if self.is_busy && random.below(20) == 0 { random.time(0, 20 * MS) } else { 0 };
        150 * US + random.time(0, self.jitter) + held_up
    }

    /// Synchronizes it.
    fn watch(&self) -> Watched {
        let mut random = Random::new(self.seed);
        let seconds = self.seconds(&mut random);
        let own = |time: i64| {
            let (second, rest) = (usize::try_from(time / SEC).unwrap_or(0), time % SEC);
            Instant::from_nanos(seconds[second] + (seconds[second + 1] - seconds[second]) * rest / SEC)
        };
        let mut tracker = Tracker::new();
        let mut clock = ClockCorrection::with_offset(Interval::from_nanos(-own(0).as_nanos()));
        let (mut errors, mut lines) = (Vec::new(), Vec::new());
        for round in 0..LASTS * SEC / self.period {
            let t1 = round * self.period;
            let t2 = t1 + self.delay(&mut random);
            let t3 = t2 + 50 * US;
            let t4 = t3 + self.delay(&mut random);
            let now = t4 + self.delay(&mut random);
            errors.push((now, clock.physical(own(now)).as_nanos() - now));
            let exchange =
                Exchange { t1: Instant::from_nanos(t1), t2: own(t2), t3: own(t3), t4: Instant::from_nanos(t4) };
            tracker.record(Round { exchange, gap: (random.below(2) == 0).then_some(Interval::from_nanos(0)) });
            if let Some(line) = tracker.line() {
                clock.steer(own(now), &line, ATTENUATION);
            }
            lines.push(tracker.line());
        }
        Watched { tracker, errors, lines }
    }
}

impl Watched {
    /// Returns the largest error from this second on.
    fn worst_from(&self, second: i64) -> i64 {
        let later = self.errors.iter().filter(|(at, _)| *at >= second * SEC);
        later.map(|(_, error)| error.abs()).max().unwrap_or(0)
    }
}

fn periods() -> impl Strategy<Value = i64> {
    prop_oneof![Just(5 * MS), Just(20 * MS), Just(100 * MS), Just(500 * MS)]
}

proptest! {
    // Each case is up to 24,000 exchanges.
    #![proptest_config(ProptestConfig { cases: 32, max_shrink_iters: 50, ..ProptestConfig::default() })]

    /// Until two exchanges are far enough apart, they cannot prove the drift; from then on it makes no error.
    #[test]
    fn a_clock_with_any_drift_is_held(
        gains in -80 * MS..90 * MS,
        period in periods(),
        jitter in US..2 * MS,
        is_busy in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let watched = Board { gains, wanders: 0, period, jitter, is_busy, seed }.watch();
        let unknown = (gains.abs() * (2 * period / US + SEC / 2 / US)) / (SEC / US);
        let at_first = unknown + 10 * jitter + if is_busy { 20 * MS } else { MS };
        prop_assert!(watched.worst_from(0) <= at_first, "off by {} ns at first", watched.worst_from(0));
        let held = 50 * US + jitter / 2;
        prop_assert!(watched.worst_from(60) <= held, "off by {} ns after a minute", watched.worst_from(60));
        let (seen, unused, _) = watched.tracker.counts();
        prop_assert!(unused * 20 <= seen, "{unused} of {seen} of no use");
        let is_large = gains.abs() > 12 * MS;
        let told = watched.tracker.fault();
        prop_assert!(matches!(told, Some(ClockFault::Drift(_))) == is_large || gains.abs() > 8 * MS, "{told:?}");
    }

    /// A rate that changes all the time is followed within a few exchanges.
    #[test]
    fn a_clock_that_wanders_is_followed(
        gains in -50 * MS..50 * MS,
        wanders in 10 * US..3 * MS,
        period in periods(),
        jitter in US..2 * MS,
        is_busy in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let watched = Board { gains, wanders, period, jitter, is_busy, seed }.watch();
        let bound = wanders * (6 * period + 3 * SEC) / SEC + 10 * jitter + if is_busy { 20 * MS } else { MS };
        prop_assert!(watched.worst_from(20) <= bound, "off by {} ns", watched.worst_from(20));
    }

    /// A drift that is too large is logged, with the number.
    #[test]
    fn a_drift_that_is_too_large_is_told(
        gains in prop_oneof![-450 * MS..-150 * MS, 150 * MS..900 * MS],
        period in periods(),
        jitter in US..2 * MS,
        seed in any::<u64>(),
    ) {
        let watched = Board { gains, wanders: 0, period, jitter, is_busy: false, seed }.watch();
        let expected = -gains * SEC / (SEC + gains);
        let told = watched.tracker.fault();
        let Some(ClockFault::Drift(found)) = told else { return Err(TestCaseError::fail(format!("{told:?}"))) };
        prop_assert!((i64::from(found) - expected).abs() < 2 * MS, "{found}, but it is {expected}");
        prop_assert!(found.abs() > DRIFT_PPB_MAX);
    }

    /// A board with a quartz has no fault, on whatever network.
    #[test]
    fn a_quartz_has_no_fault(
        gains in -100 * US..100 * US,
        period in periods(),
        jitter in US..5 * MS,
        is_busy in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let watched = Board { gains, wanders: 0, period, jitter, is_busy, seed }.watch();
        prop_assert_eq!(watched.tracker.fault(), None);
    }
}

/// The line that the tracker finds for a few clocks, after ever more exchanges. The properties hold for a worse
/// tracker, too; this shows that a change of it has an effect, and which.
#[test]
fn what_is_learnt_changes_on_purpose_only() {
    let quartz = Board { gains: 26 * US, wanders: 0, period: 20 * MS, jitter: 30 * US, is_busy: false, seed: 1 };
    let boards = [
        ("a quartz, quiet", quartz),
        ("a quartz, asked often", Board { period: 5 * MS, jitter: 4 * MS, ..quartz }),
        ("a quartz, asked rarely", Board { period: 500 * MS, jitter: 4 * MS, ..quartz }),
        ("a busy computer", Board { jitter: 300 * US, is_busy: true, ..quartz }),
        ("a wrong frequency", Board { gains: -40 * MS, period: 100 * MS, is_busy: true, ..quartz }),
        ("a rate that wanders", Board { gains: 5 * MS, wanders: 3 * MS, ..quartz }),
        ("a rate that wanders a little", Board { wanders: 40 * US, jitter: MS, period: 100 * MS, ..quartz }),
    ];
    let mut table = String::new();
    for (name, board) in boards {
        let watched = board.watch();
        let (seen, unused, pure) = watched.tracker.counts();
        let fault = watched.tracker.fault();
        writeln!(table, "{name}: {unused} of {seen} unused, {pure} pure, {fault:?}").unwrap();
        writeln!(table, "{:>9} {:>12} {:>12} {:>12}", "exchanges", "error, ns", "drift, ppb", "width, ns").unwrap();
        let lines = watched.lines.iter().zip(&watched.errors).zip(1_usize..);
        for ((line, (_, error)), count) in lines.filter(|(_, count)| count.is_power_of_two() || count % 4_000 == 0) {
            let Line { drift_ppb, width, .. } = line.unwrap();
            writeln!(table, "{count:>9} {error:>12} {drift_ppb:>12} {:>12}", width.as_nanos()).unwrap();
        }
    }
    insta::assert_snapshot!(table);
}

/// An exchange that says that there are centuries between the clocks spoils nothing for good.
#[test]
fn an_absurd_beginning_is_forgotten() {
    let mut tracker = Tracker::new();
    let own = SEC * SEC;
    let absurd = Exchange {
        t1: Instant::from_nanos(i64::MAX),
        t2: Instant::from_nanos(own),
        t3: Instant::from_nanos(own),
        t4: Instant::from_nanos(i64::MAX),
    };
    tracker.record(Round { exchange: absurd, gap: Some(Interval::from_nanos(0)) });
    for round in 1..1_000 {
        let (rti, own) = (Instant::from_nanos(round * 5 * MS), Instant::from_nanos(own + round * 5 * MS));
        tracker.record(Round {
            exchange: Exchange { t1: rti, t2: own, t3: own, t4: rti },
            gap: Some(Interval::from_nanos(0)),
        });
    }
    let found = tracker.line().map(|line| line.offset_at(Instant::from_nanos(own)));
    assert_eq!(found, Some(Interval::from_nanos(-own)));
}

/// Each kind of fault is a sentence that says what is to be done.
#[test]
fn faults_are_described_in_words() {
    let all = [
        ClockFault::Drift(-40_000_000),
        ClockFault::Drift(230_769_000),
        ClockFault::Unsteady(Interval::from_nanos(12_345_678)),
    ];
    assert_eq!(
        all.map(|fault| fault.to_string()),
        [
            "the own clock gains 40000 us in a second, more than any oscillator; it is corrected as long as this \
             federate runs: check the frequency that it is configured with (CONFIG_SYS_CLOCK_HW_CYCLES_PER_SEC)",
            "the own clock loses 230769 us in a second, more than can be corrected, so times of this federate are \
             wrong: check the frequency that it is configured with (CONFIG_SYS_CLOCK_HW_CYCLES_PER_SEC)",
            "the rate of the own clock changes so quickly that times were off by 12345 us, as on a simulated board \
             whose computer is busy: give that less to do, or compare clocks more often (the `period` of \
             clock-sync-options)",
        ]
    );
}
