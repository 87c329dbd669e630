// SPDX-License-Identifier: Apache-2.0
//! Checks modes: one of them is initial, names in a mode are visible in it only, and state in a mode has a rule for
//! reset.

use super::checker::Checker;
use super::model::{Class, Variable};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{ModeSyntax, Name, Reactor, ReactorKind, StateSyntax, Transition};

/// Reports modes of which none or several are initial, and those of a federated reactor.
pub(super) fn check(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    let body = &reactor.body;
    body.states.iter().for_each(|state| check_reset_state(state, found));
    let Some(first) = body.modes.first() else { return };
    if reactor.kind == ReactorKind::Federated {
        let hint = "put the modes into a reactor, and contain that: it becomes a federate";
        let diagnostic = Diagnostic::new(Code::BadMode, first.span, "a federated reactor has no modes");
        found.push(diagnostic.hint(hint));
    }
    let mut initial = body.modes.iter().filter(|mode| mode.initial);
    let Some(begins) = initial.next() else {
        let message = "none of the modes of this reactor is the initial one";
        let hint = "write `initial` before the mode in which it begins";
        found.push(Diagnostic::new(Code::BadMode, first.span, message).hint(hint));
        return;
    };
    for other in initial {
        let diagnostic = Diagnostic::new(Code::BadMode, other.span, "a reactor has one initial mode");
        found.push(diagnostic.also(begins.span, "the first one").hint("remove one of the words"));
    }
}

/// Reports a state variable with a reset and without a value for it.
fn check_reset_state(state: &StateSyntax, found: &mut Vec<Diagnostic>) {
    let Some(word) = state.reset.filter(|_| state.init.is_none()) else { return };
    let message = format!("state variable `{}` is to be reset, and has no initial value", state.name.text);
    let hint = format!("write one: `reset state {}: T = …`", state.name.text);
    found.push(Diagnostic::new(Code::MissingValue, word.to(state.name.span), message).hint(hint));
}

/// Returns the name of a mode in messages.
fn named(mode: Option<&ModeSyntax>) -> &str {
    mode.and_then(|mode| mode.name.as_ref()).map_or("", |name| name.text.as_str())
}

/// Returns whether a declaration in a mode is visible in another one, or outside of modes.
fn is_known(declared: Option<usize>, here: Option<usize>) -> bool {
    declared.is_none() || declared == here
}

impl<'p> Checker<'p> {
    /// Returns whether a declaration in a mode is visible at a place that names it; reports it if not.
    pub(super) fn check_mode(
        &mut self,
        named_at: &Name,
        declared: (Option<usize>, Span),
        here: Option<usize>,
        class: &Class<'p>,
    ) -> bool {
        let (mode, span) = declared;
        if is_known(mode, here) {
            return true;
        }
        let mode = named(mode.and_then(|mode| class.ast.body.modes.get(mode)));
        let message = format!("`{}` is declared in mode `{mode}`, and only known there", named_at.text);
        let hint = "declare it outside of the modes of this reactor, or use it in its mode";
        let diagnostic = Diagnostic::new(Code::OtherMode, named_at.span, message).hint(hint);
        self.report(diagnostic.also(span, "its declaration"));
        false
    }

    /// Reports state in a mode that is entered by reset, without a rule for what happens to it.
    pub(super) fn check_resets(&mut self, class: &Class<'p>, classes: &[Class<'p>]) {
        let effects = class.reactions.iter().flat_map(|reaction| &reaction.parameters);
        let mut entered: Vec<usize> = effects
            .filter_map(|effect| match effect.variable {
                Variable::Mode(mode, Transition::Reset) => Some(mode),
                _ => None,
            })
            .collect();
        entered.sort_unstable();
        entered.dedup();
        for mode in entered {
            let has_reset = class.reactions.iter().any(|reaction| {
                reaction.ast.mode == Some(mode) && reaction.parameters.iter().any(|it| it.variable == Variable::Reset)
            });
            let states = class.ast.body.states.iter().filter(|state| state.mode == Some(mode) && state.reset.is_none());
            for state in states.filter(|_| !has_reset) {
                let message =
                    format!("state variable `{}` is not reset when its mode is entered by `reset`", state.name.text);
                let hint = "write `reset state`, or a reaction in this mode that `reset` triggers; or declare it \
                            outside of the mode";
                self.report(Diagnostic::new(Code::NotReset, state.name.span, message).hint(hint));
            }
            for child in class.children.iter().filter(|child| child.ast.mode == Some(mode)) {
                let mut kept = Vec::new();
                child.class.into_iter().for_each(|inner| kept_states(&classes[inner.0], classes, 0, &mut kept));
                kept.dedup();
                if !kept.is_empty() {
                    let message = format!(
                        "`{}` has state that is not reset when its mode is entered by `reset`: {}",
                        child.ast.name.text,
                        kept.join(", ")
                    );
                    let hint = "write `reset state` there, or a reaction that `reset` triggers";
                    self.report(Diagnostic::new(Code::NotReset, child.ast.name.span, message).hint(hint));
                }
            }
        }
    }
}

/// The maximum depth to which reactors are searched; deeper ones have been reported.
const DEPTH_MAX: usize = 200;

/// Returns the state without a reset, of a reactor and of all that it contains.
fn kept_states(class: &Class<'_>, classes: &[Class<'_>], depth: usize, kept: &mut Vec<String>) {
    let has_reset = class.ast.body.reactions.iter().any(|it| it.triggers.iter().any(|by| by.name.text == "reset"));
    let states = class.ast.body.states.iter().filter(|state| !has_reset && state.reset.is_none());
    kept.extend(states.map(|state| format!("`{}` of `{}`", state.name.text, class.name)));
    let inner = class.children.iter().filter_map(|child| child.class).filter(|_| depth < DEPTH_MAX);
    inner.for_each(|inner| kept_states(&classes[inner.0], classes, depth + 1, kept));
}
