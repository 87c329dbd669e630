// SPDX-License-Identifier: Apache-2.0
//! Reactions: their triggers, uses and effects.

use super::checker::Checker;
use super::model::{CheckedReaction, Class, PortRef, ReactionVariable, Variable};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::syntax::ast::{self, Direction, Reference};

/// The list of a reaction that contains a name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum DependencyKind {
    Trigger,
    Use,
    Effect,
}

impl<'p> Checker<'p> {
    /// Checks the reactions of a class.
    pub(super) fn reactions(&mut self, position: usize, classes: &[Class<'p>]) -> Vec<CheckedReaction<'p>> {
        let class = &classes[position];
        let mut reactions = Vec::new();
        for declared in &class.ast.body.reactions {
            self.check_attributes(&declared.attributes, super::attributes::AttributeTarget::Other);
            if declared.triggers.is_empty() {
                let message = "this reaction has no trigger, so it never runs";
                let hint = "write what triggers it: `reaction(startup)`, or a timer, an action or an input";
                self.report(Diagnostic::new(Code::NoEffect, declared.keyword, message).hint(hint));
            }
            let is_external = declared.name.is_some() && self.language.facts().external_bodies;
            if declared.code.is_none() && !is_external {
                let message = "this reaction has no body, so it does nothing";
                let hint = if self.language.facts().external_bodies {
                    "write `{= … =}` behind the effects, or the name of a function that is the body: `reaction name(…)`"
                } else {
                    "write `{= … =}` behind the effects"
                };
                self.report(Diagnostic::new(Code::MissingBody, declared.keyword, message).hint(hint));
            }
            if let Some(absent_after) = declared.tardy.as_ref().and_then(|tardy| tardy.absent_after.as_ref()) {
                self.check_time(absent_after, "the offset of this handler", &class.parameters, false);
            }
            if let Some(deadline) = &declared.deadline {
                self.check_time(&deadline.value, "the deadline of this reaction", &class.parameters, false);
            }
            let mut parameters: Vec<ReactionVariable> = Vec::new();
            for (role, list) in [
                (DependencyKind::Trigger, &declared.triggers),
                (DependencyKind::Use, &declared.uses),
                (DependencyKind::Effect, &declared.effects),
            ] {
                for reference in list {
                    self.dependency(reference, role, declared.mode, class, classes, &mut parameters);
                }
            }
            reactions.push(CheckedReaction { ast: declared, parameters });
        }
        reactions
    }

    fn dependency(
        &mut self,
        reference: &Reference,
        role: DependencyKind,
        mode: Option<usize>,
        class: &Class<'p>,
        classes: &[Class<'p>],
        parameters: &mut Vec<ReactionVariable>,
    ) {
        let Some(variable) = self.variable(reference, role, mode, class, classes) else { return };
        if !self.check_role(reference, variable, role, class, classes) {
            return;
        }
        let name = match (&reference.alias, &reference.container) {
            (Some(alias), _) => alias.text.clone(),
            (None, Some(container)) => {
                format!("{}{}{}", container.text, self.language.facts().between_child_and_port, reference.name.text)
            }
            (None, None) => reference.name.text.clone(),
        };
        let known = parameters.iter_mut().find(|parameter| parameter.variable == variable);
        let Some(known) = known else {
            if let Some(other) = parameters.iter().find(|parameter| parameter.name == name) {
                let message = format!("two variables of this reaction are called `{name}`");
                let diagnostic = Diagnostic::new(Code::DuplicateName, reference.span, message)
                    .also(other.span, "the first one")
                    .hint("`child.port` is `child__port` in the body; rename the other one");
                self.report(diagnostic);
                return;
            }
            parameters.push(ReactionVariable {
                name,
                variable,
                triggers: role == DependencyKind::Trigger,
                uses: role == DependencyKind::Use,
                effect: role == DependencyKind::Effect,
                span: reference.span,
            });
            return;
        };
        let flag = match role {
            DependencyKind::Trigger => &mut known.triggers,
            DependencyKind::Use => &mut known.uses,
            DependencyKind::Effect => &mut known.effect,
        };
        if *flag {
            let message = format!("`{}` stands here twice", reference.text());
            let first = known.span;
            let diagnostic = Diagnostic::new(Code::DuplicateDependency, reference.span, message).hint("remove one");
            self.report(diagnostic.also(first, "the first one"));
        } else {
            *flag = true;
        }
    }

    /// Returns the meaning of a name in a reaction's head.
    fn variable(
        &mut self,
        reference: &Reference,
        role: DependencyKind,
        mode: Option<usize>,
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> Option<Variable> {
        if reference.container.is_some() {
            return self.find_port(reference, mode, class, classes).map(Variable::Port);
        }
        let name = reference.name.text.as_str();
        match name {
            "startup" if role == DependencyKind::Trigger => return Some(Variable::Startup),
            "shutdown" if role == DependencyKind::Trigger => return Some(Variable::Shutdown),
            "reset" if role == DependencyKind::Trigger => return Some(Variable::Reset),
            _ => {}
        }
        let is_mode = |mode: &ast::ModeSyntax| mode.name.as_ref().is_some_and(|mode| mode.text == name);
        if role == DependencyKind::Effect
            && (reference.transition.is_some() || class.ast.body.modes.iter().any(is_mode))
        {
            return self.transition(reference, mode, class);
        }
        let port = class.ports.iter().position(|port| port.name.text == name);
        let action = || class.actions.iter().position(|action| action.ast.name.text == name);
        let timer = || class.timers.iter().position(|timer| timer.name.text == name);
        let (found, declared) = if let Some(port) = port {
            return Some(Variable::Port(PortRef::Own(port)));
        } else if let Some(action) = action() {
            let declared = class.actions[action].ast;
            (Variable::Action(action), (declared.mode, declared.name.span))
        } else if let Some(timer) = timer() {
            let declared = class.timers[timer];
            (Variable::Timer(timer), (declared.mode, declared.name.span))
        } else {
            self.unknown_dependency(reference, class);
            return None;
        };
        self.check_mode(&reference.name, declared, mode, class).then_some(found)
    }

    /// Returns the mode that an effect names.
    fn transition(&mut self, effect: &Reference, here: Option<usize>, class: &Class<'p>) -> Option<Variable> {
        let names = || class.ast.body.modes.iter().map(|mode| mode.name.as_ref().map_or("", |name| &name.text));
        let wanted = effect.name.text.as_str();
        let Some(mode) = names().position(|name| name == wanted) else {
            let message = format!("reactor `{}` has no mode `{wanted}`", class.name);
            let hint = did_you_mean(wanted, names());
            self.report(Diagnostic::new(Code::UnknownName, effect.name.span, message).hint_maybe(hint));
            return None;
        };
        if here.is_none() {
            let message = "only a reaction in a mode can change the mode";
            let hint = "put the reaction into the mode that it leaves";
            self.report(Diagnostic::new(Code::OtherMode, effect.span, message).hint(hint));
            return None;
        }
        Some(Variable::Mode(mode, effect.transition.unwrap_or(ast::Transition::Reset)))
    }

    fn unknown_dependency(&mut self, reference: &Reference, class: &Class<'p>) {
        let name = reference.name.text.as_str();
        let member = |name| format!("{}{name}", self.language.facts().before_member);
        let hint = if class.ast.body.states.iter().any(|state| state.name.text == name) {
            Some(format!("state variables are not declared with reactions: the body has `{}`", member(name)))
        } else if class.parameters.iter().any(|parameter| parameter.name.text == name) {
            Some(format!("parameters are not declared with reactions: the body has `{}`", member(name)))
        } else if class.children.iter().any(|child| child.ast.name.text == name) {
            Some(format!("`{name}` is an instance; name one of its ports: `{name}.port`"))
        } else {
            let ports = class.ports.iter().map(|port| port.name.text.as_str());
            let actions = class.actions.iter().map(|action| action.ast.name.text.as_str());
            let timers = class.timers.iter().map(|timer| timer.name.text.as_str());
            did_you_mean(name, ports.chain(actions).chain(timers).chain(["startup", "shutdown", "reset"]))
        };
        let message = format!("reactor `{}` has no port, action or timer `{name}`", class.name);
        self.report(Diagnostic::new(Code::UnknownName, reference.span, message).hint_maybe(hint));
    }

    /// Checks whether a variable can be a trigger or use, or an effect.
    fn check_role(
        &mut self,
        reference: &Reference,
        variable: Variable,
        role: DependencyKind,
        class: &Class<'p>,
        classes: &[Class<'p>],
    ) -> bool {
        let text = reference.text();
        let readable_hint = "a reaction reads inputs of its reactor, outputs of contained reactors, actions and timers";
        let writable_hint = "a reaction writes outputs of its reactor, inputs of contained reactors, and actions";
        let timer_hint = "a timer has its own times; a reaction schedules a logical action";
        let problem = match (variable, role) {
            (Variable::Timer(_), DependencyKind::Effect) => {
                Some((Code::NotWritable, format!("timer `{text}` cannot be an effect"), timer_hint))
            }
            (Variable::Port(port), _) => {
                let input = class.port(port, classes).is_some_and(|port| port.direction == Direction::Input);
                let own = matches!(port, PortRef::Own(_));
                let kind = if input { "input" } else { "output" };
                let owner = if own { "this reactor" } else { "a contained reactor" };
                match (role == DependencyKind::Effect, input == own) {
                    (true, true) => {
                        let message = format!("`{text}` is an {kind} of {owner}, which a reaction cannot write");
                        Some((Code::NotWritable, message, writable_hint))
                    }
                    (false, false) => {
                        let message = format!("`{text}` is an {kind} of {owner}, which a reaction cannot read");
                        Some((Code::NotReadable, message, readable_hint))
                    }
                    _ => None,
                }
            }
            _ => None,
        };
        let Some((code, message, hint)) = problem else { return true };
        self.report(Diagnostic::new(code, reference.span, message).hint(hint));
        false
    }
}

/// Returns a reaction's head on one line, as it is written: `reaction(t) x -> y`.
pub(crate) fn signature(reaction: &ast::ReactionSyntax) -> String {
    let list = |references: &[Reference]| references.iter().map(Reference::text).collect::<Vec<_>>().join(", ");
    let mut text = match &reaction.name {
        Some(name) if reaction.kind == ast::ReactionKeyword::Watchdog => format!("watchdog {}", name.text),
        Some(name) => format!("reaction {}({})", name.text, list(&reaction.triggers)),
        None => format!("reaction({})", list(&reaction.triggers)),
    };
    if !reaction.uses.is_empty() {
        text = format!("{text} {}", list(&reaction.uses));
    }
    if !reaction.effects.is_empty() {
        text = format!("{text} -> {}", list(&reaction.effects));
    }
    text
}
