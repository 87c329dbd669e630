// SPDX-License-Identifier: Apache-2.0
//! Groups neighboring ports of a reactor into multiports.
//!
//! Scenarios, plans and the wire number channels. Multiports exist in the text alone: ports of one type that the text
//! can connect together may be one multiport. The program stays the same.

use super::{Connection, Link, LinkEnd, Reactor, Scenario, Ty};

/// The maximum number of channels of a multiport.
const CHANNELS_MAX: usize = 3;

/// The ports of a reactor as its text has them: the first channel and the width of each.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Ports {
    pub(super) inputs: Vec<(usize, usize)>,
    pub(super) outputs: Vec<(usize, usize)>,
}

/// Returns the port that has a channel.
pub(super) fn port_of(ports: &[(usize, usize)], channel: usize) -> (usize, usize) {
    let found = ports.iter().find(|(first, width)| (*first..first + width).contains(&channel));
    found.copied().unwrap_or((channel, 1))
}

/// Groups neighbors as long as possible: `joins` decides it for the first channel and a number of channels.
fn grouped(types: &[Ty], joins: impl Fn(usize, usize) -> bool) -> Vec<(usize, usize)> {
    let (mut ports, mut first) = (Vec::new(), 0);
    while first < types.len() {
        let most = CHANNELS_MAX.min(types.len() - first);
        let is_port =
            |width: &usize| types[first..first + width].iter().all(|ty| *ty == types[first]) && joins(first, *width);
        let width = (2..=most).rev().find(is_port).unwrap_or(1);
        ports.push((first, width));
        first += width;
    }
    ports
}

/// Returns the element of a list with exactly one.
fn only<T>(mut list: impl Iterator<Item = T>) -> Option<T> {
    list.next().filter(|_| list.next().is_none())
}

/// Returns whether all keys exist, and are equal.
fn alike<K: PartialEq>(keys: impl Iterator<Item = Option<K>>) -> bool {
    let keys: Vec<_> = keys.collect();
    keys.iter().all(|key| key.is_some() && *key == keys[0])
}

/// Returns the common part of the connections in one statement.
fn key(one: &Connection) -> impl PartialEq + use<> {
    (one.after, one.capacity, one.max_wait, one.absent_after)
}

impl Scenario {
    /// Returns whether a multiport of a federate is connected to one of another federate.
    pub(crate) fn has_wide_connections(&self) -> bool {
        let ports = self.ports();
        let width = |ports: &[(usize, usize)], channel| port_of(ports, channel).1;
        let is_wide = |one: &Connection| {
            width(&ports[one.from.0].outputs, one.from.1) > 1 && width(&ports[one.to.0].inputs, one.to.1) > 1
        };
        self.connections.iter().any(is_wide)
    }

    /// Returns the name of the input of a connection, as a plan has it behind the name of the output.
    pub(crate) fn input_name(&self, connection: &Connection) -> String {
        let (to, input) = connection.to;
        let (first, width) = port_of(&self.ports()[to].inputs, input);
        let channel = if width > 1 { format!("[{}]", input - first) } else { String::new() };
        format!(" -> f{to}.in{first}{channel}")
    }

    /// Returns the ports of all federates.
    pub(super) fn ports(&self) -> Vec<Ports> {
        let into = |to: (usize, usize)| only(self.connections.iter().filter(move |one| one.to == to));
        let from = |from: (usize, usize)| only(self.connections.iter().filter(move |one| one.from == from));
        let mut all: Vec<Ports> = (0..)
            .zip(&self.federates)
            .map(|(federate, reactor)| {
                let is_inner = |input: usize| reactor.links.iter().any(|link| link.from == LinkEnd::Own(input));
                let inputs = grouped(&reactor.inputs, |first, width| {
                    let mut channels = first..first + width;
                    reactor.wide
                        && alike(channels.clone().map(|input| into((federate, input)).map(key)))
                        && !channels.any(is_inner)
                });
                Ports { inputs, outputs: Vec::new() }
            })
            .collect();
        for (federate, reactor) in self.federates.iter().enumerate() {
            let is_inner = |output: usize| reactor.links.iter().any(|link| link.to == LinkEnd::Own(output));
            let outputs = grouped(&reactor.outputs, |first, width| {
                let mut channels = first..first + width;
                let ends: Vec<_> = channels.clone().filter_map(|output| from((federate, output))).collect();
                // They lead to ports of one channel each, or to the channels of one port.
                let port = |one: &&Connection| port_of(&all[one.to.0].inputs, one.to.1);
                let are_ports = ends.iter().all(|one| port(one).1 == 1);
                let is_port = || {
                    let to = ends[0].to;
                    port(&ends[0]) == (to.1, width) && (to.1..).zip(&ends).all(|(input, one)| one.to == (to.0, input))
                };
                reactor.wide
                    && ends.len() == width
                    && alike(ends.iter().map(|one| Some(key(one))))
                    && !channels.any(is_inner)
                    && (are_ports || is_port())
            });
            all[federate].outputs = outputs;
        }
        all
    }
}

impl Reactor {
    /// Returns the ports of a contained reactor.
    pub(super) fn child_ports(&self, child: usize) -> Ports {
        let contained = &self.children[child];
        let into = |input: usize| only(self.links.iter().filter(move |link| link.to == LinkEnd::Child(child, input)));
        let key = |link: &Link| (link.after, link.capacity, link.mode);
        // One end or the other is a port of the container.
        let is_inner = |port: usize| contained.links.iter().any(|it| [it.from, it.to].contains(&LinkEnd::Own(port)));
        let inputs = grouped(&contained.inputs, |first, width| {
            let channels = || (first..first + width).map(into);
            let is_even = channels().all(|link| link.is_none()) || alike(channels().map(|link| link.map(key)));
            contained.wide && is_even && !(first..first + width).any(is_inner)
        });
        let is_linked = |output: usize| self.links.iter().any(|link| link.from == LinkEnd::Child(child, output));
        let outputs = grouped(&contained.outputs, |first, width| {
            contained.wide && !(first..first + width).any(|output| is_linked(output) || is_inner(output))
        });
        Ports { inputs, outputs }
    }
}
