// SPDX-License-Identifier: Apache-2.0
//! A federate whose words cannot be true is named, or ended, instead of letting all wait without a word.

use lf_coordination::rti::{CLOCK_MAX, CLOCK_MIN};
use lf_model::time::Interval;
use lf_testkit::rti::dialogue::{at, config, hello, read, started};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{DELAY_NONE, Message};

const HOUR: Interval = Interval::from_secs(3600);
/// The distance of clocks above which it is logged.
const APART: Interval = Interval::from_secs(2);

fn suspected(rig: &Rig, federate: u16) -> Vec<&str> {
    let begin = format!("federate {federate} ");
    let said = rig.outlet.log_events.iter().filter_map(|event| event.strip_prefix(&begin));
    said.filter(|words| ["says that", "announces", "has a clock"].iter().any(|begin| words.starts_with(begin)))
        .collect()
}

#[test]
fn a_clock_at_either_end_of_time_is_refused() {
    for clock in [CLOCK_MAX.as_nanos(), i64::MAX, CLOCK_MIN.as_nanos() - 1, i64::MIN] {
        let mut rig = Rig::new(config(), Sizes::ample(2));
        let federates = [0, 1].map(|id| hello(&mut rig, id, &[]));
        rig.message(federates[0], &Message::Timestamp(clock));
        assert_eq!(read(&mut rig, federates[0]), ["FAILED"]);
        let words = format!("its clock shows {clock} ns since 1970, and no time of the years 1900 to 2199");
        assert!(rig.outlet.log_events.iter().any(|event| event.ends_with(&words)), "{:?}", rig.outlet.log_events);
        assert_eq!(rig.rti.start_time(), None);
    }
}

/// Everybody waits for the federate whose clock is ahead, so that is said from seconds on.
#[test]
fn clocks_that_are_seconds_apart_are_named() {
    for (apart, named) in [(APART.as_nanos(), false), (APART.as_nanos() + 1, true), (3_540_000_000_000, true)] {
        let mut rig = Rig::new(config(), Sizes::ample(2));
        let federates = [0, 1].map(|id| hello(&mut rig, id, &[]));
        rig.message(federates[0], &Message::Timestamp(500));
        rig.message(federates[1], &Message::Timestamp(500 + apart));
        assert!(rig.rti.start_time().is_some());
        let suspected = suspected(&rig, 1);
        assert_eq!(!suspected.is_empty(), named);
        let words = format!(
            "has a clock that is {} s ahead of that of federate 0, which waits so long for the start: set the clocks, \
             or use `clock-sync: init`, for federates on the RTI's computer with `local-federates-on`",
            apart / 1_000_000_000
        );
        assert!(!named || suspected == [words], "{suspected:?}");
    }
}

/// A federate that comes an hour later sends a clock that shows an hour more.
#[test]
fn clocks_that_are_told_at_different_times_are_not_apart() {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    let federates = [0, 1].map(|id| hello(&mut rig, id, &[]));
    rig.message(federates[0], &Message::Timestamp(500));
    rig.now = rig.now + HOUR;
    rig.message(federates[1], &Message::Timestamp(500 + HOUR.as_nanos()));
    assert!(rig.rti.start_time().is_some());
    assert_eq!(suspected(&rig, 1), Vec::<&str>::new());
}

#[test]
fn a_federate_that_completes_a_tag_without_a_grant_is_named_once() {
    let (mut rig, federates) = started(config(), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    rig.message(federates[1], &Message::NextEventTag(at(0)));
    for ns in [5, 9] {
        rig.message(federates[1], &Message::LatestTagComplete(at(ns)));
    }
    assert_eq!(
        suspected(&rig, 1),
        ["says that it has completed (1000000005 ns, 0), which it was not granted: messages to others may come too \
             late"]
    );
    assert_eq!(suspected(&rig, 0), Vec::<&str>::new());
}

#[test]
fn an_event_before_what_is_complete_is_named() {
    let (mut rig, federates) = started(config(), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    rig.message(federates[0], &Message::LatestTagComplete(at(8)));
    rig.message(federates[0], &Message::NextEventTag(at(9)));
    assert_eq!(suspected(&rig, 0), Vec::<&str>::new());
    rig.message(federates[0], &Message::NextEventTag(at(8)));
    assert_eq!(
        suspected(&rig, 0),
        ["announces an event at (1000000008 ns, 0), though it has completed (1000000008 ns, 0)"]
    );
}

/// An announcement may become earlier: a message has come for it, or a physical action.
#[test]
fn an_earlier_event_that_is_not_complete_is_not_suspected() {
    let (mut rig, federates) = started(config(), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    for ns in [9, 7] {
        rig.message(federates[0], &Message::NextEventTag(at(ns)));
    }
    assert_eq!(suspected(&rig, 0), Vec::<&str>::new());
}

/// As a source does whose events matter to nobody, and every federate of decentralized coordination.
#[test]
fn who_asks_for_no_grant_needs_none() {
    let upstream = [vec![], vec![(0, DELAY_NONE)]];
    let (mut rig, federates) = started(config(), Sizes::ample(2), &upstream);
    rig.message(federates[1], &Message::LatestTagComplete(at(5)));
    assert_eq!(suspected(&rig, 1), Vec::<&str>::new());
    rig.message(federates[1], &Message::NextEventTag(at(7)));
    rig.message(federates[0], &Message::LatestTagComplete(at(6)));
    assert_eq!(suspected(&rig, 0), Vec::<&str>::new());
}
