// SPDX-License-Identifier: Apache-2.0
//! The federates that are there, and their connections.

use lf_derive::outlined;
use lf_model::time::Instant;

use super::log_event::RtiEvent;
use super::outlet::{ConnectionId, Outlet};
use super::storage::{Connection, Membership, Phase, Slot, id};
use super::suspected_violation::SuspectedViolation;
use crate::Deadline;

/// The federates and the connections, in the owner's storage.
pub(super) struct Members<'s> {
    pub(super) slots: &'s mut [Slot],
    pub(super) connections: &'s mut [Connection],
    /// The earliest deadline of the connections.
    earliest_deadline: Deadline,
    /// Whether each federate is informed about the comings and goings of each one: as many entries for each as there
    /// are federates. Empty without transient federates.
    #[cfg(feature = "transients")]
    pub(super) registrations: &'s mut [bool],
}

impl<'s> Members<'s> {
    /// Returns the members in this storage.
    pub(super) fn new(slots: &'s mut [Slot], connections: &'s mut [Connection]) -> Self {
        let earliest_deadline = earliest_deadline(connections);
        Self {
            slots,
            connections,
            earliest_deadline,
            #[cfg(feature = "transients")]
            registrations: &mut [],
        }
    }

    /// Returns the members with the storage for registrations.
    #[cfg(feature = "transients")]
    pub(super) fn with_registrations(self, registrations: &'s mut [bool]) -> Self {
        Self { registrations, ..self }
    }

    /// Returns the earliest deadline of the connections.
    pub(super) fn earliest_deadline(&self) -> Deadline {
        self.earliest_deadline
    }

    /// Returns the connection of a federate that is part of the federation.
    pub(super) fn connection_of(&self, federate: usize) -> Option<ConnectionId> {
        match self.slots.get(federate)?.membership {
            Membership::Joined(connection) => Some(connection),
            _ => None,
        }
    }

    /// Returns the connection of a federate that takes part in the running federation: a transient one does so from
    /// its effective start on.
    pub(super) fn running(&self, federate: usize) -> Option<ConnectionId> {
        let connection = self.connection_of(federate)?;
        let waits = cfg!(feature = "transients") && self.slots[federate].clock.is_none();
        (!waits).then_some(connection)
    }

    /// Returns the federate that has joined over this connection and is still there.
    pub(super) fn joined_on(&self, connection: ConnectionId) -> Option<usize> {
        let known = self.connections.get(connection.0)?;
        known.federate.filter(|_| known.phase == Phase::Joined).map(usize::from)
    }

    /// Returns the phase of a connection: the message that is expected next.
    #[outlined]
    pub(super) fn phase(&self, connection: ConnectionId) -> Phase {
        self.connections.get(connection.0).map_or(Phase::Vacant, |known| known.phase)
    }

    /// Returns whether all have left.
    pub(super) fn all_departed(&self) -> bool {
        self.slots.iter().all(|slot| slot.membership == Membership::Departed)
    }

    /// Returns the connections that have not sent an id.
    pub(super) fn strangers(&self) -> impl Iterator<Item = (ConnectionId, &Connection)> {
        let connections = self.connections.iter().enumerate().map(|(index, known)| (ConnectionId(index), known));
        connections
            .filter(|(_, known)| matches!(known.phase, Phase::Nonce { .. } | Phase::Proof { .. } | Phase::Ids { .. }))
    }

    /// Sets the time at which the RTI closes a connection that stays silent.
    pub(super) fn set_deadline(&mut self, connection: ConnectionId, deadline: Option<Instant>) {
        let before = core::mem::replace(&mut self.connections[connection.0].deadline, deadline);
        if before.is_some() && self.earliest_deadline == before.into() {
            self.earliest_deadline = earliest_deadline(self.connections);
        }
        self.earliest_deadline = self.earliest_deadline.min(deadline.into());
    }

    /// Handles that a federate that has joined has sent something: until it has sent its clock, it may not be silent
    /// for long.
    pub(super) fn await_clock(&mut self, until: Instant, federate: usize, connection: ConnectionId) {
        let known = &self.connections[connection.0];
        let waits = self.slots[federate].clock.is_none();
        if known.phase == Phase::Joined && (waits || known.deadline.is_some()) {
            self.set_deadline(connection, waits.then_some(until));
        }
    }

    /// Releases a connection. Returns the federate whose id is free now, because it had not completed its handshake.
    pub(super) fn release(&mut self, connection: ConnectionId) -> Option<usize> {
        self.set_deadline(connection, None);
        let federate = core::mem::take(&mut self.connections[connection.0]).federate.map(usize::from)?;
        let membership = self.slots.get(federate)?.membership;
        (membership == Membership::Joining(connection)).then_some(federate)
    }

    /// Logs a federate that is suspected of a violation, once.
    pub(super) fn report_suspected(
        &mut self,
        federate: usize,
        violation: SuspectedViolation,
        outlet: &mut impl Outlet,
    ) {
        if !core::mem::replace(&mut self.slots[federate].suspected, true) {
            outlet.log(RtiEvent::SuspectedViolation { federate: id(federate), violation });
        }
    }
}

/// Returns the earliest deadline of the connections.
fn earliest_deadline(connections: &[Connection]) -> Deadline {
    connections.iter().filter_map(|connection| connection.deadline).min().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The earliest deadline is known after any sequence of deadlines.
        #[test]
        fn the_earliest_deadline_is_kept(
            steps in proptest::collection::vec((0..4usize, proptest::option::of(0..9i64), any::<bool>()), 0..40),
        ) {
            let mut connections = [Connection::EMPTY; 4];
            let mut members = Members::new(&mut [], &mut connections);
            for (connection, deadline, ends) in steps {
                if ends {
                    prop_assert_eq!(members.release(ConnectionId(connection)), None);
                } else {
                    members.set_deadline(ConnectionId(connection), deadline.map(Instant::from_nanos));
                }
                prop_assert_eq!(members.earliest_deadline(), earliest_deadline(members.connections));
            }
        }
    }

    #[test]
    fn an_id_is_free_again_only_if_its_handshake_was_not_complete() {
        let (mut slots, mut connections) = ([Slot::EMPTY; 2], [Connection::EMPTY; 2]);
        let mut members = Members::new(&mut slots, &mut connections);
        let [one, other] = [0, 1].map(ConnectionId);
        members.slots[0].membership = Membership::Joining(one);
        members.slots[1].membership = Membership::Joined(other);
        members.connections[0] = Connection { phase: Phase::UdpPort, federate: Some(0), ..Connection::EMPTY };
        members.connections[1] = Connection { phase: Phase::Joined, federate: Some(1), ..Connection::EMPTY };
        assert_eq!((members.joined_on(one), members.joined_on(other)), (None, Some(1)));
        assert_eq!((members.connection_of(0), members.connection_of(1)), (None, Some(other)));
        assert_eq!((members.release(one), members.release(other)), (Some(0), None));
        assert_eq!((members.joined_on(other), members.phase(other)), (None, Phase::Vacant));
    }
}
