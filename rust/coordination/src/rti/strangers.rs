// SPDX-License-Identifier: Apache-2.0
//! Connections of which nobody knows whose they are, and federates that have joined and say no more.
//!
//! Whoever connects has a place only as long as there are places: when the next one comes, the oldest of those that
//! have not said which federate they are makes way for it. A federate says so at once, so it is none of the oldest
//! unless more strangers than there are places come in between. A federate that has joined keeps its place, but not if
//! it is silent for long before it has told its clock: all the others would wait for it.

use super::members::Members;
use super::outlet::ConnectionId;
use crate::Tally;

/// How often something has come of connections whose federate nobody knows for sure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strangers {
    pub(super) abandoned: Tally,
    pub(super) made_way: Tally,
    pub(super) rejected: Tally,
    pub(super) rejected_by: Tally,
}

/// The connection that makes way for a new one when all places are taken: the oldest that has not said which federate
/// it is. Looks at every connection once.
pub(super) fn oldest(members: &Members<'_>) -> Option<ConnectionId> {
    let oldest = members.strangers().min_by_key(|(_, connection)| connection.deadline);
    oldest.map(|(connection, _)| connection)
}
