// SPDX-License-Identifier: Apache-2.0
//! What goes out, now or as soon as there is room.

use lf_wire::{Message, MessageType};

use super::storage::Pending;
use super::{ConnectionId, Outlet, Rti, Slot};
use crate::tag::to_wire;

/// Bytes of TAG, PTAG, DNET and the stop messages, which carry a tag only.
const TAG_MESSAGE_BYTES: usize = MessageType::TagGrant.fixed_bytes();

impl Pending {
    /// Whether something has to go out before any grant or forwarded message.
    pub(super) fn comes_first(self) -> bool {
        self.start || self.stop_request || self.taken_back || self.stop_granted
    }
}

impl Rti<'_> {
    /// The connection of the federate if a message of so many bytes can be sent to it now.
    pub(super) fn ready(&self, federate: usize, bytes: usize, outlet: &impl Outlet) -> Option<ConnectionId> {
        let connection = self.connection_of(federate)?;
        let ready = !self.slots[federate].pending.comes_first() && outlet.room(connection) >= bytes;
        ready.then_some(connection)
    }

    /// As [`ready`](Self::ready), for a message that carries a tag only.
    pub(super) fn ready_for_tag(&self, federate: usize, outlet: &impl Outlet) -> Option<ConnectionId> {
        self.ready(federate, TAG_MESSAGE_BYTES, outlet)
    }

    /// Sends what is pending for a federate, in the order of [`Pending`], as far as there is room.
    pub(super) fn flush(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let Some(connection) = self.connection_of(federate) else { return };
        let start = self.start;
        let stop_tag = to_wire(self.stop.tag());
        let pending = &mut self.slots[federate].pending;
        if let Some(start) = start
            && !send_pending(&mut pending.start, &Message::Timestamp(start.as_nanos()), connection, outlet)
        {
            return;
        }
        if !send_pending(&mut pending.stop_request, &Message::StopRequest(stop_tag), connection, outlet)
            || !send_pending(&mut pending.taken_back, &Message::ProvisionalTagGrant(stop_tag), connection, outlet)
            || !send_pending(&mut pending.stop_granted, &Message::StopGranted(stop_tag), connection, outlet)
        {
            return;
        }
        if core::mem::take(&mut pending.grant) {
            self.advance(federate, outlet);
        }
        if core::mem::take(&mut self.slots[federate].pending.dnet) {
            self.offer_downstream_next_event(federate, None, outlet);
        }
    }

    /// Marks something to be sent to every federate that `choose` picks among those that are there, and sends it to
    /// those that have room.
    pub(super) fn broadcast(
        &mut self,
        choose: impl Fn(&Slot) -> bool,
        mark: impl Fn(&mut Pending),
        outlet: &mut impl Outlet,
    ) {
        for federate in 0..self.slots.len() {
            if self.connection_of(federate).is_some() && choose(&self.slots[federate]) {
                mark(&mut self.slots[federate].pending);
                self.flush(federate, outlet);
            }
        }
    }
}

/// Sends the message if it is pending. Returns false if it still is.
fn send_pending(flag: &mut bool, message: &Message<'_>, connection: ConnectionId, outlet: &mut impl Outlet) -> bool {
    if *flag && outlet.room(connection) >= message.encoded_len() {
        outlet.send(connection, message);
        *flag = false;
    }
    !*flag
}
