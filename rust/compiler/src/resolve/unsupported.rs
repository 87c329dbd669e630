// SPDX-License-Identifier: Apache-2.0
//! Features of the language that are read and then refused by name, so that nothing is ignored silently.

use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{Connection, Reaction, Reactor, ReactorKind, Reference};

/// Reports every unsupported feature in a reactor.
pub(super) fn check(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    let mut refuse = |span: Span, what: &str, hint: &str| {
        let message = format!("{what} not supported yet");
        found.push(Diagnostic::new(Code::Unsupported, span, message).hint(hint));
    };
    if let Some(span) = reactor.realtime {
        refuse(span, "`realtime` reactors are", "remove the word");
    }
    if let Some(span) = reactor.type_parameters.first() {
        refuse(*span, "type parameters of reactors are", "write one reactor for each type");
    }
    for name in &reactor.extends {
        refuse(name.span, "`extends` is", "contain the other reactor, or repeat its declarations");
    }
    let body = &reactor.body;
    for mode in &body.modes {
        refuse(mode.span, "modes are", "keep the mode in a state variable and test it in the reactions");
    }
    for method in &body.methods {
        refuse(method.name.span, "methods are", "write a function in a preamble that takes what it needs");
    }
    for watchdog in &body.watchdogs {
        refuse(watchdog.name.span, "watchdogs are", "schedule a logical action with a delay, or use a deadline");
    }
    for span in body.states.iter().filter_map(|state| state.reset) {
        refuse(span, "`reset` state variables are", "remove the word; without modes nothing is reset");
    }
    for port in &body.ports {
        if let Some(span) = port.mutable {
            refuse(span, "`mutable` inputs are", "remove the word and copy the value in the reaction");
        }
        if let Some(span) = port.width {
            refuse(span, "multiports are", "declare one port for each channel");
        }
    }
    for instance in &body.instances {
        if let Some(span) = instance.width {
            refuse(span, "banks of reactors are", "write one instance for each member");
        }
        if let Some(span) = instance.type_arguments {
            refuse(span, "type arguments of reactors are", "write one reactor for each type");
        }
    }
    check_hosts(reactor, found);
    body.connections.iter().for_each(|connection| check_connection(connection, found));
    body.reactions.iter().for_each(|reaction| check_reaction(reaction, found));
}

/// Only a federated reactor says where the RTI is, and only its instances can be placed.
fn check_hosts(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    if reactor.kind == ReactorKind::Federated {
        return;
    }
    for host in reactor.body.instances.iter().filter_map(|instance| instance.host.as_ref()) {
        let message = "only the instances in a federated reactor can be placed";
        let hint = "remove `at …`, or make the containing reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
    if let Some(host) = &reactor.host {
        let message = "only a federated reactor can say where its RTI is";
        let hint = "remove `at …`, or make the reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
}

fn check_connection(connection: &Connection, found: &mut Vec<Diagnostic>) {
    if let Some(span) = connection.serializer {
        let diagnostic = Diagnostic::new(Code::Unsupported, span, "`serializer` is not supported yet")
            .hint("remove it: values are sent in the layout of their type");
        found.push(diagnostic);
    }
    for reference in connection.left.iter().chain(&connection.right) {
        check_reference(reference, found);
    }
}

fn check_reference(reference: &Reference, found: &mut Vec<Diagnostic>) {
    if reference.interleaved {
        let diagnostic = Diagnostic::new(Code::Unsupported, reference.span, "`interleaved` is not supported yet")
            .hint("name the ports one by one");
        found.push(diagnostic);
    }
    if let Some(alias) = &reference.alias {
        let diagnostic = Diagnostic::new(Code::Unsupported, alias.span, "other names for ports are not supported yet")
            .hint("use the port's own name in the body");
        found.push(diagnostic);
    }
    if reference.transition {
        let diagnostic = Diagnostic::new(Code::Unsupported, reference.span, "mode transitions are not supported yet")
            .hint("keep the mode in a state variable");
        found.push(diagnostic);
    }
}

fn check_reaction(reaction: &Reaction, found: &mut Vec<Diagnostic>) {
    if reaction.mutation {
        let diagnostic = Diagnostic::new(Code::Unsupported, reaction.keyword, "mutations are not supported yet")
            .hint("use a reaction");
        found.push(diagnostic);
    }
    for trigger in reaction.triggers.iter().filter(|trigger| trigger.name.text == "reset") {
        let diagnostic = Diagnostic::new(Code::Unsupported, trigger.span, "the trigger `reset` is not supported yet")
            .hint("without modes nothing is reset; remove it");
        found.push(diagnostic);
    }
    for reference in reaction.triggers.iter().chain(&reaction.uses).chain(&reaction.effects) {
        check_reference(reference, found);
    }
}
