// SPDX-License-Identifier: Apache-2.0
//! Connections of which nobody knows whose they are, and federates that have joined and say no more.
//!
//! Whoever connects has a place only as long as there are places: when the next one comes, the oldest of those that
//! have not said which federate they are makes way for it. A federate says so at once, so it is none of the oldest
//! unless more strangers than there are places come in between. A federate that has joined keeps its place, but not if
//! it is silent for long before it has told its clock: all the others would wait for it.

use lf_model::time::Instant;

use super::storage::Phase;
use super::{ConnectionId, Notice, Outlet, Rti};
use crate::Tally;

/// How often something has come of connections whose federate nobody knows for sure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strangers {
    pub(super) abandoned: Tally,
    pub(super) made_way: Tally,
    pub(super) rejected: Tally,
    pub(super) rejected_by: Tally,
}

impl Rti<'_> {
    /// The connection that makes way for a new one when all places are taken: the oldest that has not said which
    /// federate it is. It is closed, and what its peer still sends is not wanted. `None` when there is none.
    ///
    /// Looks at every connection once.
    pub fn make_way(&mut self, outlet: &mut impl Outlet) -> Option<ConnectionId> {
        let connection = self.oldest_stranger()?;
        outlet.notice(Notice::MadeWay(self.strangers.made_way.count()));
        outlet.close(connection);
        self.release(connection);
        Some(connection)
    }

    /// Whether [`make_way`](Self::make_way) finds a connection.
    pub fn can_make_way(&self) -> bool {
        self.oldest_stranger().is_some()
    }

    fn oldest_stranger(&self) -> Option<ConnectionId> {
        let strangers = self.connections.iter().enumerate().filter(|(_, connection)| {
            matches!(connection.phase, Phase::Nonce { .. } | Phase::Proof { .. } | Phase::Ids { .. })
        });
        strangers.min_by_key(|(_, connection)| connection.deadline).map(|(index, _)| ConnectionId(index))
    }

    /// A federate that has joined has said something: until it has told its clock, it may not be silent for long.
    pub(super) fn await_clock(&mut self, now: Instant, federate: usize, connection: ConnectionId) {
        let known = &self.connections[connection.0];
        let waits = self.slots[federate].clock.is_none();
        if known.phase == Phase::Joined && (waits || known.deadline.is_some()) {
            self.set_deadline(connection, waits.then(|| now + self.config.clock_time_out));
        }
    }
}
