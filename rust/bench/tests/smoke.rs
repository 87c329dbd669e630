// SPDX-License-Identifier: Apache-2.0
//! The federates of the measurements run against our RTI, in this process. No test here looks at durations.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use lf_bench::{Access, FEDERATION, Graph, Load, Shape, Swarm, rti_latency, write_keys};
use lf_linux::Credentials;
use lf_linux::rti::{Options, Outcome, serve};

const PERIOD_NS: i64 = 1_000_000;

/// Runs the RTI in a thread while `federates` use it.
fn with_rti(count: u16, is_encrypted: bool, federates: impl FnOnce(Access)) {
    let mut options = Options::new(count, FEDERATION);
    let folder = tempfile::tempdir().expect("a temporary folder");
    if is_encrypted {
        write_keys(folder.path(), count).expect("they can be written");
        options.credentials = Credentials::Keys(folder.path().to_owned());
    }
    let (told, port) = mpsc::channel();
    let rti = thread::spawn(move || {
        serve(&options, |port| told.send(port).expect("the test waits for it")).expect("it listens")
    });
    federates(Access { port: port.recv().expect("the RTI listens"), is_encrypted });
    assert_eq!(rti.join().expect("the RTI does not panic"), Outcome::Complete);
}

fn run(shape: Shape, count: u16, rounds: u64, is_encrypted: bool) {
    let graph = Graph::new(shape, count, PERIOD_NS);
    let load = Load { period_ns: PERIOD_NS, messages: 2, rounds_ahead: 4 };
    with_rti(count, is_encrypted, |rti| {
        let mut swarm = Swarm::join(rti, &graph, load).expect("all can join");
        let traffic = swarm.run(Duration::MAX, rounds).expect("the RTI keeps the rules");
        assert!(traffic.messages >= 2 * graph.edges.len() as u64 * (rounds - 1), "{traffic:?}");
        assert!(traffic.grants > 0, "{traffic:?}");
        swarm.stop().expect("all can stop");
    });
}

#[test]
fn federations_of_every_shape_run_and_stop() {
    run(Shape::Pairs, 4, 20, false);
    run(Shape::Chain, 5, 20, false);
    run(Shape::Star, 6, 20, false);
    run(Shape::Random, 12, 20, false);
}

#[test]
fn encrypted_federations_run_and_stop() {
    run(Shape::Pairs, 4, 20, true);
    run(Shape::Random, 12, 20, true);
}

#[test]
fn each_exchange_is_a_sample() {
    for is_encrypted in [false, true] {
        with_rti(2, is_encrypted, |rti| {
            let latency = rti_latency(rti, 10).expect("the RTI answers");
            assert!(latency.grant.percentile(99) >= latency.grant.percentile(50));
            assert!(latency.message.percentile(50) > Duration::ZERO);
        });
    }
}
