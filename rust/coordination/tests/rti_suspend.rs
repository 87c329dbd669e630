// SPDX-License-Identifier: Apache-2.0
//! An RTI that is suspended between any two inputs, and goes on with a copy of its storage, says what one says that
//! never was.

use lf_coordination::heap::{Memory, Sizes};
use lf_coordination::rti::{ClockSync, Config, ConnectionId, Rti, Suspended, Verdict};
use lf_model::time::Instant;
use lf_testkit::messages::{encoded, introduction};
use lf_testkit::rti::Connections;
use lf_wire::{DELAY_NONE, Message};
use proptest::prelude::*;

const FEDERATES: usize = 3;
/// Little room for messages in transit, so that its limits take part.
const IN_TRANSIT: usize = 2;

fn memory() -> Memory {
    Memory::new(Sizes { federates: FEDERATES, connections: FEDERATES, upstream: FEDERATES, in_transit: IN_TRANSIT })
}

fn config() -> Config<'static> {
    Config { clock_sync: ClockSync::Off, ..Config::new(b"pause", 16) }
}

fn wires() -> Connections {
    let mut wires = Connections::new(FEDERATES, 1 << 16, ());
    wires.list.iter_mut().for_each(|wire| wire.open = true);
    wires
}

/// Returns the script of a chain with a connection back, followed by arbitrary messages of the federates.
fn script(said: &[(usize, u8, i64)]) -> Vec<(usize, Vec<u8>)> {
    let upstream: [&[(u16, i64)]; FEDERATES] = [&[(2, 5)], &[(0, DELAY_NONE)], &[(1, 0)]];
    let mut script = Vec::new();
    for (id, upstream) in (0u16..).zip(upstream) {
        let downstream = [(id + 1) % 3];
        let hello = introduction(id, b"pause", upstream, &downstream).into_iter().chain([Message::Timestamp(0)]);
        script.extend(hello.map(|message| (usize::from(id), encoded(&message))));
    }
    script.extend(said.iter().map(|(from, kind, time)| {
        let tag = lf_wire::Tag::new(1_000_000_000 + time, 0);
        let federate = u16::try_from((from + 1) % FEDERATES).expect("it is small");
        let message = match kind {
            0..4 => Message::NextEventTag(tag),
            4..6 => Message::LatestTagComplete(tag),
            6..9 => Message::TaggedMessage { port: 0, federate, tag, payload: b"x" },
            9 => Message::StopRequest(tag),
            _ => Message::Resign,
        };
        (*from, encoded(&message))
    }));
    script
}

/// Returns all answers of the RTI to a script, and its status at the end.
fn play(script: &[(usize, Vec<u8>)], suspended: bool) -> (Vec<Vec<u8>>, Vec<String>, Memory, Suspended) {
    let (mut memory, mut outlet, now) = (memory(), wires(), Instant::from_nanos(0));
    let mut borrowed = memory.clone();
    let mut rti = Rti::new(config(), borrowed.storage()).expect("the storage fits");
    for index in 0..FEDERATES {
        rti.handle_connect(
            now,
            ConnectionId(index),
            lf_coordination::IpAddress::V4([127, 0, 0, 1].into()),
            [0; 8],
            &mut outlet,
        );
    }
    let mut state = rti.suspend();
    memory.clone_from(&borrowed);
    if suspended {
        for (from, bytes) in script {
            let mut copy = memory.clone();
            let mut rti = Rti::resume(config(), copy.storage(), state).expect("the storage fits");
            let verdict = rti.handle_input(now, ConnectionId(*from), bytes, &mut outlet);
            assert!(!matches!(verdict, Verdict::Blocked(_)), "there is room for all");
            state = rti.suspend();
            memory = copy;
        }
    } else {
        let mut rti = Rti::resume(config(), memory.storage(), state).expect("the storage fits");
        for (from, bytes) in script {
            rti.handle_input(now, ConnectionId(*from), bytes, &mut outlet);
        }
        state = rti.suspend();
    }
    (outlet.list.into_iter().map(|wire| wire.outgoing).collect(), uncounted(outlet.log_events), memory, state)
}

/// Removes the counts, because a suspended RTI forgets how often an event has been logged.
fn uncounted(log_events: Vec<String>) -> Vec<String> {
    let without = |event: String| event.rsplit_once(" (").map_or(event.clone(), |(words, _)| words.to_owned());
    log_events.into_iter().filter(|event| !event.contains(" in all:")).map(without).collect()
}

proptest! {
    #[test]
    fn a_pause_changes_nothing(said in proptest::collection::vec((0..FEDERATES, 0..12u8, 0..20i64), 0..40)) {
        let script = script(&said);
        prop_assert_eq!(play(&script, true), play(&script, false));
    }
}
