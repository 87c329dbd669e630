// SPDX-License-Identifier: Apache-2.0
//! The connections between federates, numbered at both ends.

use super::graph::Graph;
use crate::federates::Parts;

/// The connections that leave and enter each federate, by their positions in the graph.
#[derive(Debug)]
pub(super) struct Network {
    /// Per federate, in the order of connections.
    pub(super) outputs: Vec<Vec<usize>>,
    /// Per federate, in the order of connections; the position is the port number on the wire.
    pub(super) inputs: Vec<Vec<usize>>,
}

/// Numbers the connections between federates.
pub(super) fn number(graph: &Graph, parts: &Parts) -> Network {
    let mut network =
        Network { outputs: vec![Vec::new(); parts.list.len()], inputs: vec![Vec::new(); parts.list.len()] };
    for (position, link) in graph.links.iter().enumerate().filter(|(_, link)| link.network) {
        if let Some(part) = parts.of[graph.instance[link.from]] {
            network.outputs[part].push(position);
        }
        if let Some(part) = parts.of[graph.instance[link.to]] {
            network.inputs[part].push(position);
        }
    }
    network
}
