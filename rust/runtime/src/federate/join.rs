// SPDX-License-Identifier: Apache-2.0
//! What a federate is told on the way to its federation.

use lf_coordination::Endpoint;

/// What a federate is told when it is started, and not when it is built.
#[derive(Clone, Copy, Debug)]
pub struct Join<'a> {
    /// The federation to join.
    pub federation_id: &'a [u8],
    /// Where its RTI listens.
    pub rti: Endpoint,
    /// More addresses of the RTI's host, which are tried in turn.
    pub others: &'a [Endpoint],
}
