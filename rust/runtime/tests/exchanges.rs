// SPDX-License-Identifier: Apache-2.0
//! The exchanges of clock synchronization before the start, as the RTI's event loop makes them: what it does in between
//! would be taken for a part of their way.

use crate::support::raw::{Tester, config, with_rti};
use lf_coordination::rti::{ClockSync, Config};
use lf_model::time::Interval;
use lf_testkit::world::{Conditions, Move};
use lf_wire::{Message, MessageType, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF};

const TRIALS: u32 = 3;

fn trials() -> Config<'static> {
    Config { clock_sync: ClockSync::Init { trials: TRIALS }, ..config() }
}

/// Returns a network that takes no time.
fn at_once(seed: u64) -> Conditions {
    Conditions { latency_ns_max: 0, whole: true, ..Conditions::seeded(seed) }
}

/// Answers what comes on these connections, whose numbers are those of their federates, until nothing more does.
fn answer_all(tester: &mut Tester, connections: &[usize]) {
    let mut left = connections.len() * usize::try_from(TRIALS).unwrap();
    while left > 0 {
        for (connection, message) in tester.hear_any(connections) {
            match message {
                MessageType::T1 => {
                    let federate = u16::try_from(connection).unwrap();
                    tester.say(connection, &Message::T3 { federate });
                }
                MessageType::T4 => left -= 1,
                other => panic!("it should not say {other}"),
            }
        }
    }
}

/// Returns the connections on which T1 and T4 were sent, each with the length of its uninterrupted sequence.
fn runs(moves: &[Move]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for one in moves {
        let Move::Said(connection, bytes) = one else { continue };
        // Messages at once, or in pieces, are this many bytes of times.
        let bytes = bytes.len();
        match runs.last_mut() {
            _ if bytes < 9 => {}
            Some((last, count)) if last == connection => *count += bytes / 9,
            _ => runs.push((*connection, bytes / 9)),
        }
    }
    runs
}

#[test]
fn federates_that_come_at_once_have_their_exchanges_one_after_the_other() {
    for seed in 0..16 {
        let ended = with_rti(trials(), 4, at_once(seed), |tester| {
            let connections: Vec<_> = (0..4).map(|_| tester.connect()).collect();
            for (connection, id) in connections.iter().zip(0..) {
                tester.introduce(*connection, id, &[], UDP_PORT_CLOCK_SYNC_INITIAL);
            }
            answer_all(tester, &connections);
            for connection in connections {
                tester.say(connection, &Message::Timestamp(0));
                tester.say(connection, &Message::Resign);
            }
        });
        let mut runs = runs(&ended.moves);
        // At the end each receives the start time, which is as long.
        runs.truncate(4);
        let whole = 2 * usize::try_from(TRIALS).unwrap();
        runs.sort_unstable();
        assert_eq!(runs, [(0, whole), (1, whole), (2, whole), (3, whole)], "seed {seed}");
    }
}

#[test]
fn a_federate_that_does_not_answer_holds_the_others_up_for_a_moment_only() {
    let ended = with_rti(trials(), 3, at_once(1), |tester| {
        let silent = tester.connect();
        tester.introduce(silent, 0, &[], UDP_PORT_CLOCK_SYNC_INITIAL);
        tester.hear(silent, |message| matches!(message, Message::T1(_)));
        let others: Vec<_> = (1..3).map(|_| tester.connect()).collect();
        let before = tester.now();
        for (connection, id) in others.iter().zip(1..) {
            tester.introduce(*connection, id, &[], UDP_PORT_CLOCK_SYNC_INITIAL);
        }
        answer_all(tester, &others);
        assert!(tester.now() < before + Interval::from_millis(50));
        // It may answer after all.
        tester.say(silent, &Message::T3 { federate: 0 });
        tester.hear(silent, |message| matches!(message, Message::T4(_)));
    });
    assert_eq!(ended.violation, None);
}

/// A federate that has joined asks again and again; another one is at its exchanges.
#[test]
fn an_answer_leaves_before_anything_else_is_heard() {
    for seed in 0..16 {
        let ended = with_rti(trials(), 2, at_once(seed), |tester| {
            let (other, exchanging) = (tester.connect(), tester.connect());
            tester.introduce(other, 0, &[], UDP_PORT_CLOCK_SYNC_OFF);
            tester.introduce(exchanging, 1, &[], UDP_PORT_CLOCK_SYNC_INITIAL);
            tester.hear(exchanging, |message| matches!(message, Message::T1(_)));
            // The network takes no time, so both are there when the RTI looks.
            tester.say(other, &Message::AddressQuery { federate: 1, is_transient: None });
            tester.say(exchanging, &Message::T3 { federate: 1 });
            tester.hear(exchanging, |message| matches!(message, Message::T1(_)));
        });
        let first_query = ended.moves.iter().rposition(|one| *one == Move::Heard(0)).unwrap();
        let answer = ended.moves.iter().rposition(|one| *one == Move::Heard(1)).unwrap();
        assert!(answer < first_query, "seed {seed}: {:?}", ended.moves);
        let said = &ended.moves[answer..first_query];
        let times = |one: &Move| matches!(one, Move::Said(1, bytes) if bytes.len() == 9);
        assert_eq!(said.iter().filter(|one| times(one)).count(), 2, "seed {seed}: T4, and the next T1: {said:?}");
    }
}
