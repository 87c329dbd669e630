// SPDX-License-Identifier: Apache-2.0
//! The profiles of shipped images: what `lf_embedded::run!` finds that their federates need. Dialogues run in each of
//! them, and not only with all needs.

use lf_coordination::federate::Needs;

/// Declares profiles, each with the capabilities that it lacks. Without transient federates is the usual case.
macro_rules! profiles {
    ($($(#[$doc:meta])+ $name:ident: without $($capability:ident),+;)+) => {$(
        $(#[$doc])+
        #[derive(Clone, Copy, Debug)]
        pub struct $name;

        impl Needs for $name {
            $(const $capability: bool = false;)+
            const BUFFER_CHECK: bool = false;
            const WINDOW: bool = false;
        }
    )+};
}

profiles! {
    /// A federate that the RTI grants tags, in any place of its federation.
    Centralized: without DECENTRALIZED, PEERS_IN, PEERS_OUT, UNTAGGED, TRANSIENTS;
    /// The same where federates come and go.
    CentralizedTransients: without DECENTRALIZED, PEERS_IN, PEERS_OUT, UNTAGGED;
    /// A federate that the RTI grants tags, and that only sends.
    CentralizedSource: without DECENTRALIZED, INPUTS, CYCLES, AUTHENTICATION, AWAITED, PEERS_IN, PEERS_OUT, UNTAGGED,
        TRANSIENTS, PHYSICAL, WAITS;
    /// A federate whose messages go from federate to federate.
    Decentralized: without CENTRALIZED, INPUTS, CYCLES, TRANSIENTS, PHYSICAL;
    /// The same where federates come and go.
    DecentralizedTransients: without CENTRALIZED, INPUTS, CYCLES, PHYSICAL;
    /// A federate whose messages go from federate to federate, and that only sends.
    DecentralizedSource: without CENTRALIZED, INPUTS, CYCLES, AUTHENTICATION, AWAITED, PEERS_IN, UNTAGGED, TRANSIENTS,
        PHYSICAL, WAITS;
}
