// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate, each named after what it proves. They run with all capabilities, and in each profile of a
//! shipped image that has what they need.
#![allow(clippy::duplicate_mod, reason = "each profile is a compilation of the same dialogues of its own")]

mod needs;

/// Declares the dialogues of a profile, and what they drive there.
macro_rules! dialogues {
    ($profile:path: $($dialogue:ident),+) => {
        use $profile as Profile;
        type Config<'a> = lf_coordination::federate::Config<'a, Profile>;
        type Federate<'a> = lf_coordination::federate::Federate<'a, Profile>;
        $(mod $dialogue;)+

        /// Federate 1 with these neighbors, without clock synchronization.
        #[allow(dead_code, reason = "not all dialogues begin with it")]
        fn config(upstream: &'static [(u16, i64)], downstream: &'static [u16]) -> Config<'static> {
            crate::federate_support::dialogue::config(upstream, downstream)
        }
    };
}

#[path = "."]
mod all {
    dialogues!(lf_coordination::federate::All:
        authentication, cycles, decentralized, handshake, peers, running, sending, transient_peers, transients,
        window);
}

#[path = "."]
mod centralized {
    dialogues!(lf_testkit::profiles::Centralized: authentication, cycles, handshake, running, sending);
}

#[path = "."]
mod centralized_transients {
    dialogues!(lf_testkit::profiles::CentralizedTransients:
        authentication, cycles, handshake, running, sending, transients);
}

#[path = "."]
mod centralized_source {
    dialogues!(lf_testkit::profiles::CentralizedSource: handshake, sending);
}

#[path = "."]
mod decentralized {
    dialogues!(lf_testkit::profiles::Decentralized: authentication, decentralized, handshake, peers);
}

#[path = "."]
mod decentralized_transients {
    dialogues!(lf_testkit::profiles::DecentralizedTransients:
        authentication, decentralized, handshake, peers, transient_peers);
}

#[path = "."]
mod decentralized_source {
    dialogues!(lf_testkit::profiles::DecentralizedSource: decentralized, handshake, peers);
}
