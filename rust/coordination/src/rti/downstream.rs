// SPDX-License-Identifier: Apache-2.0
//! Which of a federate's next events matter to those downstream of it (DNET). It need not announce the others.

use lf_model::time::Tag;
use lf_wire::Message;

use super::{Outlet, Rti};
use crate::tag::to_wire;

impl Rti<'_> {
    /// The next event of a federate is another one: tells those upstream of it what follows for them.
    pub(super) fn tell_upstream(&mut self, federate: usize, outlet: &mut impl Outlet) {
        if !self.config.dnet {
            return;
        }
        let row = self.graph.nodes[federate].incoming;
        for index in 0..row.len {
            let upstream = self.graph.other_end(row, index);
            if upstream != federate {
                self.offer_downstream_next_event(upstream, Some(federate), outlet);
            }
        }
    }

    /// Tells a federate its downstream next event tag, if that has changed and is not past already. `because` is the
    /// downstream federate whose next event has changed, or any.
    pub(super) fn offer_downstream_next_event(
        &mut self,
        federate: usize,
        because: Option<usize>,
        outlet: &mut impl Outlet,
    ) {
        let tag = self.downstream_next_event(federate, because);
        let slot = &self.slots[federate];
        if tag == slot.dnet || self.graph.next_event(federate) > tag || self.connection_of(federate).is_none() {
            return;
        }
        match self.ready_for_tag(federate, outlet) {
            Some(connection) => {
                outlet.send(connection, &Message::DownstreamNextEventTag(to_wire(tag)));
                self.slots[federate].dnet = tag;
            }
            None => self.slots[federate].pending.dnet = true,
        }
    }

    /// The latest tag of a federate that can matter to any federate downstream. NEVER if all do, as in a cycle without
    /// delay, and as long as the next event of one of them is unknown.
    fn downstream_next_event(&self, federate: usize, because: Option<usize>) -> Tag {
        let in_cycle = match because {
            Some(downstream) => self.graph.in_zero_delay_cycle(downstream),
            None => self.graph.leads_to_zero_delay_cycle(federate),
        };
        if in_cycle || self.graph.in_zero_delay_cycle(federate) {
            return Tag::NEVER;
        }
        let earliest = self.graph.earliest_needed(federate);
        match self.start {
            Some(start) if earliest >= Tag::at(start) => earliest,
            _ => Tag::NEVER,
        }
    }
}
