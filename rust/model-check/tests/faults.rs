// SPDX-License-Identifier: Apache-2.0
//! The check finds injected faults; the reduction does not change its verdict.

use lf_model_check::{Bounds, Delay, Fault, Graph, all_graphs, check};

fn small() -> Bounds {
    Bounds { messages_max: 1, own_events_max: 1, ..Bounds::default() }
}

/// Returns whether a message arrived too late, and whether a federate waits without end.
fn wrong(graph: Graph, bounds: Bounds) -> (bool, bool) {
    let findings = check(graph, bounds, usize::MAX).findings;
    let is =
        |what: &str| findings.iter().any(|finding| finding.counterexample.starts_with(&format!("violated: {what}")));
    (is("no violation"), is("every event is handled"))
}

#[test]
fn delays_that_are_too_long_break_promises() {
    for delay in [Delay::Zero, Delay::Microstep] {
        let graph = Graph::new(2, &[(0, 1, delay)]);
        assert!(wrong(graph, Bounds { fault: Some(Fault::DelaysTooLong), ..small() }).0, "{graph:?}");
    }
}

#[test]
fn messages_behind_the_next_event_come_too_late() {
    let graph = Graph::new(2, &[(0, 1, Delay::Zero)]);
    assert!(wrong(graph, Bounds { fault: Some(Fault::LateMessages), ..small() }).0);
}

/// Only LTC removes a message from those in transit.
#[test]
fn without_completion_a_federate_waits_forever() {
    let graph = Graph::new(3, &[(0, 1, Delay::Zero), (1, 2, Delay::Zero), (2, 1, Delay::Tick)]);
    assert!(wrong(graph, Bounds { fault: Some(Fault::NoCompletion), ..small() }).1);
}

#[test]
fn without_word_of_absence_a_cycle_without_delay_waits_for_ever() {
    let graph = Graph::new(2, &[(0, 1, Delay::Zero), (1, 0, Delay::Zero)]);
    assert!(wrong(graph, Bounds { fault: Some(Fault::NoAbsence), ..small() }).1);
}

/// The instance that comes waits for it.
#[test]
fn an_instance_that_does_not_make_way_holds_up_its_successor() {
    let graph = Graph::new(2, &[(0, 1, Delay::Zero)]);
    let bounds = Bounds { transient: Some(0), comings_max: 1, swaps: true, fault: Some(Fault::Stays), ..small() };
    assert!(wrong(graph, bounds).1);
}

/// The check finds the same with and without the reduction, whatever the fault, and with it in fewer states.
#[test]
fn the_reduction_hides_nothing() {
    let faults = [Fault::DelaysTooLong, Fault::NoCompletion, Fault::NoAbsence, Fault::LateMessages];
    for fault in faults.into_iter().map(Some).chain([None]) {
        for graph in all_graphs(2) {
            let reduced = Bounds { fault, ..small() };
            let full = Bounds { reduced: false, ..reduced };
            assert_eq!(wrong(graph, reduced), wrong(graph, full), "{graph:?}, {fault:?}");
            assert!(check(graph, reduced, 1).states <= check(graph, full, 1).states || fault.is_some());
        }
    }
}
