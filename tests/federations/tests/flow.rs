// SPDX-License-Identifier: Apache-2.0
//! Senders that are faster than their receivers, as processes: everything arrives, in order, and no process is killed.

use lf_federations::{Finished, Lfz, programs};

fn run(name: &str) -> Finished {
    Lfz::run(&format!("flow-{name}"), &programs().join(format!("flow/{name}.lf")), &[]).succeed()
}

fn last_words(finished: &Finished, federate: &str) -> String {
    let words = finished.of(federate).find(|line| line.starts_with(|first: char| first.is_ascii_digit()));
    words.unwrap_or_else(|| panic!("{federate} has said nothing: {finished}")).to_owned()
}

#[test]
fn a_sender_at_100_us_waits_for_a_receiver_that_takes_1_ms() {
    assert_eq!(last_words(&run("SlowReceiver"), "receiver"), "3000 messages in order");
}

#[test]
fn a_cycle_with_a_quick_and_a_slow_sender_goes_on_at_the_pace_of_the_receiver() {
    let finished = run("SlowCycle");
    assert_eq!(last_words(&finished, "receiver"), "1000 quick and 5 slow messages in order");
    assert_eq!(last_words(&finished, "quick"), "1000 sent, 990 back");
    assert_eq!(last_words(&finished, "slow"), "5 sent, 0 back");
}
