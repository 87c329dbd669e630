// SPDX-License-Identifier: Apache-2.0
//! The common state of all checks.

use super::load::Program;
use super::model::{Class, PortRef};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::lexical::Language;
use crate::syntax::ast;

/// The common state of all checks.
pub(super) struct Checker<'p> {
    pub(super) program: &'p Program,
    /// The language of the current reactor.
    pub(super) language: Language,
    pub(super) found: Vec<Diagnostic>,
}

impl<'p> Checker<'p> {
    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.found.push(diagnostic);
    }

    /// Finds a port by its reference in a mode, or outside of modes; reports a missing one.
    pub(super) fn find_port(
        &mut self,
        reference: &ast::Reference,
        mode: Option<usize>,
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> Option<PortRef> {
        let name = &reference.name;
        let Some(container) = &reference.container else {
            let own = class.ports.iter().position(|port| port.name.text == name.text);
            if own.is_none() {
                let names = class.ports.iter().map(|port| port.name.text.as_str());
                let message = format!("reactor `{}` has no port `{}`", class.name, name.text);
                let hint = did_you_mean(&name.text, names).or_else(|| ports(class));
                self.report(Diagnostic::new(Code::UnknownPort, name.span, message).hint_maybe(hint));
            }
            return own.map(PortRef::Own);
        };
        let child = class.children.iter().position(|child| child.ast.name.text == container.text);
        let Some(child) = child else {
            let message = format!("reactor `{}` has no instance `{}`", class.name, container.text);
            let names = class.children.iter().map(|child| child.ast.name.text.as_str());
            let known = class.children.iter().map(|child| child.ast.name.text.as_str());
            let hint = did_you_mean(&container.text, names).or_else(|| listed("its instances are", known));
            self.report(Diagnostic::new(Code::UnknownInstance, container.span, message).hint_maybe(hint));
            return None;
        };
        let declared = class.children[child].ast;
        if !self.check_mode(container, (declared.mode, declared.name.span), mode, class) {
            return None;
        }
        // An instance of an unknown reactor has been reported already.
        let inner = &classes[class.children[child].class?.0];
        let port = inner.ports.iter().position(|port| port.name.text == name.text);
        if port.is_none() {
            let message = format!("`{}` is a `{}`, which has no port `{}`", container.text, inner.name, name.text);
            let names = inner.ports.iter().map(|port| port.name.text.as_str());
            let hint = did_you_mean(&name.text, names).or_else(|| ports(inner));
            self.report(
                Diagnostic::new(Code::UnknownPort, name.span, message)
                    .also(inner.ast.span(), "its declaration")
                    .hint_maybe(hint),
            );
        }
        port.map(|port| PortRef::Child(child, port))
    }
}

/// Returns a sentence that lists the ports of a reactor.
fn ports(class: &Class<'_>) -> Option<String> {
    let of = |direction: ast::Direction| {
        let ports = class.ports.iter().filter(move |port| port.direction == direction);
        ports.map(|port| port.name.text.as_str())
    };
    let inputs = listed("its inputs are", of(ast::Direction::Input));
    let outputs = listed("its outputs are", of(ast::Direction::Output));
    match (inputs, outputs) {
        (Some(inputs), Some(outputs)) => Some(format!("{inputs}; {outputs}")),
        (inputs, outputs) => inputs.or(outputs).or_else(|| Some("it has no ports".to_owned())),
    }
}

/// Returns the first of some names in one sentence; `None` for no names.
fn listed<'n>(what: &str, names: impl Iterator<Item = &'n str>) -> Option<String> {
    const LISTED_MAX: usize = 8;
    let names: Vec<_> = names.collect();
    let shown: Vec<String> = names.iter().take(LISTED_MAX).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > LISTED_MAX { ", …" } else { "" };
    (!shown.is_empty()).then(|| format!("{what} {}{more}", shown.join(", ")))
}
