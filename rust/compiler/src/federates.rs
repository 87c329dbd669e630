// SPDX-License-Identifier: Apache-2.0
//! The partition of the instance tree: one federate per instance in the federated reactor.

use std::collections::BTreeMap;

use crate::arena::Arena;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::instances::{InstanceId, Tree};
use crate::resolve::{CheckedReaction, Class};
use crate::syntax::ast::{Host, ReactorKind};

/// One participant.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) name: String,
    /// Its top-level instance.
    pub(crate) top: InstanceId,
    pub(crate) host: Option<String>,
    /// Whether it comes and goes while the federation runs.
    pub(crate) is_transient: bool,
}

/// The participants of a program, and the participant of each instance.
#[derive(Debug)]
pub(crate) struct Participants {
    pub(crate) federated: bool,
    pub(crate) list: Vec<Part>,
    /// Per instance of the tree; `None` for the federated reactor itself.
    pub(crate) of: Arena<InstanceId, Option<usize>>,
}

/// Cuts the tree. A main reactor is one part.
pub(crate) fn cut(tree: &mut Tree, classes: &[Class<'_>], diagnostics: &mut Diagnostics) -> Participants {
    let root = tree.instances[InstanceId::MAIN].clone();
    let class = &classes[root.class.0];
    if class.ast.kind != ReactorKind::Federated {
        let part = Part { name: root.path.clone(), top: InstanceId::MAIN, host: None, is_transient: false };
        return Participants { federated: false, list: vec![part], of: Arena::of(&tree.instances, Some(0)) };
    }
    check_federated(class, diagnostics);
    let mut parts = Vec::new();
    for (child, members) in class.children.iter().zip(&root.children) {
        let host = child.ast.host.as_ref();
        if let Some(host) = host {
            check_host(host, diagnostics);
        }
        let host = host.map(|host| host.address.clone());
        for top in members {
            // A member of a bank has the name that it has in LF.
            let name = match tree.instances[*top].bank_index {
                Some(index) => format!("{}__{index}", child.ast.name.text),
                None => child.ast.name.text.clone(),
            };
            parts.push(Part { name, top: *top, host: host.clone(), is_transient: child.transient.is_some() });
        }
    }
    let mut of: Arena<InstanceId, Option<usize>> = Arena::default();
    for (position, instance) in tree.instances.iter() {
        let part = match instance.parent {
            None => None,
            Some(InstanceId::MAIN) => parts.iter().position(|part| part.top == position),
            Some(parent) => of[parent],
        };
        of.push(part);
    }
    for (position, part) in parts.iter().enumerate() {
        let child = tree.instances[part.top].child;
        let mut reactions = class.reactions.iter().map(CheckedReaction::children);
        if let Some(reaction) = reactions.position(|children| children.keys().all(|it| Some(*it) == child)) {
            check_share(class, reaction, &classes[tree.instances[part.top].class.0], diagnostics);
            tree.add_share(part.top);
            of.push(Some(position));
        }
    }
    Participants { federated: true, list: parts, of }
}

/// Reports a reaction of the federated reactor that would be in a federate of another language.
fn check_share(class: &Class<'_>, reaction: usize, federate: &Class<'_>, diagnostics: &mut Diagnostics) {
    let (outer, inner) = (class.language, federate.language);
    if outer != inner {
        let message = format!("this reaction is in {outer}, and would be in a federate with bodies in {inner}");
        let hint = format!("put it into a reactor of its own, or into `{}`", federate.name);
        let span = class.reactions[reaction].ast.keyword;
        diagnostics.push(Diagnostic::new(Code::FederatedReaction, span, message).hint(hint));
    }
}

/// The maximum length of a federate's name: systems accept up to 255 bytes for a file name, which contains more than
/// this name.
const NAME_MAX: usize = 120;

/// Reports elements that a federated reactor cannot have, and elements without an effect in it.
fn check_federated(class: &Class<'_>, diagnostics: &mut Diagnostics) {
    let body = &class.ast.body;
    for reaction in &class.reactions {
        check_reaction(reaction, class, diagnostics);
    }
    if class.children.is_empty() {
        let message = "this federated reactor contains nothing, so there are no federates";
        let hint = "each contained reactor is a federate: `a = new A()`";
        diagnostics.push(Diagnostic::new(Code::NoFederates, class.ast.span(), message).hint(hint));
    }
    let states = body.states.iter().map(|state| (state.name.span, "state variable"));
    let timers = body.timers.iter().map(|timer| (timer.name.span, "timer"));
    let actions = body.actions.iter().map(|action| (action.name.span, action.kind.name()));
    let preambles = body.preambles.iter().map(|preamble| (preamble.code.span, "preamble"));
    let all = states.chain(timers).chain(actions).chain(preambles);
    for (span, what) in all.filter(|_| class.reactions.is_empty()) {
        let message = format!("this {what} has no effect: this federated reactor only contains and connects");
        let hint = match what {
            "preamble" => "put it at the top of the file, where all reactors see it",
            _ => "put it into a contained reactor",
        };
        diagnostics.push(Diagnostic::new(Code::NoEffect, span, message).hint(hint));
    }
    if let Some(first) = class.children.first().and_then(|child| child.transient)
        && class.children.iter().all(|child| child.transient.is_some())
    {
        let message = "all federates are transient, so nobody is there at the start";
        let hint = "a federation lasts as long as its other federates: remove `@transient` from at least one";
        diagnostics.push(Diagnostic::new(Code::BadAttribute, first, message).hint(hint));
    }
    let mut names: BTreeMap<String, Span> = BTreeMap::new();
    for child in &class.children {
        let name = &child.ast.name;
        let lower = name.text.to_lowercase();
        if name.text.len() > NAME_MAX {
            let message = format!("the name of a federate is longer than {NAME_MAX} characters, and files have it");
            diagnostics.push(Diagnostic::new(Code::FederateNameClash, name.span, message).hint("shorten it"));
        }
        if lower == "rti" {
            let message = format!("a federate cannot be called `{}`, because the RTI has this name", name.text);
            diagnostics.push(Diagnostic::new(Code::FederateNameClash, name.span, message).hint("rename the instance"));
        }
        if let Some(first) = names.get(&lower) {
            let message = format!("the files of federate `{}` would have the name of another one's", name.text);
            let diagnostic = Diagnostic::new(Code::FederateNameClash, name.span, message)
                .also(*first, "the other federate")
                .hint("names of federates must differ in more than upper and lower case");
            // Equal names have been reported already.
            if class.children.iter().filter(|other| other.ast.name.text == name.text).count() == 1 {
                diagnostics.push(diagnostic);
            }
        } else {
            names.insert(lower, name.span);
        }
    }
}

/// Checks that a reaction of the federated reactor has one federate: the one whose ports it names; without ports, it
/// runs in all.
fn check_reaction(reaction: &CheckedReaction<'_>, class: &Class<'_>, diagnostics: &mut Diagnostics) {
    let children = reaction.children();
    let Some(((first, first_span), (last, last_span))) = children.first_key_value().zip(children.last_key_value())
    else {
        return;
    };
    let name = |child: usize| &class.children[child].ast.name.text;
    let (message, span, hint) = if first != last {
        let message = format!("this reaction names ports of two federates, `{}` and `{}`", name(*first), name(*last));
        (message, *last_span, "a reaction is in one federate; put it into a reactor, and connect that with both")
    } else if class.children[*first].ast.width.is_some() {
        let message = format!("this reaction names ports of `{}`, which is several federates", name(*first));
        (message, *first_span, "a reaction is in one federate; put it into the reactor that is a bank here")
    } else {
        return;
    };
    let mut diagnostic = Diagnostic::new(Code::FederatedReaction, span, message).hint(hint);
    if first != last {
        diagnostic = diagnostic.also(*first_span, "the first one");
    }
    diagnostics.push(diagnostic);
}

/// Reports a federate's user and port, which only other tools use.
fn check_host(host: &Host, diagnostics: &mut Diagnostics) {
    let idle = match (&host.user, host.port) {
        (Some(_), Some(_)) => "the user and the port",
        (Some(_), None) => "the user",
        (None, Some(_)) => "the port",
        (None, None) => return,
    };
    let message = format!("{idle} of a federate have no effect: only the RTI listens, and only on the RTI's own port");
    let hint = format!("write `at {}`", host.address);
    diagnostics.push(Diagnostic::new(Code::NoEffect, host.span, message).hint(hint));
}
