// SPDX-License-Identifier: Apache-2.0
//! Centralized coordination as a whole: each program in `programs/centralized` runs as processes of their own, and the
//! output of its federates is the expected trace beside the program. `README.md` says which of LF's own tests each
//! covers.
//!
//! `cargo xtask bless -p lf-federations centralized::` rewrites the traces. With `LF_TEST_RTI` in the
//! environment the programs run with that RTI, which takes the stock RTI's options; the traces have to be the same.

use lf_federations::{Lfz, Run, programs};

/// Runs these programs, and compares their output.
fn check(names: &[&str]) {
    for (name, finished) in Lfz::run_all("centralized", names) {
        insta::with_settings!({
            snapshot_path => "../programs/centralized",
            prepend_module_to_snapshot => false,
            omit_expression => true,
        }, {
            insta::assert_snapshot!(name, finished.trace());
        });
    }
}

fn program(name: &str) -> std::path::PathBuf {
    programs().join("centralized").join(format!("{name}.lf"))
}

/// Messages without cycles: fan-in, fan-out, chains, several connections of one pair, inputs that are absent.
#[test]
fn messages_keep_their_tags() {
    check(&["Alternating", "FourSources", "TwoSources", "Interleaved", "FourChannels", "OneEach", "ParallelSinks"]);
    check(&["ParallelSources", "ParallelPairs", "TopLevel", "Unconnected", "DelayInside", "LogicalLongChain"]);
}

/// `after`, microsteps, and messages that share a time but not a tag.
#[test]
fn delays_and_microsteps_are_kept_across_federates() {
    check(&["CountAfter", "StepsApart", "SameTagTwice", "Bursts", "Switches", "OwnEcho", "ToItself"]);
}

#[test]
fn values_of_all_kinds_arrive_unchanged() {
    check(&["Texts", "Letters", "Greeting", "FixedArray", "ScaledArray", "Arrays", "Kinds"]);
}

/// The effects of a federate in its modes follow from tags alone, as in a program that is not federated.
#[test]
fn federates_have_modes() {
    check(&["ModalWorker"]);
}

/// Each federate has its share of the federated reactor's own contents.
#[test]
fn reactions_of_the_federated_reactor_run_in_federates() {
    check(&["OwnReactions"]);
}

/// A watchdog expires by logical time, so the effects on its federate and others follow from tags, too.
#[test]
fn federates_have_watchdogs() {
    check(&["Watchdogs"]);
}

/// The stop tag is the same for all, whichever federates request it, how often and when.
#[test]
fn all_federates_stop_at_one_tag() {
    check(&["StopTwice", "StopAtOnce", "StopInShutdown"]);
}

#[test]
fn deadlines_count_what_a_federate_upstream_takes() {
    check(&["Deadlines"]);
}

/// Federates downstream continue while the physical action upstream has no event, and miss none.
#[test]
fn physical_actions_upstream_hold_nobody_up() {
    check(&["PhysicalChain", "PhysicalLongChain", "PhysicalBehindAfter", "PhysicalParallelPaths", "PhysicalBursts"]);
}

/// Federates that wait for each other at one tag continue as soon as their reactions can: messages and absences within
/// the tag lead through the cycle.
#[test]
fn cycles_without_delay_work_through_each_tag() {
    check(&["ThereAndBack", "PingPong", "BroadcastBoth", "BroadcastInside", "Replicas", "TwiceThrough", "Twisted"]);
    check(&["Silent", "LoopedCount", "LoopedPorts"]);
}

/// A controller, its plant and a planner, with the one delay of a microstep in different places, or none.
#[test]
fn cycles_with_and_without_delay_share_federates() {
    check(&["PlanComesLater", "RequestComesLater", "RequestIsHandedOn", "PlanAtTheSameTag", "PlannerWithTimer"]);
    check(&["PlannerWithSource"]);
}

/// Reactions of one federate keep their order, even if a message of the same tag arrives between them.
#[test]
fn reactions_keep_their_order_within_a_cycle() {
    check(&["Loopers", "LoopersOtherOrder", "LoopersInOrder", "LoopersInside"]);
}

#[test]
fn federates_that_authenticate_work_together() {
    check(&["Authenticated"]);
}

#[test]
fn physical_actions_drive_a_cycle_without_delay() {
    check(&["LoopersFromThreads", "LoopersOnTwoPorts", "BothFromThreads", "CycleBesidePhysical"]);
}

/// `keepalive` does not keep a federate alive for which no participant can create an event: without neighbors, and
/// after all of these have left.
#[test]
fn no_federate_stays_for_events_that_cannot_come() {
    check(&["KeptForNobody"]);
}

/// Messages over physical connections go from federate to federate, and their receivers assign the tags.
#[test]
fn physical_connections_take_physical_time() {
    check(&["PhysicalCount", "PhysicalCountAfter", "PhysicalPingPong"]);
}

/// Of several paths from a physical action to an output, the shortest bounds a federate's promise.
#[test]
fn the_shortest_way_from_a_physical_action_counts() {
    let file = program("PhysicalDelayPaths");
    let mut command = Lfz::command(["plan"]);
    command.arg(&file);
    let plan = Run::start(command).succeed();
    let delays = plan.lines.iter().filter(|line| line.contains("least delay from a physical action"));
    let delays: Vec<&str> = delays.map(|line| line.trim()).collect();
    assert_eq!(delays, ["least delay from a physical action to another federate: 2 s"], "{plan}");
    check(&["PhysicalDelayPaths"]);
}

/// A value goes around a cycle of three within a tag, and a federate outside of it starts rounds too.
#[test]
fn a_cycle_of_three_is_passed_within_a_tag() {
    check(&["RoundTrip"]);
}

/// The stock RTI cannot run these shapes: it lets a federate of one cycle complete a tag at which another cycle may
/// still send to it, and it forgets a cycle that waited for a federate outside.
#[test]
fn cycles_may_be_linked_and_have_others_upstream() {
    if std::env::var_os("LF_TEST_RTI").is_none() {
        check(&["LinkedCycles", "UpstreamOutside"]);
    }
}
