// SPDX-License-Identifier: Apache-2.0
//! Limits of crates that do not depend on each other, but have to match.

use lf_compiler::NETWORK_CAPACITY;
use lf_coordination::federate::TAGS_AHEAD_MAX;
use lf_coordination::rti::WINDOW;

#[test]
fn queues_of_network_inputs_hold_the_window_and_what_is_sent_before_the_rti_has_taken_it() {
    assert!(NETWORK_CAPACITY >= WINDOW + usize::from(TAGS_AHEAD_MAX));
}
