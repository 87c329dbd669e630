// SPDX-License-Identifier: Apache-2.0
//! The needs of the federates of shipped images. Tests run in each of these profiles, and not only with all needs.

use lf_coordination::federate::Needs;

/// A federate that the RTI grants tags, in any place of its federation.
#[derive(Clone, Copy, Debug)]
pub struct Centralized;

impl Needs for Centralized {
    const DECENTRALIZED: bool = false;
    const PEERS_IN: bool = false;
    const PEERS_OUT: bool = false;
    const UNTAGGED: bool = false;
    const BUFFER_CHECK: bool = false;
}

/// A federate that the RTI grants tags, and that only sends.
#[derive(Clone, Copy, Debug)]
pub struct CentralizedSource;

impl Needs for CentralizedSource {
    const DECENTRALIZED: bool = false;
    const INPUTS: bool = false;
    const CYCLES: bool = false;
    const AUTHENTICATION: bool = false;
    const AWAITED: bool = false;
    const PEERS_IN: bool = false;
    const PEERS_OUT: bool = false;
    const UNTAGGED: bool = false;
    const PHYSICAL: bool = false;
    const BUFFER_CHECK: bool = false;
}

/// A federate whose messages go from federate to federate.
#[derive(Clone, Copy, Debug)]
pub struct Decentralized;

impl Needs for Decentralized {
    const CENTRALIZED: bool = false;
    const INPUTS: bool = false;
    const CYCLES: bool = false;
    const PHYSICAL: bool = false;
    const BUFFER_CHECK: bool = false;
}

/// The same without clock synchronization that only sends.
#[derive(Clone, Copy, Debug)]
pub struct DecentralizedSource;

impl Needs for DecentralizedSource {
    const CENTRALIZED: bool = false;
    const INPUTS: bool = false;
    const CYCLES: bool = false;
    const AUTHENTICATION: bool = false;
    const AWAITED: bool = false;
    const PEERS_IN: bool = false;
    const UNTAGGED: bool = false;
    const PHYSICAL: bool = false;
    const CLOCK_SYNC: bool = false;
    const BUFFER_CHECK: bool = false;
}
