// SPDX-License-Identifier: Apache-2.0
//! The federates of the measurements run against our RTI, in this process. No test here looks at durations.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use lf_bench::{FEDERATION, Graph, Load, Shape, Swarm, rti_latency};
use lf_linux::rti::{Options, Outcome, serve};

const PERIOD_NS: i64 = 1_000_000;

/// Runs the RTI in a thread while `federates` use it.
fn with_rti(count: u16, federates: impl FnOnce(u16)) {
    let options = Options::new(count, FEDERATION);
    let (told, port) = mpsc::channel();
    let rti = thread::spawn(move || {
        serve(&options, |port| told.send(port).expect("the test waits for it")).expect("it listens")
    });
    federates(port.recv().expect("the RTI listens"));
    assert_eq!(rti.join().expect("the RTI does not panic"), Outcome::Complete);
}

fn run(shape: Shape, count: u16, rounds: u64) {
    let graph = Graph::new(shape, count, PERIOD_NS);
    let load = Load { period_ns: PERIOD_NS, messages: 2, rounds_ahead: 4 };
    with_rti(count, |port| {
        let mut swarm = Swarm::join(port, &graph, load).expect("all can join");
        let traffic = swarm.run(Duration::MAX, rounds).expect("the RTI keeps the rules");
        assert!(traffic.messages >= 2 * graph.edges.len() as u64 * (rounds - 1), "{traffic:?}");
        assert!(traffic.grants > 0, "{traffic:?}");
        swarm.stop().expect("all can stop");
    });
}

#[test]
fn federations_of_every_shape_run_and_stop() {
    run(Shape::Pairs, 4, 20);
    run(Shape::Chain, 5, 20);
    run(Shape::Star, 6, 20);
    run(Shape::Random, 12, 20);
}

#[test]
fn each_exchange_is_a_sample() {
    with_rti(2, |port| {
        let latency = rti_latency(port, 10).expect("the RTI answers");
        assert!(latency.grant.percentile(99) >= latency.grant.percentile(50));
        assert!(latency.message.percentile(50) > Duration::ZERO);
    });
}
