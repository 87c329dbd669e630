// SPDX-License-Identifier: Apache-2.0
//! The selection and the order of the reactors to check.

use super::attributes::{AttributeTarget, Attributes, Container};
use super::checker::Checker;
use super::expand::Expanded;
use super::load::Program;
use super::model::{CheckedChild, Class, ClassId};
use super::{macros, mains, modes, names, unsupported};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::syntax::ast;

/// The maximum nesting of reactors.
const DEPTH_MAX: usize = 200;

/// Checks every reactor of the main file, and those that they contain. Returns them with the position of the main or
/// federated one, if there is exactly one.
pub(crate) fn check<'p>(
    program: &'p Program,
    expanded: &'p [Expanded],
    diagnostics: &mut Diagnostics,
) -> (Vec<Class<'p>>, Option<ClassId>) {
    let mut checker = Checker { program, language: program.language(0), found: Vec::new() };
    let mut classes: Vec<Class<'p>> = Vec::new();
    for reactor in expanded {
        checker.language = program.language(reactor.id.unit);
        let target = program.target_name(reactor.id.unit);
        names::check(&reactor.ast, checker.language, target, &mut checker.found);
        unsupported::check(&reactor.ast, &mut checker.found);
        modes::check(&reactor.ast, &mut checker.found);
        if checker.language.facts().preprocessor {
            macros::check(program, reactor.id.unit, &reactor.ast, &mut checker.found);
        }
        classes.push(checker.declare(reactor));
    }
    for (position, reactor) in expanded.iter().enumerate() {
        checker.language = classes[position].language;
        checker.children(position, &reactor.children, &mut classes);
    }
    for position in 0..classes.len() {
        checker.language = classes[position].language;
        let connections = checker.connections(position, &classes);
        classes[position].connections = connections;
        let reactions = checker.reactions(position, &classes);
        classes[position].reactions = reactions;
        checker.writers(&classes[position], &classes);
        checker.check_resets(&classes[position], &classes);
    }
    checker.cycles(&classes);
    let main = mains::find(&mut checker, &classes);
    diagnostics.extend(checker.found);
    (classes, main)
}

impl<'p> Checker<'p> {
    /// Resolves the contained reactors of a class and checks the values of their parameters.
    fn children(&mut self, position: usize, found: &[Option<usize>], classes: &mut [Class<'p>]) {
        let class = &classes[position];
        let mut children = Vec::new();
        for (instance, id) in class.ast.body.instances.iter().zip(found) {
            let id = id.map(ClassId);
            if let Some(width) = &instance.width {
                self.check_width(width, &class.parameters);
            }
            let is_main = class.ast.kind != ast::ReactorKind::Plain;
            let is_federated = class.ast.kind == ast::ReactorKind::Federated;
            let container = Container { is_main, is_federated, parameters: &class.parameters };
            let Attributes { max_wait, transient, .. } =
                self.check_attributes(&instance.attributes, AttributeTarget::Instance(container));
            if let Some(ClassId(contained)) = id {
                self.check_language(instance, class, &classes[contained]);
            }
            let arguments = id.map_or_else(Vec::new, |id| self.arguments(instance, class, &classes[id.0]));
            children.push(CheckedChild { ast: instance, class: id, arguments, max_wait, transient });
        }
        classes[position].children = children;
    }

    /// Reports a contained reactor in another language than that of its container: only federates can be.
    fn check_language(&mut self, instance: &ast::Instantiation, class: &Class<'p>, contained: &Class<'p>) {
        let (outer, inner) = (class.language, contained.language);
        if outer == inner || class.ast.kind == ast::ReactorKind::Federated {
            return;
        }
        let message = format!("`{}` has bodies in {inner}, and what contains it has bodies in {outer}", contained.name);
        let diagnostic = Diagnostic::new(Code::WrongTarget, instance.class.span, message)
            .also(contained.ast.span(), "its declaration")
            .hint("federates can be in different languages, and each is in one: make it a federate, or translate it");
        self.report(diagnostic);
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
