// SPDX-License-Identifier: Apache-2.0
//! A federate with instances inside, driven tag by tag.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use std::time::Duration;

use lf_linux::model::{Engine, EngineStorage as _, EventTag, InputId, Instant, Interval, Payload as _, Settings, Tag};
use lf_programs::filters::unit::federate::{Storage, TABLES, UnitFederate};
use lf_programs::filters::unit::filters::{Command, ENDED_AT, SEEN};
use lf_testkit::host::{Clock, Host};

const START: Instant = Instant::from_nanos(1_000_000_000);

#[test]
fn the_program_runs_through_its_tags() {
    let mut host = Host::new(Clock::new_static(START.as_nanos()));
    let (mut program, mut storage) = (UnitFederate::new(), Storage::new());
    let mut engine = Engine::new(&TABLES, &mut storage, Settings { federated: true, ..Settings::DEFAULT });
    engine.start(START);
    let at = |ms| Tag::at(START + Interval::from_millis(ms));
    let mut stop = [0; Command::MAX_LEN];
    Command { stop: true, value: 55 }.encode(&mut stop).unwrap();
    engine.deliver(&mut program, InputId(0), at(15), &stop).unwrap();
    host.run(&mut engine, &mut program, |_, _, _| {});
    // At 12 ms the button pops up from the thread with 1000, at 14 ms without a value.
    assert_eq!(*SEEN.lock().unwrap(), [1, 3, 100, 11, 12, 1000, 13, 100, 14, 55, 42]);
    assert_eq!(*ENDED_AT.lock().unwrap(), Some(EventTag::new(Duration::from_millis(15), 1)));
    // 7 * 3 at 0 and 10 ms, through the delayed connection and the second filter 5 ms later, sent with 20 ms.
    assert_eq!(host.sent, [(1, 0, at(25), vec![42, 0, 0, 0]), (1, 0, at(35), vec![42, 0, 0, 0])]);
}
