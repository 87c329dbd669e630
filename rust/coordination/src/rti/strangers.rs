// SPDX-License-Identifier: Apache-2.0
//! Connections without a known federate, and federates that have joined and then are silent.
//!
//! A new connection may replace an older one: when all connections are in use, the oldest of those that have not sent
//! an id is closed. A federate sends its id at once, so it is not the oldest unless more strangers than there are
//! connections come in between. A federate that has joined keeps its connection, but not if it is silent for long
//! before it has sent its clock: all the others would wait for it.

use super::members::Members;
use super::outlet::ConnectionId;
use crate::Tally;

/// Counters of connections whose federate is not known for sure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strangers {
    pub(super) abandoned: Tally,
    pub(super) evicted: Tally,
    pub(super) rejected: Tally,
    pub(super) rejected_by: Tally,
}

/// Returns the connection to close for a new one when all are in use: the oldest that has not sent an id. Looks at
/// every connection once.
pub(super) fn oldest(members: &Members<'_>) -> Option<ConnectionId> {
    let oldest = members.strangers().min_by_key(|(_, connection)| connection.deadline);
    oldest.map(|(connection, _)| connection)
}
