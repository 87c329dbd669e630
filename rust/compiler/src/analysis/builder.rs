// SPDX-License-Identifier: Apache-2.0
//! The builder of a federate's plan, and its inputs.

use std::collections::BTreeMap;

use super::classes::{Described, Places};
use super::graph::{Graph, LinkId, Node};
use super::network::NetworkPorts;
use super::order::Levels;
use super::rate::Stream;
use super::waits::Waits;
use super::zero_delay::Cycles;
use crate::arena::Arena;
use crate::elaborated::Elaborated;
use crate::instances::{InstanceId, ModeInstanceId};
use crate::plan::{self, InstanceIndex, ModeIndex, PortIndex, TriggerIndex};

/// The results for the whole program.
pub(super) struct Context<'a> {
    pub(super) program: &'a Elaborated<'a>,
    pub(super) graph: &'a Graph<'a>,
    pub(super) levels: &'a Levels,
    pub(super) network: &'a NetworkPorts,
    pub(super) decentralized: bool,
    /// The waits per connection of the graph.
    pub(super) waits: &'a Arena<LinkId, Waits>,
    pub(super) zero_delay: &'a Cycles,
    /// The cycles of federates, whatever the delays.
    pub(super) cycles: &'a Cycles,
    pub(super) places: &'a Places<'a>,
    pub(super) described: &'a Described,
}

/// The builder of a federate's plan.
pub(super) struct FederateBuilder<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) part: usize,
    /// The instances of this federate, in their order.
    pub(super) members: Vec<InstanceId>,
    /// The index of each of them in the plan.
    pub(super) instances: BTreeMap<InstanceId, InstanceIndex>,
    /// The storing ports of this federate.
    pub(super) ports: BTreeMap<Node, PortIndex>,
    /// The modes of this federate.
    pub(super) modes: BTreeMap<ModeInstanceId, ModeIndex>,
    pub(super) triggers: Vec<plan::Trigger>,
    pub(super) sources: BTreeMap<Source, TriggerIndex>,
    /// By network input: the distances of the values that arrive there, as far as they are known.
    pub(super) spacings: Vec<Option<Vec<Stream>>>,
}

/// The origin of a trigger in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Source {
    Startup,
    Shutdown,
    Reset,
    /// The instance, and the position in its class.
    Timer(InstanceId, usize),
    /// The instance, and the position in its class.
    Action(InstanceId, usize),
    /// A connection of the graph.
    Link(LinkId),
}

impl FederateBuilder<'_> {
    /// Returns whether an instance belongs to this federate.
    pub(super) fn owns(&self, instance: InstanceId) -> bool {
        self.instances.contains_key(&instance)
    }

    pub(super) fn port(&self, node: Node) -> PortIndex {
        self.ports[&self.context.graph.root[node]]
    }

    pub(super) fn mode_index(&self, mode: Option<ModeInstanceId>) -> Option<ModeIndex> {
        mode.map(|mode| self.modes[&mode])
    }

    pub(super) fn instance_index(&self, instance: InstanceId) -> InstanceIndex {
        self.instances[&instance]
    }

    pub(super) fn link_name(&self, link: LinkId) -> String {
        self.context.graph.link_name(link)
    }
}
