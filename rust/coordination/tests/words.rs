// SPDX-License-Identifier: Apache-2.0
//! The sentences of reports and errors: which number stands where, and which verb fits it.
use std::fmt;

use lf_coordination::clock_sync::{ClockCorrection, ClockFault, DRIFT_PPB_MAX, Line};
use lf_coordination::federate::{Awaited, AwaitedInput, ClockSyncReport, ConfigError, ConnectRetry, before_start};
use lf_coordination::federate::{CONNECT_RETRY, CONNECT_TIME_OUT, ConnectStep};
use lf_coordination::rti::{Cause, ConnectionId, Outcome, RtiEvent, Waits};
use lf_coordination::{FederateId, Times};
use lf_model::time::{EventTag, Instant, Interval, Microstep, Tag};

const ONE: FederateId = FederateId(1);
const TWO: FederateId = FederateId(2);

#[test]
fn a_clock_loses_what_the_rtis_is_faster_by() {
    let report = |drift_ppb| {
        let (at, offset) = (Instant::from_nanos(0), Interval::ZERO);
        let line = Line { at, offset, drift_ppb, width: Interval::from_nanos(1_500) };
        ClockSyncReport { exchanges: 9, unused: 2, calm: 5, line: Some(line) }.to_string()
    };
    let rounds = "9 rounds over UDP (5 on a calm network, 2 of no use)";
    let all =
        |verb, ns| format!("{rounds}; the own clock {verb} {ns} ns in a second; quickest round trips of about 1500 ns");
    assert_eq!([report(70), report(0), report(-70)], [all("loses", 70), all("gains", 0), all("gains", 70)]);
    assert_eq!(ClockSyncReport { exchanges: 9, unused: 2, calm: 5, line: None }.to_string(), rounds);
    let fault = |ppb| ClockFault::Drift(ppb).to_string();
    assert!(fault(DRIFT_PPB_MAX).contains("it is corrected") && fault(-DRIFT_PPB_MAX).contains("it is corrected"));
    assert!(fault(DRIFT_PPB_MAX + 1).contains("more than can be corrected"));
    assert!(fault(0).contains("gains 0 us"));
}

#[test]
fn a_change_of_rate_is_no_step() {
    let old = ClockCorrection::with_offset(Interval::from_nanos(70));
    let mut next = old;
    next.slew(Instant::from_nanos(1_000), Interval::from_nanos(5));
    assert!(!old.is_step(&next) && !old.is_step(&old));
    assert!(old.is_step(&ClockCorrection::with_offset(Interval::from_nanos(71))));
}

#[test]
fn an_outcome_counts_the_federates_that_are_missing_besides_the_first() {
    let not_started = |missing| Outcome::NotStarted { first: ONE, missing }.to_string();
    let sentence =
        |more| format!("the federation has not started: federate 1{more} did not come back in time after a loss");
    assert_eq!([not_started(1), not_started(2)], [sentence(""), sentence(" and 1 more")]);
    let lost = Outcome::Lost { federate: TWO, cause: Cause::NoClock }.to_string();
    assert_eq!(lost, format!("the federation has failed: federate 2 is lost: {}", Cause::NoClock));
    assert_eq!(ConnectionId(7).to_string(), "7");
}

#[test]
fn what_an_rti_waits_for_is_told_in_milliseconds() {
    let (tag, lasts) = (EventTag::relative(Tag::NEVER, Instant::NEVER), Interval::from_micros(12_345_678));
    let grant = Waits::Grant { federate: ONE, tag, lasts, by: TWO, at: tag }.to_string();
    assert!(grant.starts_with("federate 1 has been waiting for 12345 ms for a grant of "), "{grant}");
    let sender = |room| Waits::Sender { from: ONE, to: TWO, room, lasts }.to_string();
    let begin = "messages of federate 1 have been waiting for 12345 ms, because federate 2";
    assert_eq!(sender(true), format!("{begin} does not take what it is sent"));
    assert_eq!(sender(false), format!("{begin} is too many tags behind"));
    let start = |strangers| Waits::Start { missing: 2, federates: 3, strangers }.to_string();
    let strangers = "; 4 connections have not said which federates they are";
    assert_eq!(start(0), "the start waits for 2 of 3 federates");
    assert_eq!(start(4), format!("the start waits for 2 of 3 federates{strangers}"));
}

/// Frequent events are logged the first time, the tenth time, and so on; their sum names only what there was.
#[test]
fn frequent_events_are_logged_from_time_to_time_and_summed_up() {
    for (times, is_logged) in [(Times(1), true), (Times(2), false), (Times(10), true)] {
        let events = [
            RtiEvent::Evicted(times),
            RtiEvent::Dropped { from: ONE, to: TWO, times },
            RtiEvent::Late { from: ONE, to: TWO, times },
            RtiEvent::Missed { from: ONE, to: TWO, times },
        ];
        assert_eq!(events.map(|event| event.is_logged()), [is_logged; 4], "{times:?}");
    }
    assert!(RtiEvent::Joined(ONE).is_logged());
    let sum = |[unknown, late, dropped]: [u32; 3]| {
        RtiEvent::Sum { federate: ONE, unknown: Times(unknown), late: Times(late), dropped: Times(dropped) }.to_string()
    };
    let dropped = "messages dropped, because their destinations have left";
    assert_eq!(sum([0, 3, 0]), "federate 1 in all: 3 late messages");
    assert_eq!(sum([2, 0, 1]), format!("federate 1 in all: 2 bytes that begin no message; 1 {dropped}"));
}

/// Writes a sentence by a function.
struct By<F>(F);

impl<F: Fn(&mut fmt::Formatter<'_>) -> fmt::Result> fmt::Display for By<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (self.0)(f)
    }
}

#[test]
fn errors_name_what_is_wrong() {
    let early = By(|f: &mut fmt::Formatter<'_>| before_start(f, &"a.in", Interval::from_micros(2_500))).to_string();
    assert!(early.starts_with("a message over a.in came with a tag that is 2500000 ns = 2 ms before"), "{early}");
    let too_long = ConfigError::FederationIdTooLong { bytes: 256 }.to_string();
    assert_eq!(too_long, "the federation id has 256 bytes: give one of at most 255");
}

/// The time for attempts begins again where an address is found; an attempt of another kind does not wait for a pause.
#[test]
fn attempts_to_connect_can_be_renewed_and_hurried() {
    let (start, pause) = (Instant::from_nanos(0), CONNECT_RETRY);
    let mut retry = ConnectRetry::new(start);
    assert_eq!((retry.last(), retry.give_up()), (start - pause, start + CONNECT_TIME_OUT));
    assert_eq!(retry.poll(start), ConnectStep::Attempt);
    assert_eq!((retry.last(), retry.poll(start)), (start, ConnectStep::WaitUntil(start + pause)));
    let soon = start + Interval::from_nanos(1);
    retry.retry_now(soon);
    assert_eq!((retry.poll(soon), retry.last()), (ConnectStep::Attempt, soon));
    retry.renew(soon + CONNECT_TIME_OUT);
    assert_eq!(retry.give_up(), soon + CONNECT_TIME_OUT + CONNECT_TIME_OUT);
    assert_eq!(retry.poll(start + CONNECT_TIME_OUT), ConnectStep::Attempt);
}

#[test]
fn an_awaited_input_is_known_up_to_the_tag_that_came_last() {
    let tag = |microstep| Tag::new(Instant::from_nanos(5), Microstep(microstep));
    let inputs = [3, 4].map(|port| AwaitedInput { port, level: 0 });
    let mut known = [Tag::NEVER; 2];
    let mut awaited = Awaited::new(&inputs, &mut known).unwrap();
    awaited.learn(4, tag(2));
    assert_eq!([1, 2, 3].map(|microstep| awaited.is_known(4, tag(microstep))), [true, true, false]);
    assert!(!awaited.is_known(3, tag(0)) && awaited.is_known(9, tag(0)), "another input is not waited for");
    assert_eq!(awaited.first_unknown(tag(2)), Some(3));
    awaited.learn(3, tag(3));
    assert_eq!([2, 3, 4].map(|microstep| awaited.first_unknown(tag(microstep))), [None, Some(4), Some(3)]);
}
