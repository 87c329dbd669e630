// SPDX-License-Identifier: Apache-2.0
//! Checks connections: their ends, directions, types, and that no port has two writers.

use std::collections::BTreeMap;

use super::attributes::{AttributeTarget, Attributes, Container};
use super::checker::Checker;
use super::model::{CheckedConnection, Class, ConnectionEnd, PortRef, Variable};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{self, Direction, Reference};

impl<'p> Checker<'p> {
    /// Checks the connections of a class, one per pair of ports.
    pub(super) fn connections(&mut self, position: usize, classes: &[Class<'p>]) -> Vec<CheckedConnection<'p>> {
        let class = &classes[position];
        let mut connections = Vec::new();
        for declared in &class.ast.body.connections {
            let is_main = class.ast.kind != ast::ReactorKind::Plain;
            let container = Container { is_main, is_federated: false, parameters: &class.parameters };
            let Attributes { capacity, max_wait, absent_after, sending, .. } =
                self.check_attributes(&declared.attributes, AttributeTarget::Connection(container));
            let sending = self.connection_sending(declared, sending);
            if let Some(after) = &declared.after {
                self.check_time(after, "the delay of this connection", &class.parameters, false);
            }
            let has_queue = declared.after.is_some() || declared.physical.is_some();
            if capacity.is_some() && !has_queue && class.ast.kind != ast::ReactorKind::Federated {
                let message = "a connection without `after` has no queue, so this capacity has no effect";
                self.report(Diagnostic::new(Code::NoEffect, declared.span, message).hint("remove `@capacity`"));
            }
            let left = self.ends(&declared.left, declared.mode, class, classes);
            let right = self.ends(&declared.right, declared.mode, class, classes);
            let (Some(left), Some(right)) = (left, right) else { continue };
            if !self.check_directions(&left, &right, class, classes) {
                continue;
            }
            // The widths of multiports and banks are known for each instance only.
            let is_wide = left.iter().chain(&right).any(|end| class.is_wide(end.port, classes));
            if !is_wide && !self.check_pairs(declared, &left, &right, class, classes) {
                continue;
            }
            connections.push(CheckedConnection {
                left,
                right,
                iterated: declared.iterated,
                after: declared.after.as_ref(),
                physical: declared.physical.is_some(),
                capacity,
                max_wait,
                absent_after,
                sending,
                mode: declared.mode,
                span: declared.span,
            });
        }
        connections
    }

    /// Returns the ports of one side; `None` if one is missing, which has been reported.
    fn ends(
        &mut self,
        side: &'p [Reference],
        mode: Option<usize>,
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> Option<Vec<ConnectionEnd<'p>>> {
        let ends: Vec<_> = side.iter().map(|end| (self.find_port(end, mode, class, classes), end)).collect();
        ends.into_iter().map(|(port, ast)| Some(ConnectionEnd { port: port?, ast })).collect()
    }

    /// Checks that both sides have the same number of ports, or the left one is repeated, and that all pairs have one
    /// type.
    fn check_pairs(
        &mut self,
        declared: &ast::ConnectionSyntax,
        left: &[ConnectionEnd<'p>],
        right: &[ConnectionEnd<'p>],
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> bool {
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
            return false;
        }
        let mut fits = true;
        for (from, to) in left.iter().cycle().zip(right) {
            let mismatch = type_mismatch(from, to, class, classes);
            fits &= mismatch.is_none();
            self.found.extend(mismatch);
        }
        fits
    }

    /// Checks that the left side has only sources, and the right side only destinations.
    fn check_directions(
        &mut self,
        left: &[ConnectionEnd<'p>],
        right: &[ConnectionEnd<'p>],
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> bool {
        let mut fits = true;
        for (side, is_left) in [(left, true), (right, false)] {
            for end in side {
                let Some(port) = class.port(end.port, classes) else { continue };
                let own = matches!(end.port, PortRef::Own(_));
                if ((port.direction == Direction::Input) == own) != is_left {
                    let role = if is_left { "a source" } else { "a destination" };
                    self.wrong_direction(end.ast, end.port, role, port.direction);
                    fits = false;
                }
            }
        }
        fits
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
        let mut first: Sources = BTreeMap::new();
        let ends = class.connections.iter().flat_map(|connection| {
            let (mode, span) = (connection.mode, connection.span);
            connection.right.iter().map(move |end| (end.port, mode, span))
        });
        for (to, mode, at) in ends {
            if let Some(span) = source_beside(&first, to, mode) {
                let name = port_text(to, class, classes);
                let message = format!("`{name}` already has a source: a port takes one connection");
                self.report(
                    Diagnostic::new(Code::TwoWriters, at, message)
                        .also(span, "the first connection")
                        .hint("give the receiver one input for each source"),
                );
            } else {
                first.entry(to).or_default().push((mode, at));
            }
        }
        for reaction in &class.reactions {
            for effect in reaction.parameters.iter().filter(|parameter| parameter.effect) {
                let Variable::Port(port) = effect.variable else { continue };
                if let Some(span) = source_beside(&first, port, reaction.ast.mode) {
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

/// The connections into each port, with their modes.
type Sources = BTreeMap<PortRef, Vec<(Option<usize>, Span)>>;

/// Returns a connection into a port that can be active together with elements of a mode, or outside of modes.
fn source_beside(sources: &Sources, port: PortRef, mode: Option<usize>) -> Option<Span> {
    let excludes = |other: Option<usize>| mode.is_some() && other.is_some() && mode != other;
    let mut others = sources.get(&port).into_iter().flatten();
    others.find(|(other, _)| !excludes(*other)).map(|(_, span)| *span)
}

/// Returns the problem of a source and a destination with different types.
pub(crate) fn type_mismatch(
    from: &ConnectionEnd<'_>,
    to: &ConnectionEnd<'_>,
    class: &Class<'_>,
    classes: &[Class<'_>],
) -> Option<Diagnostic> {
    let (source, destination) = (class.port(from.port, classes)?, class.port(to.port, classes)?);
    let language = class.language_at(from.port, classes);
    // Types of two languages are compared later, when the federates are known.
    if language != class.language_at(to.port, classes) || (language.facts().is_same_type)(&source.ty, &destination.ty) {
        return None;
    }
    let message = format!(
        "`{}` has type `{}`, but `{}` has type `{}`",
        from.ast.text(),
        source.ty,
        to.ast.text(),
        destination.ty
    );
    let diagnostic = Diagnostic::new(Code::TypeMismatch, to.ast.span, message)
        .also(from.ast.span, "the source")
        .also(source.ty_span, "the type of the source")
        .also(destination.ty_span, "the type of the destination");
    Some(diagnostic.hint("connected ports have the same type, written in the same way"))
}

fn port_text(port: PortRef, class: &Class<'_>, classes: &[Class<'_>]) -> String {
    let name = class.port(port, classes).map_or("", |port| port.name.text.as_str());
    match port {
        PortRef::Own(_) => name.to_owned(),
        PortRef::Child(child, _) => format!("{}.{name}", class.children[child].ast.name.text),
    }
}
