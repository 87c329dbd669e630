// SPDX-License-Identifier: Apache-2.0
//! The check passes for all graphs of up to three federates, and for some of four.

use lf_model_check::{Bounds, Delay, Graph, Report, all_graphs, check, some_graphs};

/// Checks all these graphs, and prints the violation of the first that has one.
fn check_all(graphs: impl Iterator<Item = Graph>, bounds: Bounds, orders_max: usize) -> Report {
    let mut report = Report::default();
    for graph in graphs {
        report.add(check(graph, bounds, orders_max));
        if let Some(finding) = report.findings.first() {
            panic!("{:?}, ranks {:?}, {bounds:?}\n{}", finding.graph, finding.ranks, finding.counterexample);
        }
    }
    println!("{} models, {} states, at most {} in one", report.models, report.states, report.states_max);
    report
}

#[test]
fn two_federates_at_length() {
    for dnet in [true, false] {
        let bounds = Bounds { messages_max: 3, own_events_max: 2, dnet, ..Bounds::default() };
        let graphs = (1..=2).flat_map(all_graphs);
        assert_eq!(check_all(graphs, bounds, usize::MAX).models, 11);
    }
}

#[test]
fn two_federates_over_two_ticks() {
    let bounds = Bounds { time_max: 2, messages_max: 2, own_events_max: 2, ..Bounds::default() };
    check_all(all_graphs(2), bounds, usize::MAX);
}

/// Each federate may be lost at any point, in all orders.
#[test]
fn two_federates_of_which_one_is_lost() {
    let bounds = Bounds { losses_max: 1, messages_max: 2, ..Bounds::default() };
    check_all(all_graphs(2), bounds, usize::MAX);
}

/// Each of two federates is transient: it may be absent at the start, leave in order, be lost, and come, at any point.
#[test]
fn two_federates_of_which_one_comes_and_goes() {
    for (transient, dnet) in [(0, true), (0, false), (1, true), (1, false)] {
        let transient = Some(transient);
        let bounds = Bounds { transient, comings_max: 1, losses_max: 1, messages_max: 1, dnet, ..Bounds::default() };
        check_all(all_graphs(2), bounds, usize::MAX);
    }
}

/// Each of two federates is transient, and a second instance of it may come while the first is there; and one may be
/// lost, or leave by itself.
#[test]
fn two_federates_of_which_one_is_swapped() {
    for (transient, losses_max) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let transient = Some(transient);
        let bounds = Bounds { comings_max: 1, swaps: true, losses_max, messages_max: 1, ..Bounds::default() };
        check_all(all_graphs(2), Bounds { transient, ..bounds }, usize::MAX);
    }
}

/// Swaps open and close cycles without delay, as in the last one of these graphs.
#[test]
fn some_of_three_federates_of_which_one_is_swapped() {
    use Delay::{Tick, Zero};
    for transient in 0..3 {
        let transient = Some(transient);
        let closing = Graph::new(3, &[(0, 2, Zero), (1, 2, Tick), (2, 0, Zero)]);
        let graphs = some_graphs(3, 1).filter(|graph| !graph.has_microstep_delay()).take(8).chain([closing]);
        let bounds = Bounds { messages_max: 1, own_events_max: 0, microstep_max: 0, ..Bounds::default() };
        check_all(graphs, Bounds { transient, comings_max: 1, swaps: true, ..bounds }, 1);
    }
}

/// A federate that sends to itself.
#[test]
fn connections_to_oneself() {
    for delay in [Delay::Zero, Delay::Microstep, Delay::Tick] {
        let bounds = Bounds { messages_max: 4, own_events_max: 2, ..Bounds::default() };
        let alone = Graph::new(1, &[(0, 0, delay)]);
        let beside = Graph::new(2, &[(0, 0, delay), (0, 1, Delay::Zero), (1, 0, Delay::Tick)]);
        check_all([alone, beside].into_iter(), bounds, usize::MAX);
    }
}

/// Messages have to wait as soon as one tag with a message is before their receiver.
#[test]
fn messages_that_have_to_wait() {
    let bounds = Bounds { time_max: 2, messages_max: 3, own_events_max: 2, window: 1, ..Bounds::default() };
    let waiting = check_all(all_graphs(2), bounds, usize::MAX).states;
    let passing = check_all(all_graphs(2), Bounds { window: 16, ..bounds }, usize::MAX).states;
    assert_ne!(waiting, passing, "some have to wait");
    let bounds = Bounds { messages_max: 2, own_events_max: 0, window: 1, ..Bounds::default() };
    check_all(all_graphs(3).step_by(2), bounds, 1);
}

#[test]
fn three_federates_with_events_of_their_own() {
    let bounds = Bounds { messages_max: 1, own_events_max: 1, ..Bounds::default() };
    check_all(all_graphs(3), bounds, 1);
}

#[test]
fn three_federates_with_more_messages() {
    let bounds = Bounds { messages_max: 2, own_events_max: 0, ..Bounds::default() };
    check_all(all_graphs(3), bounds, 2);
}

#[test]
fn three_federates_without_downstream_next_events() {
    let bounds = Bounds { messages_max: 2, own_events_max: 0, dnet: false, ..Bounds::default() };
    check_all(all_graphs(3), bounds, 1);
}

#[test]
fn some_of_three_federates_of_which_one_is_lost() {
    let bounds = Bounds { losses_max: 1, messages_max: 1, own_events_max: 0, ..Bounds::default() };
    check_all(some_graphs(3, 1).take(20), bounds, 1);
}

#[test]
fn some_of_four_federates() {
    let bounds = Bounds { messages_max: 1, own_events_max: 0, ..Bounds::default() };
    check_all(some_graphs(4, 1).take(60), bounds, 1);
}

#[test]
fn some_of_three_federates_of_which_one_comes_and_goes() {
    for transient in 0..3 {
        let transient = Some(transient);
        let bounds = Bounds { messages_max: 1, own_events_max: 0, microstep_max: 0, ..Bounds::default() };
        let bounds = Bounds { transient, comings_max: 1, losses_max: 1, ..bounds };
        check_all(some_graphs(3, 1).filter(|graph| !graph.has_microstep_delay()).take(4), bounds, 1);
    }
}

/// Two federates of a cycle wait at one tag for the same one, of which the RTI once remembered only the first; and that
/// one, once granted the tag, completed it without a message.
#[test]
fn several_wait_for_one() {
    use Delay::{Microstep, Tick, Zero};
    let connections = [
        (0, 2, Zero),
        (0, 3, Tick),
        (1, 0, Tick),
        (1, 3, Microstep),
        (2, 0, Microstep),
        (2, 1, Zero),
        (2, 3, Zero),
        (3, 0, Zero),
        (3, 1, Zero),
        (3, 2, Microstep),
    ];
    let bounds = Bounds { messages_max: 1, own_events_max: 0, ..Bounds::default() };
    check_all([Graph::new(4, &connections)].into_iter(), bounds, 2);
}

/// A federate of a cycle without delay is lost while the other waits for its message, or before that.
#[test]
fn the_other_one_of_a_cycle_is_lost() {
    use Delay::{Tick, Zero};
    let connections = [(0, 2, Zero), (1, 0, Tick), (1, 2, Tick), (2, 0, Zero), (2, 1, Zero)];
    let bounds = Bounds { losses_max: 1, messages_max: 1, own_events_max: 0, ..Bounds::default() };
    check_all([Graph::new(3, &connections)].into_iter(), bounds, 1);
}

/// A federate is upstream of a cycle without delay and of a federate outside: the next event of that one must not make
/// it silent. Only five federates show it: a fifth sends into the cycle.
#[test]
fn who_leads_to_a_cycle_without_delay_does_not_fall_silent() {
    let connections = [(0, 2), (1, 2), (2, 3), (3, 2), (1, 4)].map(|(from, to)| (from, to, Delay::Zero));
    let bounds = Bounds { messages_max: 1, own_events_max: 2, microstep_max: 0, ..Bounds::default() };
    check_all([Graph::new(5, &connections)].into_iter(), bounds, 1);
}

#[test]
fn some_of_five_federates() {
    let bounds = Bounds { messages_max: 1, own_events_max: 0, microstep_max: 0, ..Bounds::default() };
    check_all(some_graphs(5, 1).filter(|graph| !graph.has_microstep_delay()).take(2), bounds, 1);
}
