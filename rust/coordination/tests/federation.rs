// SPDX-License-Identifier: Apache-2.0
//! Federates and the RTI of this crate, together, in random graphs with and without cycles without delay: whatever the
//! speeds of the participants and the splits of the byte streams, every federate sees what the whole federation does as
//! one program, and all come to their end.

use std::collections::BTreeSet;

use crate::federation_support::graph::{END_NS, Graph, Trace, any_graph};
use crate::federation_support::participant::Participant;
use lf_coordination::WINDOW;
use lf_coordination::federate::{All, Disconnected, Needs, Phase};
use lf_coordination::rti::{ClockSync as RtiClockSync, Config as RtiConfig, Outcome, Status};
use lf_model::time::Interval;
use lf_testkit::profiles::Centralized;
use lf_testkit::random::Random;
use lf_testkit::rti::{Rig, Sizes};
use proptest::prelude::*;

/// Longer than any payload here: answers to stop requests are looked for in as many bytes.
const PAYLOAD_MAX: usize = 1 << 16;
/// Far more turns than any of these federations needs.
const TURNS_MAX: usize = 200_000;

/// Windows are offered below this: as large as the usual one, and a bit larger.
const OFFERS: u16 = WINDOW + 8;

/// The parameters of a run.
#[derive(Clone, Copy, Debug)]
struct Manner {
    /// Decides on speeds and splits.
    seed: u64,
    /// Bytes of every federate's output.
    room: usize,
    dnet: bool,
    window: u16,
    /// The windows that the federates offer, in turns.
    offers: [u16; 2],
    /// This federate runs one tag where others may run many.
    slow: Option<usize>,
    /// The federate that asks to stop, and when.
    stop: Option<(usize, i64)>,
}

impl Manner {
    fn usual(seed: u64) -> Self {
        Self { seed, room: 1 << 16, dnet: true, window: WINDOW, offers: [0; 2], slow: None, stop: None }
    }
}

/// Runs a federation of federates with these needs to its end; returns what each federate has seen.
fn run<N: Needs>(graph: &Graph, manner: Manner) -> Vec<Trace> {
    let Manner { seed, room, dnet, window, offers, slow, stop } = manner;
    let agreed = offers[0].min(offers[1]);
    let count = graph.periods.len();
    let clock_sync = RtiClockSync::Init { trials: 3 };
    let config = RtiConfig { clock_sync, dnet, window, ..RtiConfig::new(b"random", PAYLOAD_MAX) };
    let mut rig = Rig::new(config, Sizes { output: 128, ..Sizes::ample(count) });
    let mut participants: Vec<Participant<N>> =
        (0..).take(count).map(|id| Participant::new(id, graph, &mut rig, room, offers[usize::from(id % 2)])).collect();
    // The next federate, and how much it does.
    let mut random = Random::new(seed);
    for _ in 0..TURNS_MAX {
        if participants.iter().all(|participant| participant.closed) {
            break;
        }
        let index = random.index(count);
        let participant = &mut participants[index];
        let connection = participant.connection;
        rig.now = rig.now + Interval::from_nanos(1);
        let now = rig.now;
        match random.below(3) {
            _ if participant.closed => {}
            0 => {
                let bytes = rig.take(connection, random.count(1, 40));
                participant.receive(now, &bytes);
                participant.check_queues(window, agreed);
            }
            1 => {
                let len = random.count(1, 60).min(participant.outgoing.len());
                let bytes: Vec<u8> = participant.outgoing.drain(..len).collect();
                if participant.outgoing.is_empty() {
                    participant.federate.handle_written(now);
                }
                participant.announce(now);
                rig.send(connection, &bytes);
            }
            _ if slow == Some(index) && random.below(40) > 0 => {}
            _ => {
                let stop_at = stop.filter(|(who, _)| *who == index).map(|(_, at)| at);
                participant.run(now, stop_at);
            }
        }
        // The RTI ends its direction when it has read the RESIGN.
        let ended = rig.outlet.list[connection.0].ended;
        if participant.federate.phase() == Phase::Ended && ended && !participant.closed {
            assert_eq!(participant.federate.handle_disconnected(), Ok(Disconnected::Ended));
            rig.close(connection);
            participant.closed = true;
        }
    }
    let stuck: Vec<_> = participants.iter().filter(|participant| !participant.closed).map(|p| &p.federate).collect();
    assert!(stuck.is_empty(), "these have not come to their end: {stuck:#?}");
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::Complete));
    // A federate that has reached its time-out before another one asks is not asked any more.
    let stop_tags: BTreeSet<_> =
        participants.iter().filter_map(|participant| participant.federate.stop_tag()).collect();
    assert!(stop_tags.len() <= 1, "{stop_tags:?}");
    participants.into_iter().map(|participant| participant.trace).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Speed, room, DNETs and profile make no difference to what the federates see, and neither does that they are
    /// several.
    #[test]
    fn observed_values_do_not_depend_on_the_speed(graph in any_graph(), seeds: [u64; 3], small in 75..100usize) {
        let expected = graph.expected();
        prop_assert_eq!(&run::<All>(&graph, Manner::usual(seeds[0])), &expected);
        prop_assert_eq!(&run::<Centralized>(&graph, Manner { room: small, ..Manner::usual(seeds[1]) }), &expected);
        prop_assert_eq!(&run::<Centralized>(&graph, Manner { dnet: false, ..Manner::usual(seeds[2]) }), &expected);
    }

    /// A slow federate makes others wait, which makes no difference either, in cycles neither; and it never has more
    /// in its queues than they are made for.
    #[test]
    fn observed_values_do_not_depend_on_the_window(
        graph in any_graph(),
        seed: u64,
        window in 1..4u16,
        offers: [u16; 2],
        slow: usize,
        dnet: bool,
    ) {
        let slow = Some(slow % graph.periods.len());
        let offers = offers.map(|offer| offer % OFFERS);
        let manner = Manner { dnet, window, slow, ..Manner::usual(seed) };
        prop_assert_eq!(run::<Centralized>(&graph, manner), graph.expected());
        prop_assert_eq!(run::<All>(&graph, Manner { offers, ..manner }), graph.expected());
    }

    /// A stop ends all federates at one tag, and until then makes no difference.
    #[test]
    fn all_stop_at_one_tag(
        graph in any_graph(),
        seed: u64,
        who: usize,
        at in 0..END_NS,
        window in 1..4u16,
        offers: [u16; 2],
        slow: usize,
    ) {
        let (stop, slow) = (Some((who % graph.periods.len(), at)), Some(slow % graph.periods.len()));
        let offers = offers.map(|offer| offer % OFFERS);
        let stopped = run::<All>(&graph, Manner { window, offers, slow, stop, ..Manner::usual(seed) });
        for (all, seen) in graph.expected().iter().zip(&stopped) {
            // The last tag is one more event, which has no inputs of its own.
            let last = seen.keys().next_back();
            for (tag, inputs) in seen {
                prop_assert!(all.get(tag) == Some(inputs) || (Some(tag) == last && inputs.is_empty()), "{tag:?}");
            }
            prop_assert!(all.keys().filter(|tag| Some(*tag) <= last).all(|tag| seen.contains_key(tag)));
        }
    }
}
