// SPDX-License-Identifier: Apache-2.0
//! Programs that are not federated, in virtual time; and memory that is too small for a federate.

use crate::support::federation::{PORT, Plan, RTI, edge, federation_of};
use crate::support::node::{Behavior, Node, NodeStorage};
use lf_model::time::Interval;
use lf_model::{Engine, EngineStorage as _, Program as _, Settings};
use lf_runtime::platform::Endpoint;
use lf_runtime::{Buffers, FederateLoop, Join, RunError, UnfederatedLoop};
use lf_testkit::network::address_of;
use lf_testkit::world::{Conditions, Fault, LivenessViolation, Threads};

const MS: fn(i64) -> Interval = Interval::from_millis;

/// Runs a program alone; returns its outcome, when it ended, whether it shut down, and the violation of liveness.
fn run(
    behavior: Behavior,
    settings: Settings,
    interrupt: Option<i64>,
) -> (Result<(), RunError>, Interval, bool, Option<LivenessViolation>) {
    let world = Threads::new(Conditions::seeded(3));
    let mut platform = world.join(Interval::ZERO, Interval::ZERO);
    if let Some(at) = interrupt {
        world.plan(MS(at), platform.number(), Fault::Interrupt);
    }
    let thread = {
        let world = world.clone();
        std::thread::spawn(move || {
            platform.begin();
            let mut node = Node::<1>::new(behavior, platform.side(), &[], &[]);
            let mut storage = NodeStorage::new();
            let engine = Engine::new(node.tables(), &mut storage, settings);
            let result = UnfederatedLoop::new(&mut platform, &mut node, engine).run();
            (result, world.now(), node.ended)
        })
    };
    world.start();
    let (result, ended, shut_down) = thread.join().unwrap();
    (result, ended, shut_down, world.violation())
}

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((MS(10), MS(period))), ..Behavior::default() }
}

#[test]
fn a_time_out_is_waited_for() {
    let settings = Settings { timeout: Some(MS(55)), ..Settings::DEFAULT };
    assert_eq!(run(timer(10), settings, None), (Ok(()), MS(55), true, None));
    let fast = Settings { fast: true, ..settings };
    assert_eq!(run(timer(10), fast, None), (Ok(()), Interval::ZERO, true, None));
}

#[test]
fn without_events_it_ends_unless_it_is_kept_alive() {
    assert_eq!(run(timer(0), Settings::DEFAULT, None), (Ok(()), MS(10), true, None));
    let keepalive = Settings { keepalive: true, ..Settings::DEFAULT };
    let (result, _, shut_down, violation) = run(timer(0), keepalive, None);
    // It waits for nothing, which the world notes, and interrupts it.
    assert_eq!((result, shut_down, violation), (Err(RunError::Interrupted), true, Some(LivenessViolation::Deadlock)));
}

#[test]
fn an_interruption_still_runs_the_shutdown_reactions() {
    for keepalive in [false, true] {
        let settings = Settings { keepalive, ..Settings::DEFAULT };
        assert_eq!(run(timer(10), settings, Some(33)), (Err(RunError::Interrupted), MS(33), true, None));
    }
}

/// A federate whose buffers hold no message would wait forever; that is an error before it begins.
#[test]
fn a_buffer_without_room_for_a_message_is_an_error() {
    let edges = vec![edge(0, 1)];
    let plan = Plan::new(vec![timer(1), Behavior::default()], edges);
    let federation = federation_of(&plan, 0);
    for (input_bytes, output_bytes, which) in [(50, 500, "receive"), (500, 150, "send")] {
        let world = Threads::new(Conditions::seeded(0));
        let mut platform = world.join(Interval::ZERO, Interval::ZERO);
        world.start();
        platform.begin();
        let mut node = Node::<1>::new(timer(1), platform.side(), &[], &[(1, 0, None, false, false, None)]);
        let mut storage = NodeStorage::new();
        let engine = Engine::new(node.tables(), &mut storage, Settings::DEFAULT);
        let (mut input, mut output) = (vec![0; input_bytes], vec![0; output_bytes]);
        let join = Join { federation_id: b"virtual", rti: Endpoint::new(address_of(RTI), PORT), others: &[] };
        let buffers = Buffers::new(&mut input, &mut output);
        let made = FederateLoop::<_>::new(&mut platform, &mut node, engine, &federation, &join, buffers, &mut []);
        let error = made.map(|_| ()).unwrap_err();
        assert!(matches!(error, RunError::BufferTooSmall { buffer, .. } if buffer == which), "{error:?}");
    }
}
