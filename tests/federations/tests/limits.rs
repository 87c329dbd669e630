// SPDX-License-Identifier: Apache-2.0
//! Limits of crates that do not depend on each other, but have to match.

use lf_compiler::NETWORK_CAPACITY;
use lf_coordination::WINDOW;

#[test]
fn queues_of_network_inputs_hold_the_window_and_what_is_sent_before_the_rti_has_taken_it() {
    assert!(NETWORK_CAPACITY >= 2 * usize::from(WINDOW));
}
