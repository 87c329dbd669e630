// SPDX-License-Identifier: Apache-2.0
//! Which reactors are checked, in which order, and what all checks share.

use std::collections::BTreeMap;

use super::attributes::{Container, Target};
use super::load::Program;
use super::model::{Child, Class, ClassId, PortRef, ReactorId};
use super::{mains, names, unsupported};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span, did_you_mean};
use crate::syntax::ast;

/// How deeply reactors may contain each other.
const DEPTH_MAX: usize = 200;

/// Checks every reactor that has to be right: those of the main file, and those that they contain. Returns them with
/// the position of the main or federated one, if there is exactly one.
pub(crate) fn check<'p>(program: &'p Program, diagnostics: &mut Diagnostics) -> (Vec<Class<'p>>, Option<ClassId>) {
    let mut checker = Checker { program, by_id: BTreeMap::new(), found: Vec::new(), lenient: false };
    let mut classes = checker.declarations();
    for position in 0..classes.len() {
        checker.children(position, &mut classes);
    }
    for position in 0..classes.len() {
        checker.lenient = classes[position].opaque;
        let connections = checker.connections(position, &classes);
        classes[position].connections = connections;
        let reactions = checker.reactions(position, &classes);
        classes[position].reactions = reactions;
        checker.writers(&classes[position], &classes);
    }
    checker.cycles(&classes);
    let main = mains::find(&mut checker, &classes);
    diagnostics.extend(checker.found);
    (classes, main)
}

/// What all checks share.
pub(super) struct Checker<'p> {
    pub(super) program: &'p Program,
    pub(super) by_id: BTreeMap<ReactorId, ClassId>,
    found: Vec<Diagnostic>,
    /// Whether names may be declared where they cannot be seen, by features that have been refused.
    pub(super) lenient: bool,
}

/// Whether a reactor uses a feature that is not supported and that declares names which are not known here.
pub(super) fn is_opaque(reactor: &ast::Reactor) -> bool {
    !reactor.extends.is_empty() || !reactor.body.modes.is_empty()
}

impl<'p> Checker<'p> {
    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.found.push(diagnostic);
    }

    /// Declares the reactors of the main file, and all that they contain.
    fn declarations(&mut self) -> Vec<Class<'p>> {
        let mut ids: Vec<_> = (0..self.program.units.first().map_or(0, |unit| unit.ast.reactors.len()))
            .map(|reactor| ReactorId { unit: 0, reactor })
            .collect();
        let mut classes = Vec::new();
        let mut next = 0;
        while let Some(id) = ids.get(next).copied() {
            next += 1;
            let unit = &self.program.units[id.unit];
            let reactor = &unit.ast.reactors[id.reactor];
            names::check(reactor, &mut self.found);
            unsupported::check(reactor, &mut self.found);
            self.by_id.insert(id, ClassId(classes.len()));
            classes.push(self.declare(id, reactor));
            for instance in &reactor.body.instances {
                let contained = unit.scope.get(&instance.class.text).copied();
                if let Some(contained) = contained.filter(|contained| !ids.contains(contained)) {
                    ids.push(contained);
                }
            }
        }
        classes
    }

    /// Resolves the contained reactors of a class and checks the values of their parameters.
    fn children(&mut self, position: usize, classes: &mut [Class<'p>]) {
        let class = &classes[position];
        let scope = &self.program.units[class.id.unit].scope;
        self.lenient = class.opaque;
        let mut children = Vec::new();
        for instance in &class.ast.body.instances {
            let id = scope.get(&instance.class.text).and_then(|id| self.by_id.get(id)).copied();
            if id.is_none() {
                let name = &instance.class.text;
                let hint = did_you_mean(name, scope.keys().map(String::as_str))
                    .unwrap_or_else(|| format!("declare it, or import it: `import {name} from \"{name}.lf\"`"));
                let message = format!("there is no reactor `{name}` in this file");
                self.report(Diagnostic::new(Code::UnknownReactor, instance.class.span, message).hint(hint));
            }
            let is_main = class.ast.kind != ast::ReactorKind::Plain;
            let container = Container { is_main, parameters: &class.parameters };
            let max_wait = self.check_attributes(&instance.attributes, Target::Instance(container)).max_wait;
            let arguments = id.map_or_else(Vec::new, |id| self.arguments(instance, class, &classes[id.0]));
            children.push(Child { ast: instance, class: id, arguments, max_wait });
        }
        classes[position].children = children;
    }

    /// Finds a port by its reference, reporting what does not exist.
    pub(super) fn find_port(
        &mut self,
        reference: &ast::Reference,
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> Option<PortRef> {
        let name = &reference.name;
        let Some(container) = &reference.container else {
            let own = class.ports.iter().position(|port| port.name.text == name.text);
            if own.is_none() && !class.opaque {
                let names = class.ports.iter().map(|port| port.name.text.as_str());
                let message = format!("reactor `{}` has no port `{}`", class.name, name.text);
                let hint = did_you_mean(&name.text, names);
                self.report(Diagnostic::new(Code::UnknownPort, name.span, message).hint_maybe(hint));
            }
            return own.map(PortRef::Own);
        };
        let child = class.children.iter().position(|child| child.ast.name.text == container.text);
        let Some(child) = child else {
            if !class.opaque {
                let message = format!("reactor `{}` has no instance `{}`", class.name, container.text);
                let names = class.children.iter().map(|child| child.ast.name.text.as_str());
                let hint = did_you_mean(&container.text, names);
                self.report(Diagnostic::new(Code::UnknownInstance, container.span, message).hint_maybe(hint));
            }
            return None;
        };
        // An instance of an unknown reactor has been reported.
        let inner = &classes[class.children[child].class?.0];
        let port = inner.ports.iter().position(|port| port.name.text == name.text);
        if port.is_none() && !inner.opaque {
            let message = format!("`{}` is a `{}`, which has no port `{}`", container.text, inner.name, name.text);
            let names = inner.ports.iter().map(|port| port.name.text.as_str());
            let hint = did_you_mean(&name.text, names);
            self.report(
                Diagnostic::new(Code::UnknownPort, name.span, message)
                    .also(inner.ast.span(), "its declaration")
                    .hint_maybe(hint),
            );
        }
        port.map(|port| PortRef::Child(child, port))
    }

    /// Reports reactors that contain each other.
    fn cycles(&mut self, classes: &[Class<'p>]) {
        let mut done = vec![false; classes.len()];
        for start in 0..classes.len() {
            let mut path = Vec::new();
            self.visit(start, classes, &mut path, &mut done);
        }
    }

    fn visit(&mut self, at: usize, classes: &[Class<'p>], path: &mut Vec<(usize, Span)>, done: &mut [bool]) {
        if done[at] {
            return;
        }
        if path.len() > DEPTH_MAX {
            let message = format!("reactors contain each other more than {DEPTH_MAX} levels deep");
            let span = classes[at].ast.span();
            self.report(Diagnostic::new(Code::TooLarge, span, message).hint("make the hierarchy flatter"));
            done[at] = true;
            return;
        }
        for child in &classes[at].children {
            let Some(ClassId(class)) = child.class else { continue };
            path.push((at, child.ast.class.span));
            if let Some(start) = path.iter().position(|(open, _)| *open == class) {
                let mut names: Vec<_> = path[start..].iter().map(|(open, _)| classes[*open].name.as_str()).collect();
                names.push(&classes[class].name);
                let message = format!("these reactors contain each other without end: {}", names.join(" -> "));
                let mut diagnostic = Diagnostic::new(Code::CyclicInstantiation, child.ast.class.span, message)
                    .hint("a reactor cannot contain itself, neither directly nor through others");
                for (_, span) in &path[start..path.len() - 1] {
                    diagnostic = diagnostic.also(*span, "through this instance");
                }
                self.report(diagnostic);
            } else {
                self.visit(class, classes, path, done);
            }
            path.pop();
        }
        done[at] = true;
    }
}
