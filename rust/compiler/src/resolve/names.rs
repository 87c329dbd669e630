// SPDX-License-Identifier: Apache-2.0
//! Checks names: unique within a reactor, and valid in the target language.

use std::collections::BTreeMap;

use crate::diagnostics::{Code, Diagnostic, Span};
use crate::lexical::Language;
use crate::syntax::ast::{Name, ReactionKeyword, Reactor};

/// Reports double names and names that are invalid in the target language.
pub(super) fn check(reactor: &Reactor, language: Language, target: &str, diagnostics: &mut Vec<Diagnostic>) {
    let body = &reactor.body;
    let parameters = reactor.parameters.iter().map(|it| (&it.name, "parameter"));
    // A state variable may have a parameter's name: it usually keeps the parameter's value.
    let states = body.states.iter().map(|it| (&it.name, "state variable"));
    let methods = body.methods.iter().map(|it| (&it.name, "method"));
    let things = body.ports.iter().map(|it| (&it.name, "port"));
    let things = things.chain(body.timers.iter().map(|it| (&it.name, "timer")));
    let things = things.chain(body.actions.iter().map(|it| (&it.name, it.kind.name())));
    let things = things.chain(body.instances.iter().map(|it| (&it.name, "instance")));
    let modes = body.modes.iter().filter_map(|it| it.name.as_ref()).map(|name| (name, "mode"));
    let things = things.chain(modes);
    let reactions = body.reactions.iter().filter(|it| it.kind != ReactionKeyword::Watchdog);
    let reactions = reactions.filter_map(|it| it.name.as_ref()).map(|name| (name, "reaction"));
    for (names, in_bodies) in [
        (parameters.collect::<Vec<_>>(), false),
        (states.chain(methods).collect(), false),
        (things.chain(reactions).collect(), true),
    ] {
        unique(&names, diagnostics);
        for (name, what) in names {
            diagnostics.extend(problem(name, what, language.name_problem(&name.text, in_bodies, target), language));
        }
    }
    if let Some(name) = &reactor.name {
        // Code contains it only as a part of names.
        let reason = language.name_problem(&name.text, false, "");
        diagnostics.extend(problem(name, "reactor", reason, language));
    }
}

fn unique(names: &[(&Name, &str)], diagnostics: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, (Span, &str)> = BTreeMap::new();
    // Declarations are grouped by kind; the later one in the text is the one to report.
    let mut names = names.to_vec();
    names.sort_by_key(|(name, _)| name.span.start);
    for (name, what) in names {
        if let Some((first, first_what)) = seen.get(name.text.as_str()) {
            let article = if first_what.starts_with(['a', 'i']) { "an" } else { "a" };
            let message =
                format!("the name `{}` is already taken by {article} {first_what} of this reactor", name.text);
            let diagnostic = Diagnostic::new(Code::DuplicateName, name.span, message)
                .also(*first, "the first one")
                .hint(format!("rename the {what}"));
            diagnostics.push(diagnostic);
        } else {
            seen.insert(&name.text, (name.span, what));
        }
    }
}

/// Returns the problem of an invalid name, for a reason.
fn problem(name: &Name, what: &str, reason: Option<&str>, language: Language) -> Option<Diagnostic> {
    let reason = reason?;
    let article = if what.starts_with(['a', 'i']) { "an" } else { "a" };
    let message = format!("{article} {what} cannot be called `{}`: {reason}", name.text);
    let hint = format!("choose another name, for example `the_{}`", name.text.to_lowercase().trim_matches('_'));
    Some(Diagnostic::new(language.facts().name_code, name.span, message).hint(hint))
}
