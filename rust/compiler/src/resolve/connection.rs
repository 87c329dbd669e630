// SPDX-License-Identifier: Apache-2.0
//! Connections: their ends, directions, types, and that no port has two writers.

use std::collections::BTreeMap;

use super::attributes::{Attributes, Container, Target};
use super::checker::Checker;
use super::model::{Class, Connection, PortRef, Variable};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{self, Direction, Reference};

impl<'p> Checker<'p> {
    /// The connections of a class, one per pair of ports.
    pub(super) fn connections(&mut self, position: usize, classes: &[Class<'p>]) -> Vec<Connection<'p>> {
        let class = &classes[position];
        let mut connections = Vec::new();
        for declared in &class.ast.body.connections {
            let is_main = class.ast.kind != ast::ReactorKind::Plain;
            let container = Container { is_main, parameters: &class.parameters };
            let Attributes { capacity, max_wait, absent_after, sending } =
                self.check_attributes(&declared.attributes, Target::Connection(container));
            let sending = self.connection_sending(declared, sending);
            if let Some(after) = &declared.after {
                self.check_time(after, "the delay of this connection", &class.parameters, false);
            }
            let has_queue = declared.after.is_some() || declared.physical.is_some();
            if capacity.is_some() && !has_queue && class.ast.kind != ast::ReactorKind::Federated {
                let message = "a connection without `after` has no queue, so this capacity has no effect";
                self.report(Diagnostic::new(Code::NoEffect, declared.span, message).hint("remove `@capacity`"));
            }
            let left: Vec<_> = declared.left.iter().map(|end| self.find_port(end, class, classes)).collect();
            let right: Vec<_> = declared.right.iter().map(|end| self.find_port(end, class, classes)).collect();
            if !self.check_widths(declared, &left, &right, class, classes) {
                continue;
            }
            for (index, (to, to_end)) in right.iter().zip(&declared.right).enumerate() {
                let from_end = &declared.left[index % declared.left.len()];
                let (Some(from), Some(to)) = (left[index % left.len()], *to) else { continue };
                if self.check_ends((from, from_end), (to, to_end), class, classes) {
                    let after = declared.after.as_ref();
                    let physical = declared.physical.is_some();
                    let span = declared.span;
                    connections.push(Connection {
                        from,
                        to,
                        after,
                        physical,
                        capacity,
                        max_wait,
                        absent_after,
                        sending,
                        span,
                    });
                }
            }
        }
        connections
    }

    /// Whether both sides have the same number of ports, or the left one is repeated.
    fn check_widths(
        &mut self,
        declared: &ast::Connection,
        left: &[Option<PortRef>],
        right: &[Option<PortRef>],
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> bool {
        let many = |end: &Option<PortRef>| match end {
            None => true,
            Some(port) => {
                let bank = match port {
                    PortRef::Child(child, _) => class.children[*child].ast.width.is_some(),
                    PortRef::Own(_) => false,
                };
                bank || class.port(*port, classes).is_some_and(|port| port.wide)
            }
        };
        // Widths of multiports and of what is unknown are not known; both have been reported.
        if left.iter().chain(right).any(many) {
            return false;
        }
        let (sources, destinations) = (left.len(), right.len());
        let fits = if declared.iterated { destinations % sources == 0 } else { destinations == sources };
        if !fits {
            let message = format!("{sources} on the left side cannot be connected to {destinations} on the right side");
            let hint = if sources == 1 {
                "write `(a.x)+ -> b.y, c.y` to connect one output to several inputs"
            } else {
                "each port on the left side needs one on the right side"
            };
            self.report(Diagnostic::new(Code::WidthMismatch, declared.span, message).hint(hint));
        }
        fits
    }

    /// Whether a source may be connected to a destination.
    fn check_ends(
        &mut self,
        (from, from_end): (PortRef, &Reference),
        (to, to_end): (PortRef, &Reference),
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> bool {
        let (Some(source), Some(destination)) = (class.port(from, classes), class.port(to, classes)) else {
            return false;
        };
        let is_source = (source.direction == Direction::Input) == matches!(from, PortRef::Own(_));
        let is_destination = (destination.direction == Direction::Input) == matches!(to, PortRef::Child(..));
        let source_type = (source.ty.clone(), source.ty_span);
        let destination_type = (destination.ty.clone(), destination.ty_span);
        if !is_source {
            self.wrong_direction(from_end, from, "a source", source.direction);
        }
        if !is_destination {
            self.wrong_direction(to_end, to, "a destination", destination.direction);
        }
        if !is_source || !is_destination {
            return false;
        }
        if !self.language.is_same_type(&source_type.0, &destination_type.0) {
            let message = format!(
                "`{}` has type `{}`, but `{}` has type `{}`",
                from_end.text(),
                source_type.0,
                to_end.text(),
                destination_type.0
            );
            self.report(
                Diagnostic::new(Code::TypeMismatch, to_end.span, message)
                    .also(from_end.span, "the source")
                    .also(source_type.1, "the type of the source")
                    .also(destination_type.1, "the type of the destination")
                    .hint("connected ports have the same type, written in the same way"),
            );
            return false;
        }
        true
    }

    fn wrong_direction(&mut self, end: &Reference, port: PortRef, role: &str, direction: Direction) {
        let (kind, owner) = match (direction, port) {
            (Direction::Input, PortRef::Own(_)) => ("input", "this reactor"),
            (Direction::Output, PortRef::Own(_)) => ("output", "this reactor"),
            (Direction::Input, PortRef::Child(..)) => ("input", "a contained reactor"),
            (Direction::Output, PortRef::Child(..)) => ("output", "a contained reactor"),
        };
        let message = format!("`{}` is an {kind} of {owner} and cannot be {role} of a connection", end.text());
        let hint = "a source is an output of a contained reactor or an input of this one; \
                    a destination is an input of a contained reactor or an output of this one";
        self.report(Diagnostic::new(Code::WrongDirection, end.span, message).hint(hint));
    }

    /// Reports ports with more than one connection, or with a connection and a reaction that writes them.
    pub(super) fn writers(&mut self, class: &Class<'p>, classes: &[Class<'p>]) {
        let mut first: BTreeMap<PortRef, Span> = BTreeMap::new();
        for connection in &class.connections {
            if let Some(span) = first.get(&connection.to).copied() {
                let name = port_text(connection.to, class, classes);
                let message = format!("`{name}` already has a source: a port takes one connection");
                self.report(
                    Diagnostic::new(Code::TwoWriters, connection.span, message)
                        .also(span, "the first connection")
                        .hint("give the receiver one input for each source"),
                );
            } else {
                first.insert(connection.to, connection.span);
            }
        }
        for reaction in &class.reactions {
            for effect in reaction.parameters.iter().filter(|parameter| parameter.effect) {
                let Variable::Port(port) = effect.variable else { continue };
                if let Some(span) = first.get(&port).copied() {
                    let name = port_text(port, class, classes);
                    let message = format!("`{name}` is written by a connection, so a reaction cannot write it too");
                    self.report(
                        Diagnostic::new(Code::TwoWriters, effect.span, message)
                            .also(span, "the connection")
                            .hint("remove one of them, or add an input"),
                    );
                }
            }
        }
    }
}

fn port_text(port: PortRef, class: &Class<'_>, classes: &[Class<'_>]) -> String {
    let name = class.port(port, classes).map_or("", |port| port.name.text.as_str());
    match port {
        PortRef::Own(_) => name.to_owned(),
        PortRef::Child(child, _) => format!("{}.{name}", class.children[child].ast.name.text),
    }
}
