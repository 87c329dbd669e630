// SPDX-License-Identifier: Apache-2.0
//! The tests of the state machines of federates and of the RTI. One program is linked once, and its tests run side by
//! side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod clock_sync;
mod clock_sync_drift;
mod clock_sync_rounds;
mod federate;
mod federate_golden;
mod federate_properties;
mod federate_support;
mod federation;
mod federation_incarnations;
mod federation_support;
mod rti_barrier;
mod rti_dialogue;
mod rti_exchanges;
mod rti_families;
mod rti_flow;
mod rti_golden;
mod rti_ordered_stop;
mod rti_out_of_turn;
mod rti_plain;
mod rti_property;
mod rti_quirks;
mod rti_stop;
mod rti_strangers;
mod rti_suspected_violations;
mod rti_suspend;
mod rti_swaps;
mod rti_transients;
mod rti_watch;
mod words;
