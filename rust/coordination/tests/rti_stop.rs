// SPDX-License-Identifier: Apache-2.0
//! Stopping in every order: any number of federates ask at the same time, others answer, leave or fail before, after or
//! in between. All that are left stop at the latest tag that anybody has named.

use std::collections::BTreeMap;

use lf_coordination::rti::{Config, ConnectionId, STOP_REPLY_TIME_OUT, Status};
use lf_coordination::{Deadline, to_wire};
use lf_model::time::Interval;
use lf_testkit::rti::dialogue::{at, config, read, started, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{Decoded, Limits, Message, Tag, decode};
use proptest::prelude::*;

const FEDERATES: usize = 5;

/// The next step of a federate.
#[derive(Clone, Copy, Debug)]
enum Act {
    /// It asks to stop, if it has named no tag yet.
    Ask(i64),
    /// It answers the request that has come, with this tag or the one that was asked for.
    Answer(i64),
    Resign,
    Fail,
    Vanish,
}

fn any_act() -> impl Strategy<Value = Act> {
    prop_oneof![
        4 => (0..50i64).prop_map(Act::Ask),
        6 => (0..50i64).prop_map(Act::Answer),
        1 => Just(Act::Resign),
        1 => Just(Act::Fail),
        1 => Just(Act::Vanish),
    ]
}

/// A federate as the tester sees it.
#[derive(Default)]
struct Tester {
    gone: bool,
    named: Option<Tag>,
    asked: Option<Tag>,
    granted: Option<Tag>,
}

struct Federation {
    rig: Rig,
    connections: Vec<ConnectionId>,
    testers: Vec<Tester>,
}

impl Federation {
    fn new() -> Self {
        let config = Config { window: 1, ..config() };
        let (rig, connections) = started(config, Sizes::ample(FEDERATES), &vec![vec![]; FEDERATES]);
        Self { rig, connections, testers: (0..FEDERATES).map(|_| Tester::default()).collect() }
    }

    fn act(&mut self, who: usize, act: Act) {
        let (connection, tester) = (self.connections[who], &mut self.testers[who]);
        if tester.gone {
            return;
        }
        match act {
            Act::Ask(ns) if tester.named.is_none() && tester.granted.is_none() => {
                tester.named = Some(at(ns));
                self.rig.message(connection, &Message::StopRequest(at(ns)));
            }
            Act::Answer(ns) => {
                let (Some(asked), None) = (tester.asked, tester.named) else { return };
                tester.named = Some(asked.max(at(ns)));
                self.rig.message(connection, &Message::StopReply(asked.max(at(ns))));
            }
            Act::Resign => self.leave(who, &Message::Resign),
            Act::Fail => self.leave(who, &Message::Failed),
            Act::Vanish => {
                tester.gone = true;
                self.rig.close(connection);
            }
            Act::Ask(_) => {}
        }
    }

    fn leave(&mut self, who: usize, word: &Message<'_>) {
        self.testers[who].gone = true;
        self.rig.message(self.connections[who], word);
    }

    /// Reads the messages for all.
    fn read(&mut self) {
        for (connection, tester) in self.connections.iter().zip(&mut self.testers) {
            let bytes = self.rig.take(*connection, usize::MAX);
            let mut rest = &bytes[..];
            while let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) {
                match message {
                    Message::StopRequest(tag) => {
                        assert_eq!(tester.asked.replace(tag), None, "nobody is asked twice");
                        assert_eq!(tester.granted, None, "nobody is asked after the grant");
                    }
                    Message::StopGranted(tag) => assert_eq!(tester.granted.replace(tag), None, "granted twice"),
                    _ => {}
                }
                rest = &rest[len..];
            }
        }
    }

    fn latest_named(&self) -> Option<Tag> {
        self.testers.iter().filter_map(|tester| tester.named).max()
    }
}

/// The RTI does not ask for its time-out again.
#[test]
fn who_does_not_answer_is_lost_and_the_others_stop() {
    let (mut rig, federates) = started(config(), Sizes::ample(4), &vec![vec![]; 4]);
    rig.message(federates[0], &Message::StopRequest(at(3)));
    rig.message(federates[1], &Message::StopReply(at(4)));
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + STOP_REPLY_TIME_OUT));
    wait(&mut rig, Interval::from_nanos(STOP_REPLY_TIME_OUT.as_nanos() - 1));
    for (federate, heard) in federates.iter().zip([&[][..], &["STOP_REQUEST"], &["STOP_REQUEST"], &["STOP_REQUEST"]]) {
        assert_eq!(read(&mut rig, *federate), heard);
    }
    wait(&mut rig, Interval::from_nanos(1));
    for (federate, heard) in federates.iter().zip(["STOP_GRANTED", "STOP_GRANTED", "FAILED", "FAILED"]) {
        assert_eq!(read(&mut rig, *federate), [heard]);
    }
    assert_eq!(rig.rti.stop_tag().map(to_wire), Some(at(4)));
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
}

proptest! {
    #[test]
    fn all_that_are_left_stop_at_the_latest_tag_that_was_named(
        acts in proptest::collection::vec((0..FEDERATES, any_act(), any::<bool>()), 0..40),
    ) {
        let mut federation = Federation::new();
        for (who, act, read) in acts {
            federation.act(who, act);
            // Sometimes several act before anybody hears of it.
            if read {
                federation.read();
            }
        }
        federation.read();
        // Those that are asked answer sooner or later.
        for who in 0..FEDERATES {
            federation.act(who, Act::Answer(0));
            federation.read();
        }
        federation.read();
        let somebody_asked = federation.testers.iter().any(|tester| tester.named.is_some());
        let latest = federation.latest_named();
        let mut tags = BTreeMap::new();
        for tester in federation.testers.iter().filter(|tester| !tester.gone) {
            *tags.entry(tester.granted).or_insert(0) += 1;
        }
        let expected = somebody_asked.then_some(latest).flatten();
        prop_assert!(tags.keys().all(|tag| *tag == expected), "{tags:?}, {expected:?} is due");
        prop_assert_eq!(federation.rig.rti.stop_tag().is_some(), somebody_asked);
        for who in 0..FEDERATES {
            if !federation.testers[who].gone {
                federation.act(who, Act::Resign);
            }
        }
        prop_assert!(matches!(federation.rig.rti.status(), Status::Finished(_)));
    }
}
