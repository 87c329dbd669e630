// SPDX-License-Identifier: Apache-2.0
//! The memory of a federate's connections.

use lf_coordination::federate::Coordination;
#[cfg(feature = "transients")]
use lf_model::HandedOver;
use lf_model::Tables;
use lf_wire::{Message, NeighborStructure};

use super::inbound::Inbound;
use super::outbound::Outbound;
use crate::connection::Connection;
use crate::description::{CONTROL_BYTES, Federation, TAGGED_MESSAGE_HEADER_BYTES};
use crate::error::RunError;

/// The memory of a federate's connections: buffers that successive connections use.
#[derive(Debug)]
pub struct Buffers<'s> {
    pub(super) rti: Connection<'s>,
    pub(super) outbound: &'s mut [Outbound<'s>],
    pub(super) inbound: &'s mut [Inbound<'s>],
}

impl<'s> Buffers<'s> {
    /// Returns the buffers for the connection to the RTI. `input` must hold the longest message that can come, and
    /// `output` the longest that can be sent, and control messages beside it.
    pub fn new(input: &'s mut [u8], output: &'s mut [u8]) -> Self {
        Self { rti: Connection::new(input, output), outbound: &mut [], inbound: &mut [] }
    }

    /// Adds connections to the federates of [`Federation::peers_out`], in the same order, and as many slots for
    /// connections from others as [`Federation::peers_in`] has.
    #[must_use]
    pub fn with_peers(self, outbound: &'s mut [Outbound<'s>], inbound: &'s mut [Inbound<'s>]) -> Self {
        Self { outbound, inbound, ..self }
    }

    /// Checks that the buffers can hold what this federate sends and receives; otherwise it would wait for room without
    /// end.
    pub(super) fn check(&self, tables: &Tables, federation: &Federation, federation_id: &[u8]) -> Result<(), RunError> {
        let is_decentralized = federation.coordination == Coordination::Decentralized;
        let message = |payload: usize| payload.saturating_add(TAGGED_MESSAGE_HEADER_BYTES);
        let longest = |direct: bool| {
            let is_here = |physical: bool| (physical || is_decentralized) == direct;
            let inputs = tables.inputs.iter().filter(|input| is_here(input.physical)).map(|input| input.max_len);
            let outputs = tables.outputs.iter().filter(|output| is_here(output.physical)).map(|output| output.max_len);
            (inputs.map(message).max().unwrap_or(0), outputs.map(message).max().unwrap_or(0))
        };
        let ((longest_input, longest_output), direct) = (longest(false), longest(true));
        #[cfg(feature = "transients")]
        let longest_output = {
            let states = tables.handed_over.iter().map(|state| message(state.max_len + HandedOver::ID_BYTES));
            states.fold(longest_output, usize::max)
        };
        let ids = Message::FedIds { federate: federation.id, federation_id };
        let neighbors = NeighborStructure::new(federation.upstream, federation.downstream);
        let handshake = ids.encoded_len().max(Message::NeighborStructure(neighbors).encoded_len());
        let needs = [
            ("receive", longest_input.max(CONTROL_BYTES), self.rti.input.capacity()),
            ("send", longest_output.saturating_add(CONTROL_BYTES).max(handshake), self.rti.output.capacity()),
        ];
        let introduction = CONTROL_BYTES + federation_id.len();
        let inbound = self.inbound.iter().map(|one| ("peer receive", direct.0.max(introduction), one.capacity()));
        let outbound = self.outbound.iter().map(|one| ("peer send", direct.1.max(introduction), one.capacity()));
        let places = [
            ("table of peers that send", federation.peers_in.len(), self.inbound.len()),
            ("table of peers that receive", federation.peers_out.len(), self.outbound.len()),
        ];
        match needs.into_iter().chain(inbound).chain(outbound).chain(places).find(|(_, needed, found)| found < needed) {
            Some((buffer, needed, found)) => Err(RunError::BufferTooSmall { buffer, needed, found }),
            None => Ok(()),
        }
    }
}
