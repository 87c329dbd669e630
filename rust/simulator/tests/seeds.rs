// SPDX-License-Identifier: Apache-2.0
//! The first seeds violate no invariant, and one seed is one run. `cargo xtask simulate` runs many more.

use std::ops::Range;

use lf_simulator::{Coordination, Kind, RICH};

/// Returns the hash of each run.
fn run(kind: impl Into<Kind>, seeds: Range<u64>) -> Vec<u64> {
    lf_simulator::try_seeds(kind.into(), seeds).unwrap_or_else(|violation| panic!("{violation}"))
}

fn hold(kind: impl Into<Kind> + Copy, seeds: &[u64]) {
    for seed in seeds {
        run(kind, *seed..*seed + 1);
    }
}

/// Runs seeds with any program, network, clocks and faults.
#[test]
fn the_first_seeds_violate_nothing() {
    run(Coordination::Centralized, 0..150);
}

/// Does the same with decentralized coordination: if the waits suffice, nothing is late; else all late messages are
/// reported.
#[test]
fn the_first_decentralized_seeds_violate_nothing() {
    run(Coordination::Decentralized, 0..150);
}

/// Does the same with banks, multiports, modes and watchdogs.
#[test]
fn the_first_rich_seeds_violate_nothing() {
    for coordination in [Coordination::Centralized, Coordination::Decentralized] {
        run(coordination, RICH..RICH + 150);
    }
}

const COMINGS: Kind = Kind { coordination: Coordination::Centralized, comings: true };
const DECENTRALIZED_COMINGS: Kind = Kind { coordination: Coordination::Decentralized, comings: true };

/// Federates come, leave, vanish, come back and are replaced at any moment.
#[test]
fn the_first_seeds_with_comings_and_goings_violate_nothing() {
    for kind in [COMINGS, DECENTRALIZED_COMINGS] {
        run(kind, 0..60);
        run(kind, RICH..RICH + 15);
    }
}

/// A federate that was told to stop between two tags sent something at a tag before the event that it had announced.
#[test]
fn one_that_is_told_to_stop_sends_nothing_before_its_announced_event() {
    hold(COMINGS, &[4, 23, 29, 46]);
}

/// A physical action made a federate leave by itself, and its last message came before the event that it had announced.
#[test]
fn a_physical_action_can_end_a_federate_that_then_sends_its_last_messages() {
    hold(COMINGS, &[12963]);
}

/// A federate that was told to stop said nothing at its last tag, not even to those that were there provisionally.
#[test]
fn one_that_is_told_to_stop_lets_a_cycle_go_on() {
    hold(COMINGS, &[13448, 14298]);
}

/// A federate looked without a pause for one peer while it waited for the answer of another.
#[test]
fn one_peer_is_looked_for_at_a_time() {
    hold(DECENTRALIZED_COMINGS, &[8359]);
}

/// A federate that had failed counted as heard until its connection ended.
#[test]
fn one_that_has_failed_makes_way_for_another_instance() {
    hold(COMINGS, &[14434]);
}

/// A signal had stopped a federate that the RTI had accepted and that knew no first tag yet; it reported a failure, and
/// the federation counted as failed.
#[test]
fn one_that_is_stopped_while_it_joins_has_not_failed() {
    hold(COMINGS, &[19, 122, 132]);
}

/// A federate that had resigned before it knew its first tag took the long form of TIMESTAMP for the short one.
#[test]
fn an_effective_start_may_come_too_late() {
    hold(COMINGS, &[4223, 7144]);
}

/// A persistent federate had left at its last tag, and one upstream of others that led to it joined before that tag.
#[test]
fn one_joins_after_the_last_tags_of_those_that_have_left() {
    hold(COMINGS, &[3872]);
}

/// A federate had joined a cycle without delay, and others waited for it at a tag before its first one.
#[test]
fn nobody_waits_for_one_that_begins_later() {
    hold(COMINGS, &[7562]);
}

/// A federate that joined asked for the address of a persistent one that had left, without end.
#[test]
fn one_whose_receiver_has_left_is_refused() {
    hold(DECENTRALIZED_COMINGS, &[23, 31, 41]);
}

/// A federate that joined waited for a persistent one that had left before, and never connected.
#[test]
fn one_that_joins_waits_for_nobody_who_has_left() {
    hold(DECENTRALIZED_COMINGS, &[802, 1208, 1588, 3103]);
}

/// The last messages of a federate that was told to stop were for a tag of long ago, and made others late.
#[test]
fn one_that_is_told_to_stop_does_so_at_the_physical_time() {
    hold(DECENTRALIZED_COMINGS, &[46, 890, 1093]);
}

/// In parallel execution, an action of an inactive mode was put back into the event queue.
#[test]
fn triggers_of_an_inactive_mode_stay_inactive_in_parallel_execution() {
    hold(Coordination::Centralized, &[RICH + 30540]);
}

/// A reaction to `shutdown` in a mode that had been left, and one of the mode that was active, ran in another order
/// than unfederated.
#[test]
fn reactions_of_two_modes_at_the_last_tag_have_an_order() {
    hold(Coordination::Centralized, &[4_385_969_817, 4_385_993_112, 4_505_064_257]);
}

/// A federate that had left still had messages that waited for room, and the wait for its other inputs never ended; and
/// the rest of a message that had no room behind such messages was awaited.
#[test]
fn messages_without_room_block_no_federate() {
    hold(Coordination::Decentralized, &[201, 104, 332, 349, 262]);
}

/// A delay had given two messages one tag, and the second one was late though the microstep waited for it.
#[test]
fn a_second_message_for_one_tag_is_waited_for() {
    hold(Coordination::Decentralized, &[283]);
}

/// Messages that arrived in pieces after the last tag were read in part only.
#[test]
fn late_messages_are_reported_to_the_last() {
    hold(Coordination::Decentralized, &[5, 108]);
}

/// Several messages had arrived for one tag, and the last of them after the stop.
#[test]
fn a_message_behind_others_of_its_tag_may_be_late_at_a_stop() {
    hold(Coordination::Decentralized, &[26145]);
}

/// A wait ended before all had agreed on the stop tag, at which no federate could send earlier.
#[test]
fn messages_at_a_stop_that_is_agreed_late_are_handled_there() {
    hold(Coordination::Decentralized, &[37, 2341, 3819, 5165]);
}

/// While a federate waited, its queues were full for so long that a sender was late elsewhere.
#[test]
fn queues_hold_what_comes_during_a_wait() {
    hold(Coordination::Decentralized, &[25600]);
}

/// A turn of many tags was longer than what any of them had to wait for.
#[test]
fn waits_reckon_with_long_turns() {
    hold(Coordination::Decentralized, &[30353]);
}

/// Federates of a circle blocked each other, because their queues were too small; in the second one they also blocked
/// another federate.
#[test]
fn a_circle_of_full_queues_ends_with_an_error() {
    hold(Coordination::Decentralized, &[27347, 40808]);
}

/// A federate that had resigned closed its connection while the RTI had not read all messages, because the receiver was
/// slow.
#[test]
fn a_resigned_federate_waits_for_a_slow_reader() {
    hold(Coordination::Centralized, &[2697, 4508]);
}

/// Members of a cycle without delay had been granted more than the stop tag, and did not wait for each other there; the
/// check saw their grants again after the message that withdrew them; and a message of that tag had no room.
#[test]
fn the_last_words_of_a_cycle_are_heard() {
    hold(Coordination::Centralized, &[118, 2234, 6404, 7584, 12863, 17537]);
}

/// The RTI withheld a stop from a federate whose next event was in an overflow range, and that federate blocked the one
/// that it waited for.
#[test]
fn an_overflow_range_does_not_block_a_stop() {
    hold(Coordination::Centralized, &[7901, 19770]);
}

/// Output waited for a federate that waited for room for its own, and a DNET for a blocked federate.
#[test]
fn no_federates_wait_in_a_circle() {
    hold(Coordination::Centralized, &[4698, 27514]);
}

/// A federate was lost for which another one of its cycle waited, though its other inputs were known.
#[test]
fn a_wait_for_a_lost_federate_of_the_same_cycle_ends() {
    hold(Coordination::Centralized, &[65362]);
}

/// A queue that was too small closed a circle of federates that waited for room and for each other's tags. One of them
/// ended with an error after a minute, but the check had mistaken the rounds of clock synchronization for a federation
/// without progress.
#[test]
fn a_circle_of_no_room_and_held_messages_ends_with_an_error() {
    hold(Coordination::Centralized, &[4_505_077_301]);
}

/// A federate was lost for which another one waited at a tag, and others for that one: they were still in a cycle
/// without the lost one, so no grant could say that no message comes from there.
#[test]
fn a_wait_for_a_lost_federate_in_the_rest_of_its_cycle_ends() {
    hold(Coordination::Centralized, &[4_504_975_004, 4_505_071_494]);
}

/// The check took the port numbers of inputs for their indices, which differ behind a connection of a federate to
/// itself; so it did not see that more messages arrived for one tag than the program's `@capacity` holds.
#[test]
fn bursts_are_counted_by_input_where_a_federate_is_connected_to_itself() {
    hold(Coordination::Centralized, &[4_505_058_212]);
}

/// A federate failed at the stop tag, and the check counted its messages of that tag as sent, because it had announced
/// a later event before it proposed that tag.
#[test]
fn messages_of_a_failing_federate_at_a_stop_may_be_missing() {
    hold(Coordination::Centralized, &[4_505_272_640]);
}

/// A federate was lost while the RTI held its messages and waited for its answer to a stop, and they were dropped.
#[test]
fn messages_of_a_lost_federate_arrive_while_all_are_stopping() {
    hold(Coordination::Centralized, &[5_017_221]);
}

/// The RTI had closed its port for rounds of clock synchronization, and woke up for them again and again until the last
/// connection had ended.
#[test]
fn the_rti_rests_while_it_waits_for_the_last_connections() {
    hold(Coordination::Centralized, &[8793]);
}

/// `keepalive` kept a federate alive for which no more events could occur.
#[test]
fn no_federate_stays_for_events_that_cannot_occur() {
    hold(Coordination::Centralized, &[91_027_817, 4_504_997_904]);
}

/// The hash of all written bytes, with their times and places, and of all records of reactions, is the same in a second
/// run.
#[test]
fn a_seed_is_a_run_bit_for_bit() {
    for coordination in [Coordination::Centralized, Coordination::Decentralized] {
        for comings in [false, true] {
            let kind = Kind { coordination, comings };
            assert_eq!(run(kind, 0..40), run(kind, 0..40));
        }
    }
}

/// Messages of an earlier incarnation filled the queue of an input, of which a later incarnation had made unknown what
/// came before its own message. That was held, and nothing made room.
#[test]
fn a_held_message_of_a_later_incarnation_lets_those_of_the_earlier_one_happen() {
    hold(DECENTRALIZED_COMINGS, &[14185]);
}

/// A federate of a cycle without delay came while the others were at tags before its first one, and they waited for its
/// word that nothing comes there.
#[test]
fn nobody_waits_for_a_federate_before_its_first_tag() {
    hold(COMINGS, &[23999]);
}

/// A federate was granted a tag, and then another one closed the cycle that it is in: it passed by an earlier tag, and
/// nobody said so to the one that waited for it there.
#[test]
fn nobody_waits_for_a_federate_that_passes_by_a_tag() {
    hold(COMINGS, &[4_294_969_743]);
}

/// With one of several sources of a multiport replayed, each delay is still that of its connection; a source can stand
/// in a statement twice; and clock synchronization goes on while one waits for a minute until it gives up.
#[test]
fn rich_programs_come_and_go() {
    hold(COMINGS, &[4_294_967_356, 4_294_968_265, 4_294_979_539]);
}

/// A federate left once it had answered for a tag before its first one; only the reason of its leaving shows that.
#[test]
fn what_a_federate_says_before_its_first_tag_does_not_end_it() {
    hold(COMINGS, &[27596]);
}

/// A federate schedules more events for after its last tag than its queue holds, which nobody stores.
#[test]
fn what_an_incarnation_schedules_for_after_its_end_takes_no_room() {
    hold(COMINGS, &[58751]);
}

/// An instance that was ahead of the clock has vanished, and its successor sends for the same tags: its messages are
/// handled after all that the first one had sent, or between them.
#[test]
fn incarnations_ahead_of_the_clock_overlap_in_tags() {
    hold(DECENTRALIZED_COMINGS, &[66521, 90117]);
}
