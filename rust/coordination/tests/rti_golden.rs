// SPDX-License-Identifier: Apache-2.0
//! The RTI answers byte by byte as the stock RTI did in the recordings.

use lf_coordination::rti::{Outcome, Status};
use lf_testkit::golden::replay::replay;
use lf_testkit::rti::Recorded;

fn play(name: &str) {
    let recording = lf_testkit::golden::load(name).unwrap_or_else(|error| panic!("{error}"));
    let setup = recording.rti().expect("it is the recording of an RTI");
    // Whole, and in pieces that cut every message.
    for piece in [usize::MAX, 1, 7] {
        let mut rti = Recorded::new(setup, piece);
        if let Err(difference) = replay(&recording, &mut rti) {
            panic!("{difference}\n{:#?}", rti.rig.outlet.log_events);
        }
        let lost = matches!(rti.rig.rti.status(), Status::Finished(Outcome::Lost { .. }));
        let finished = matches!(rti.rig.rti.status(), Status::Finished(_));
        assert!(finished, "{name}: the federation is over");
        // In 27 a connection is closed without a word, of which the stock RTI made nothing.
        assert_eq!(lost, setup.exit_code != Some(0) || name.starts_with("27"), "{name}");
    }
}

lf_testkit::recordings! {
    play;
    handshake: "01-handshake",
    reject_federation_id: "02-reject-federation-id",
    reject_id_out_of_range: "03-reject-id-out-of-range",
    reject_id_in_use: "04-reject-id-in-use",
    unexpected_first_message: "05-unexpected-first-message",
    two_federates: "06-two-federates",
    chain: "07-chain",
    fan_in: "08-fan-in",
    after: "10-after",
    after_zero: "11-after-zero",
    zero_delay_cycle: "13-zero-delay-cycle",
    cycle_with_after: "15-cycle-with-after",
    cycle_with_after_zero: "15b-cycle-with-after-zero",
    dnet: "17-dnet",
    dnet_disabled: "18-dnet-disabled",
    stop: "20-stop",
    stop_grants: "20b-stop-grants",
    stop_after_resign: "22-stop-after-resign",
    stop_last_federate: "22b-stop-last-federate",
    failed: "23-failed",
    address: "25-address",
    large_message: "26-large-message",
    message_destinations: "27-message-destinations",
    auth_accepted: "28-auth-accepted",
    clock_sync_init: "30-clock-sync-init",
    clock_sync_init_three: "30b-clock-sync-init-three",
    clock_sync_on: "31-clock-sync-on",
    clock_sync_off: "30c-clock-sync-off",
    start_time_multiple: "32-start-time-multiple",
    start_time_multiple_exact: "32b-start-time-multiple-exact",
    random_dag_40: "33-random-dag-40",
    dnet_paths: "37-dnet-paths",
    unknown_message_type: "38-unknown-message-type",
    ptag_grants_upstream: "40-ptag-grants-upstream",
    self_assumed_start: "41-self-assumed-start",
}
