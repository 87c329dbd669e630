// SPDX-License-Identifier: Apache-2.0
//! The first seeds violate nothing, and one seed is one run. `cargo xtask simulate` runs many more.

use std::ops::Range;

use lf_simulator::{Coordination, RICH};

/// The hash of each run.
fn run(coordination: Coordination, seeds: Range<u64>) -> Vec<u64> {
    lf_simulator::try_seeds(coordination, seeds).unwrap_or_else(|violation| panic!("{violation}"))
}

fn hold(coordination: Coordination, seeds: &[u64]) {
    for seed in seeds {
        run(coordination, *seed..*seed + 1);
    }
}

/// Whatever the program, the network, the clocks and the faults.
#[test]
fn the_first_seeds_violate_nothing() {
    run(Coordination::Centralized, 0..150);
}

/// The same with decentralized coordination: with waits that suffice nothing is late; else all that is late is
/// reported.
#[test]
fn the_first_decentralized_seeds_violate_nothing() {
    run(Coordination::Decentralized, 0..150);
}

/// The same with banks, multiports, modes and watchdogs.
#[test]
fn the_first_rich_seeds_violate_nothing() {
    for coordination in [Coordination::Centralized, Coordination::Decentralized] {
        run(coordination, RICH..RICH + 150);
    }
}

/// Side by side, an action of a mode that was not active was put back into the event queue.
#[test]
fn what_stands_still_with_its_mode_stays_so_side_by_side() {
    hold(Coordination::Centralized, &[RICH + 30540]);
}

/// A reaction to `shutdown` in a mode that had been left, and one of the mode that was active, ran in another order
/// than unfederated.
#[test]
fn what_runs_at_the_last_tag_of_two_modes_has_an_order() {
    hold(Coordination::Centralized, &[4_385_969_817, 4_385_993_112, 4_505_064_257]);
}

/// A federate that had left still had messages that waited for room, and its other inputs were waited for for ever; and
/// the rest of a message was waited for that had no room behind such messages.
#[test]
fn messages_without_room_hold_up_nobody() {
    hold(Coordination::Decentralized, &[201, 104, 332, 349, 262]);
}

/// A delay had given two messages one tag, and the second one was late though the microstep waited for it.
#[test]
fn a_second_message_for_one_tag_is_waited_for() {
    hold(Coordination::Decentralized, &[283]);
}

/// What came in pieces after the last tag was read in part only.
#[test]
fn late_messages_are_reported_to_the_last() {
    hold(Coordination::Decentralized, &[5, 108]);
}

/// Several messages had come for one tag, and the last of them behind the stop.
#[test]
fn who_comes_behind_others_of_its_tag_may_be_late_at_a_stop() {
    hold(Coordination::Decentralized, &[26145]);
}

/// A wait was over before all had agreed on the stop tag, at which nobody could send before.
#[test]
fn what_is_sent_at_a_stop_that_is_agreed_late_happens_there() {
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

/// Federates of a circle held each other up, for their queues were too small for what was sent; in the second one they
/// also held up another one.
#[test]
fn a_circle_of_full_queues_ends_with_an_error() {
    hold(Coordination::Decentralized, &[27347, 40808]);
}

/// A federate that had resigned closed its connection while the RTI had not read all, because the receiver was slow.
#[test]
fn who_has_resigned_waits_for_a_slow_reader() {
    hold(Coordination::Centralized, &[2697, 4508]);
}

/// Members of a cycle without delay had been granted more than the stop tag, and did not wait for each other there;
/// what they had been granted was looked at again behind what took it back; and a message of that tag had no room.
#[test]
fn the_last_words_of_a_cycle_are_heard() {
    hold(Coordination::Centralized, &[118, 2234, 6404, 7584, 12863, 17537]);
}

/// A stop was withheld from a federate whose next event was in an overflow range, and that federate held up the one
/// that it waited for.
#[test]
fn what_is_unclear_does_not_hold_up_a_stop() {
    hold(Coordination::Centralized, &[7901, 19770]);
}

/// Output waited for a federate that waited for room for its own, and a DNET for a federate that was held up.
#[test]
fn nobody_waits_in_a_circle() {
    hold(Coordination::Centralized, &[4698, 27514]);
}

/// A federate was lost on which another one of its cycle waited, though its other inputs were known.
#[test]
fn who_waits_for_a_lost_federate_of_its_cycle_goes_on() {
    hold(Coordination::Centralized, &[65362]);
}

/// A queue too small for what was sent closed a circle of federates that waited for room and for each other's tags.
/// One of them ended with an error after a minute, but the check had taken the rounds of clock synchronization
/// meanwhile for a federation that does not get on.
#[test]
fn a_circle_of_no_room_and_held_messages_ends_with_an_error() {
    hold(Coordination::Centralized, &[4_505_077_301]);
}

/// A federate was lost on which another one waited at a tag, and others on that: they were still in a cycle without the
/// lost one, so that no grant could say that nothing comes from there.
#[test]
fn who_waits_for_a_lost_federate_in_what_is_left_of_its_cycle_goes_on() {
    hold(Coordination::Centralized, &[4_504_975_004, 4_505_071_494]);
}

/// The check took the port numbers of inputs for their places, which are others behind a connection of a federate to
/// itself; so it did not see that more messages came for one tag than the program's `@capacity` holds.
#[test]
fn bursts_are_counted_by_input_where_a_federate_is_connected_to_itself() {
    hold(Coordination::Centralized, &[4_505_058_212]);
}

/// A federate failed at the stop tag, and the check took what it sends there as sent, for it had told a later event
/// before it named that tag.
#[test]
fn what_a_federate_that_fails_sends_at_a_stop_may_be_missing() {
    hold(Coordination::Centralized, &[4_505_272_640]);
}

/// A federate was lost while the RTI held its messages and waited for its answer to a stop, and they were dropped.
#[test]
fn what_a_lost_federate_has_said_arrives_though_all_are_stopping() {
    hold(Coordination::Centralized, &[5_017_221]);
}

/// The RTI had closed its port for rounds of clock synchronization, and woke up for them again and again until the last
/// connection had ended.
#[test]
fn the_rti_rests_while_it_waits_for_the_last_connections() {
    hold(Coordination::Centralized, &[8793]);
}

/// `keepalive` kept a federate for which nobody could make an event any more.
#[test]
fn nobody_stays_for_events_that_cannot_come() {
    hold(Coordination::Centralized, &[91_027_817, 4_504_997_904]);
}

/// The hash of all that was written, when and where, and of all that reactions saw, is the same in a second run.
#[test]
fn a_seed_is_a_run_bit_for_bit() {
    for coordination in [Coordination::Centralized, Coordination::Decentralized] {
        assert_eq!(run(coordination, 0..40), run(coordination, 0..40));
    }
}
