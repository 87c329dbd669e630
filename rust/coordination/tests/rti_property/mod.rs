// SPDX-License-Identifier: Apache-2.0
//! Federates that keep the rules, in random graphs, at random speeds and with little room: no grant is ever wrong, no
//! federate waits forever, no message is lost. Peers that keep no rules do no harm.

mod peer;

use std::collections::{BTreeMap, BTreeSet};

use lf_coordination::rti::{ClockSync, Config, Outcome, Status};
use lf_model::time::Instant;
use lf_testkit::random::Random;
use lf_testkit::rti::{Rig, Sizes};
use peer::{Peer, Plan};
use proptest::prelude::*;

const FEDERATION: &[u8] = b"random";
const END: i64 = 60;
const PAYLOAD_MAX: usize = 20;
/// The longest message: a tagged one, or a neighbor structure of nine federates.
const OUTPUT_MIN: usize = 41;

fn config() -> Config<'static> {
    Config { clock_sync: ClockSync::Off, ..Config::new(FEDERATION, PAYLOAD_MAX) }
}

/// A connection: from, to, delay.
type Edge = (u16, u16, i64);

fn delay() -> impl Strategy<Value = i64> {
    prop_oneof![3 => Just(i64::MIN), 1 => Just(0), 3 => 1..30i64]
}

/// Connections from lower to higher ids, with any delay; if `cycles`, also backwards with a delay.
fn edges(federates: u16, cycles: bool) -> impl Strategy<Value = Vec<Edge>> {
    let any = (0..federates, 0..federates, delay(), 0..30i64);
    proptest::collection::vec(any, 1..14).prop_map(move |all| {
        let forward = |(from, to, delay, after): Edge4| match from < to {
            true => Some((from, to, delay)),
            false if cycles => Some((from, to, after)),
            false => None,
        };
        all.into_iter().filter_map(forward).collect()
    })
}

type Edge4 = (u16, u16, i64, i64);

#[derive(Clone, Debug)]
struct Case {
    plans: Vec<Plan>,
    /// The seed of the order of steps.
    seed: u64,
    in_transit: usize,
    output: usize,
    window: u16,
}

fn case(cycles: bool) -> impl Strategy<Value = Case> {
    (2..8u16).prop_flat_map(move |federates| {
        let events = proptest::collection::btree_set(0..END, 0..8);
        let one = (events, any::<bool>());
        (
            edges(federates, cycles),
            proptest::collection::vec(one, usize::from(federates)),
            any::<u64>(),
            1..4usize,
            OUTPUT_MIN..120usize,
            1..5u16,
        )
            .prop_map(|(edges, events, seed, in_transit, output, window)| {
                let plans = events
                    .into_iter()
                    .zip(0u16..)
                    .map(|((events, honours_dnet), id)| plan(&edges, events, honours_dnet, id));
                Case { plans: plans.collect(), seed, in_transit, output, window }
            })
    })
}

fn plan(edges: &[Edge], events: BTreeSet<i64>, honours_dnet: bool, id: u16) -> Plan {
    // Of parallel connections, only the minimum delay is announced.
    let mut upstream = BTreeMap::new();
    for (from, _, delay) in edges.iter().filter(|edge| edge.1 == id) {
        let least = upstream.entry(*from).or_insert(*delay);
        *least = (*delay).min(*least);
    }
    Plan {
        upstream: upstream.into_iter().collect(),
        downstream: edges.iter().filter(|edge| edge.0 == id).map(|edge| (edge.1, edge.2)).collect(),
        events,
        end: END,
        honours_dnet,
        dies: false,
    }
}

/// Returns a connection, an event on it, and bytes for it.
fn any_step() -> impl Strategy<Value = (usize, usize, Vec<u8>)> {
    (0..5usize, 0..4usize, proptest::collection::vec(any::<u8>(), 1..60))
}

struct Run {
    rig: Rig,
    peers: Vec<Peer>,
    random: Random,
}

impl Run {
    fn new(case: Case) -> Self {
        let Case { plans, seed, in_transit, output, window } = case;
        let federates = plans.len();
        let sizes = Sizes { federates, connections: federates, upstream: federates, in_transit, output };
        let mut rig = Rig::new(Config { window, ..config() }, sizes);
        let peers = plans.into_iter().zip(0u16..).map(|(plan, id)| Peer::new(id, plan, rig.connect(), FEDERATION));
        let peers = peers.collect();
        Self { rig, peers, random: Random::new(seed) }
    }

    /// Lets one peer do one thing. Returns whether it did.
    fn act(&mut self, peer: usize, what: usize, amount: usize) -> bool {
        let Self { rig, peers, random } = self;
        let peer = &mut peers[peer];
        match what {
            0 => peer.step(&mut |max| random.index(max)),
            1 => {
                let wire = &rig.outlet.list[peer.connection.0];
                let amount = amount.min(peer.outbox.len());
                if amount == 0 || wire.blocked.is_some() || !wire.open {
                    return false;
                }
                let bytes: Vec<u8> = peer.outbox.drain(..amount).collect();
                rig.send(peer.connection, &bytes);
                true
            }
            2 => {
                let bytes = rig.take(peer.connection, amount);
                peer.read(&bytes);
                !bytes.is_empty()
            }
            _ => {
                let wire = &rig.outlet.list[peer.connection.0];
                let may_close = peer.outbox.is_empty() && wire.incoming.is_empty() && peer.left;
                let close = wire.open && may_close && (peer.plan.dies || (wire.ended && wire.outgoing.is_empty()));
                if close {
                    rig.close(peer.connection);
                }
                close
            }
        }
    }

    /// Runs until no federate does anything any more.
    fn run_out(&mut self) {
        loop {
            for _ in 0..50 {
                let (peer, what) = (self.random.index(self.peers.len()), self.random.index(4));
                let amount = 1 + self.random.index(60);
                self.act(peer, what, amount);
            }
            let all = (0..self.peers.len()).flat_map(|peer| (0..4).map(move |what| (peer, what)));
            let done = all.fold(false, |done, (peer, what)| self.act(peer, what, 10_000) || done);
            if !done {
                return;
            }
        }
    }

    fn check_that_all_is_done(&self) {
        for peer in &self.peers {
            assert!(peer.left, "federate {} waits without end; {:#?}", peer.id, self.rig.outlet.log_events);
        }
        let late = self.rig.outlet.log_events.iter().find(|event| event.contains(" late"));
        assert_eq!(late, None);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// With so little memory for messages in transit that it is always too little.
    #[test]
    fn acyclic_federations_run_to_their_end(case in case(false)) {
        let mut run = Run::new(case);
        run.run_out();
        run.check_that_all_is_done();
        let sum = |count: fn(&Peer) -> usize| run.peers.iter().map(count).sum::<usize>();
        prop_assert_eq!(sum(|peer| peer.sent), sum(|peer| peer.received));
        prop_assert_eq!(run.rig.rti.status(), Status::Finished(Outcome::Complete));
    }

    #[test]
    fn cycles_with_delays_run_to_their_end(case in case(true)) {
        let mut run = Run::new(case);
        run.run_out();
        run.check_that_all_is_done();
        prop_assert_eq!(run.rig.rti.status(), Status::Finished(Outcome::Complete));
    }

    /// A federate that dies somewhere in the middle holds no other up.
    #[test]
    fn the_others_go_on_when_one_dies(mut case in case(false), who in any::<prop::sample::Index>(), end in 0..END) {
        let who = who.index(case.plans.len());
        case.plans[who].dies = true;
        case.plans[who].end = end;
        case.plans[who].events.retain(|event| *event < end);
        let mut run = Run::new(case);
        run.run_out();
        run.check_that_all_is_done();
        let lost = matches!(run.rig.rti.status(), Status::Finished(Outcome::Lost { federate, .. })
            if federate.index() == who);
        prop_assert!(lost, "{:?} {:#?}", run.rig.rti.status(), run.rig.outlet.log_events);
    }

    /// Whatever comes on connections, and whenever they come and go, the RTI neither panics nor sends beyond its room.
    #[test]
    fn any_bytes_are_survived(
        steps in proptest::collection::vec(any_step(), 0..60),
        joined in any::<bool>(),
    ) {
        let sizes = Sizes { federates: 3, connections: 5, upstream: 1, in_transit: 1, output: OUTPUT_MIN };
        let mut rig = Rig::new(config(), sizes);
        if joined {
            for id in 0..3u16 {
                let connection = rig.connect();
                let upstream = if id > 0 { vec![(id - 1, i64::MIN)] } else { vec![] };
                let plan = Plan { upstream, ..plan(&[], BTreeSet::new(), false, id) };
                let hello = Peer::new(id, plan, connection, FEDERATION).outbox;
                rig.send(connection, &hello);
                rig.take(connection, 10);
            }
        }
        for (index, what, bytes) in steps {
            let connection = lf_coordination::rti::ConnectionId(index);
            let open = rig.outlet.list[index].open;
            match what {
                0 if open => rig.close(connection),
                0 | 1 if rig.outlet.list.iter().any(|wire| !wire.open && wire.outgoing.is_empty()) => {
                    rig.connect();
                }
                2 => drop(rig.take(connection, bytes.len())),
                _ if open && rig.outlet.list[index].blocked.is_none() => {
                    // A plausible type makes the rest be taken seriously.
                    let mut bytes = bytes;
                    bytes[0] = [bytes[0], 1, 2, 5, 6, 9, 10, 11, 13, 23, 24, 4][usize::from(bytes[0]) % 12];
                    rig.send(connection, &bytes);
                }
                _ => rig.now = Instant::from_nanos(rig.now.as_nanos() + 3_000_000_000),
            }
            let now = rig.now;
            if rig.rti.poll_timeout().is_due(now) {
                rig.rti.handle_timeout(now, &mut rig.outlet);
                prop_assert!(!rig.rti.poll_timeout().is_due(now));
            }
        }
    }
}
