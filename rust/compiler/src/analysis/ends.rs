// SPDX-License-Identifier: Apache-2.0
//! The inputs and outputs of a federate, and its neighbors.

use std::collections::{BTreeMap, BTreeSet};

use super::builder::{FederateBuilder, Source};
use super::graph::{Link, Node};
use super::zero_delay::is_immediate;
use crate::plan::{self, Shape, Type, Upstream};

impl FederateBuilder<'_> {
    fn federate_of(&self, node: Node) -> u16 {
        let part = self.context.graph.part(node).unwrap_or_default();
        u16::try_from(part).unwrap_or(u16::MAX)
    }

    fn value_type(&self, node: Node) -> Type {
        let port = self.context.graph.port(node);
        self.context.places.ty(&port.ty, port.ty_span)
    }

    pub(super) fn outputs(&self) -> Vec<plan::NetworkOutput> {
        let (graph, network) = (self.context.graph, self.context.network);
        let mut outputs = Vec::new();
        for position in &network.outputs[self.part] {
            let link = &graph.links[*position];
            let federate = self.federate_of(link.to);
            let receiver = usize::from(federate);
            let input = network.inputs[receiver].iter().position(|input| input == position);
            let port = input.map(|input| plan::port_of(&network.own_ports[receiver], input));
            outputs.push(plan::NetworkOutput {
                name: self.link_name(*position),
                source: self.port(link.from),
                federate,
                port: port.unwrap_or(u16::MAX),
                delay_ns: link.delay.filter(|_| !link.physical),
                tells_absence: self.tells_absence(link),
                physical: link.physical,
                direct: link.physical || self.context.decentralized,
                ty: self.value_type(link.from),
                serializer: link.serializer.clone(),
                counterpart: counterpart(link.shapes.as_ref().map(|(own, other)| (own, other))),
                at: self.context.places.at(link.span),
            });
        }
        outputs
    }

    pub(super) fn inputs(&self) -> Vec<plan::NetworkInput> {
        let mut inputs = Vec::new();
        for (position, spacings_ns) in self.context.network.inputs[self.part].iter().zip(&self.spacings) {
            let link = &self.context.graph.links[*position];
            inputs.push(plan::NetworkInput {
                name: self.link_name(*position),
                trigger: self.sources[&Source::Link(*position)],
                federate: self.federate_of(link.from),
                delay_ns: link.delay,
                level: self.level_of_input(link.to),
                awaited: self.is_awaited(link),
                physical: link.physical,
                direct: link.physical || self.context.decentralized,
                max_wait_ns: self.context.waits[*position].max_wait_ns,
                absent_after_ns: self.context.waits[*position].absent_after_ns,
                spacings_ns: spacings_ns.clone(),
                // Both ends have one type, if they are in one language.
                ty: self.value_type(if link.shapes.is_some() { link.to } else { link.from }),
                serializer: link.serializer.clone(),
                counterpart: counterpart(link.shapes.as_ref().map(|(other, own)| (own, other))),
                at: self.context.places.at(link.span),
            });
        }
        inputs
    }

    /// Returns whether the sender has to report absences: the receiver may be waiting for the value within a tag. The
    /// position of the receiver does not matter, because receivers in the stock runtime wait for every sender in a
    /// cycle.
    fn tells_absence(&self, link: &Link) -> bool {
        is_immediate(link) && self.context.zero_delay.is_in_one(self.part)
    }

    /// Returns whether reactions have to wait within a tag until the status of the input is known: this federate may be
    /// at the tag before the sender has completed it, because both are in one cycle.
    ///
    /// The same is true for a federate outside of all cycles with a sender in one: the stock RTI grants tags
    /// provisionally to all federates upstream of a cycle. A federate in another cycle than the sender does not wait,
    /// because our RTI grants no tag that the sender can still reach, so that the sender need not report anything about
    /// it.
    ///
    /// Without an RTI that grants tags, any sender may be behind.
    fn is_awaited(&self, link: &Link) -> bool {
        if self.context.decentralized {
            return link.is_logical_network();
        }
        let (zero_delay, from) = (&self.context.zero_delay, usize::from(self.federate_of(link.from)));
        let may_be_behind =
            zero_delay.is_common(from, self.part) || (zero_delay.is_in_one(from) && !zero_delay.is_in_one(self.part));
        is_immediate(link) && may_be_behind
    }

    /// Returns the lowest level of the readers of the port at the end of a connection from another federate.
    fn level_of_input(&self, port: Node) -> u16 {
        let (graph, levels) = (self.context.graph, self.context.levels);
        let readers = graph.readers[port].iter().map(|(reader, _)| levels.steps[*reader]);
        let outputs = self.context.network.outputs[self.part].iter();
        let sends = outputs.filter(|link| graph.root[graph.links[**link].from] == port).map(|link| levels.sends[*link]);
        readers.chain(sends).min().unwrap_or(u16::MAX)
    }

    /// Returns the least delay per sending federate; no `after` is less than `after 0`. Unused connections count like
    /// all others, as they do for LF's own compiler, so that the RTI gets the same data from both.
    pub(super) fn upstream(&self) -> Vec<Upstream> {
        let mut least: BTreeMap<u16, Option<i64>> = BTreeMap::new();
        for link in self.logical_links().filter(|link| usize::from(self.federate_of(link.to)) == self.part) {
            let delay = least.entry(self.federate_of(link.from)).or_insert(link.delay);
            *delay = (*delay).min(link.delay);
        }
        least.into_iter().map(|(federate, delay_ns)| Upstream { federate, delay_ns }).collect()
    }

    pub(super) fn downstream(&self) -> Vec<u16> {
        let links = self.logical_links().filter(|link| usize::from(self.federate_of(link.from)) == self.part);
        let federates: BTreeSet<u16> = links.map(|link| self.federate_of(link.to)).collect();
        federates.into_iter().collect()
    }

    fn logical_links(&self) -> impl Iterator<Item = &Link> {
        self.context.graph.links.values().filter(|link| link.is_logical_network())
    }
}

/// Returns the layout of a value at the other end, if this end has only a name for it.
fn counterpart(shapes: Option<(&Shape, &Shape)>) -> Option<Shape> {
    shapes.filter(|(own, _)| own.has_names()).map(|(_, other)| other.clone())
}
