// SPDX-License-Identifier: Apache-2.0
//! The parameters by which a federate joins its federation.

use lf_coordination::Endpoint;

/// The parameters that a federate receives when it starts, and not when it is built.
#[derive(Clone, Copy, Debug)]
pub struct Join<'a> {
    /// The federation to join.
    pub federation_id: &'a [u8],
    /// The address of its RTI.
    pub rti: Endpoint,
    /// More addresses of the RTI's host, which are tried one after the other.
    pub others: &'a [Endpoint],
}
