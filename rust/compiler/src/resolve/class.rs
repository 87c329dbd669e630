// SPDX-License-Identifier: Apache-2.0
//! The declarations of a reactor.

use super::attributes::{AttributeTarget, Attributes};
use super::checker::Checker;
use super::expand::Expanded;
use super::model::{CheckedAction, CheckedMethod, CheckedParameter, CheckedPort, CheckedState, Class, ClassId};
use super::value::Destination;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::plan::BANK_INDEX;
use crate::syntax::ast;

impl<'p> Checker<'p> {
    /// Returns the declarations of a reactor with their types; contained reactors, connections and reactions follow
    /// later.
    pub(super) fn declare(&mut self, expanded: &'p Expanded) -> Class<'p> {
        let (id, reactor) = (expanded.id, &expanded.ast);
        let name = match &reactor.name {
            Some(name) => name.text.clone(),
            None => super::mains::file_stem(&self.program.units[id.unit].path).to_owned(),
        };
        let is_main = reactor.kind != ast::ReactorKind::Plain;
        self.check_attributes(
            &reactor.attributes,
            if is_main { AttributeTarget::Main } else { AttributeTarget::Other },
        );
        let parameters = self.parameters(reactor);
        let states = self.states(reactor, &parameters);
        let ports = self.ports(reactor, &parameters);
        for timer in &reactor.body.timers {
            self.check_attributes(&timer.attributes, AttributeTarget::Other);
            let name = &timer.name.text;
            if let Some(offset) = &timer.offset {
                self.check_time(offset, &format!("the offset of timer `{name}`"), &parameters, false);
            }
            if let Some(period) = &timer.period {
                self.check_time(period, &format!("the period of timer `{name}`"), &parameters, false);
            }
        }
        let actions = self.actions(reactor, &parameters);
        if reactor.kind == ast::ReactorKind::Plain && reactor.name.is_none() {
            let diagnostic = Diagnostic::new(Code::Syntax, reactor.keyword, "this reactor has no name")
                .hint("only main and federated reactors can go without a name");
            self.report(diagnostic);
        }
        Class {
            id,
            language: self.language,
            types: &expanded.types,
            files: &expanded.files,
            users: expanded.users.iter().map(|user| ClassId(*user)).collect(),
            ast: reactor,
            name,
            parameters,
            states,
            ports,
            timers: reactor.body.timers.iter().collect(),
            actions,
            methods: reactor.body.methods.iter().map(|method| self.method(method)).collect(),
            children: Vec::new(),
            connections: Vec::new(),
            reactions: Vec::new(),
        }
    }

    fn parameters(&mut self, reactor: &'p ast::Reactor) -> Vec<CheckedParameter<'p>> {
        let mut parameters: Vec<CheckedParameter<'p>> = Vec::new();
        for declared in &reactor.parameters {
            self.check_attributes(&declared.attributes, AttributeTarget::Other);
            // A default may name the parameters before it.
            let ty = self.value_type(declared.ty.as_ref(), declared.init.as_ref(), &declared.name, &parameters);
            if let Some(init) = &declared.init {
                let what = format!("parameter `{}`", declared.name.text);
                let place = Destination { what: &what, ty: &ty.text, ty_span: ty.span, is_time: ty.is_time };
                self.check_value(&init.value, place, &parameters);
            }
            parameters.push(CheckedParameter {
                name: &declared.name,
                ty: ty.text,
                ty_span: ty.span,
                is_time: ty.is_time,
                default: declared.init.as_ref().map(|init| &init.value),
            });
        }
        parameters
    }

    fn states(&mut self, reactor: &'p ast::Reactor, parameters: &[CheckedParameter<'p>]) -> Vec<CheckedState<'p>> {
        let mut states = Vec::new();
        for declared in &reactor.body.states {
            let attributes = self.check_attributes(&declared.attributes, AttributeTarget::State);
            let sending = self.state_sending(attributes);
            let ty = self.value_type(declared.ty.as_ref(), declared.init.as_ref(), &declared.name, parameters);
            if let Some(init) = &declared.init {
                let what = format!("state variable `{}`", declared.name.text);
                let place = Destination { what: &what, ty: &ty.text, ty_span: ty.span, is_time: ty.is_time };
                self.check_value(&init.value, place, parameters);
            }
            states.push(CheckedState {
                resets: declared.reset.is_some(),
                mode: declared.mode,
                handed_over: attributes.handed_over.then_some(sending),
                name: &declared.name,
                ty: ty.text,
                ty_span: ty.span,
                is_time: ty.is_time,
                init: declared.init.as_ref().map(|init| &init.value),
            });
        }
        states
    }

    fn ports(&mut self, reactor: &'p ast::Reactor, parameters: &[CheckedParameter<'p>]) -> Vec<CheckedPort<'p>> {
        let mut ports = Vec::new();
        for declared in &reactor.body.ports {
            let target = if declared.direction == ast::Direction::Input {
                AttributeTarget::Input
            } else {
                AttributeTarget::Output
            };
            let Attributes { capacity, sending, .. } = self.check_attributes(&declared.attributes, target);
            let ty = self.signal_type(declared.ty.as_ref(), &declared.name);
            if let Some(width) = &declared.width {
                self.check_width(width, parameters);
            }
            ports.push(CheckedPort {
                name: &declared.name,
                direction: declared.direction,
                mutable: declared.mutable,
                ty: ty.text,
                ty_span: ty.span,
                width: declared.width.as_ref(),
                capacity,
                sending,
            });
        }
        ports
    }

    /// Reports terms that are invalid in a width.
    pub(super) fn check_width(&mut self, width: &ast::Width, scope: &[CheckedParameter<'p>]) {
        if width.terms.is_empty() {
            let message = "this width is left open, and has to be known when the program is compiled";
            let hint = "write a number or a parameter: `[4]`";
            self.report(Diagnostic::new(Code::BadWidth, width.span, message).hint(hint));
        }
        for term in &width.terms {
            let ast::WidthTerm::Value(value) = term else { continue };
            match &value.kind {
                ast::ExpressionKind::Name(name) if scope.iter().all(|it| it.name.text != *name) => {
                    self.unknown_parameter(name, value.span, scope);
                }
                ast::ExpressionKind::Name(_)
                | ast::ExpressionKind::Code(_)
                | ast::ExpressionKind::Literal(ast::Literal::Int(_)) => {}
                _ => {
                    let diagnostic = Diagnostic::new(Code::BadWidth, value.span, "a width is a number");
                    self.report(diagnostic.hint("write a number, a parameter, or code that gives one"));
                }
            }
        }
    }

    fn actions(&mut self, reactor: &'p ast::Reactor, parameters: &[CheckedParameter<'p>]) -> Vec<CheckedAction<'p>> {
        let mut actions = Vec::new();
        for declared in &reactor.body.actions {
            let name = &declared.name.text;
            let is_watchdog = declared.kind == ast::ActionKind::Watchdog;
            if let Some(delay) = &declared.min_delay {
                let what = if is_watchdog { "the timeout of watchdog" } else { "the minimum delay of action" };
                self.check_time(delay, &format!("{what} `{name}`"), parameters, false);
            }
            if let Some(spacing) = &declared.min_spacing {
                self.check_time(spacing, &format!("the minimum spacing of action `{name}`"), parameters, false);
            }
            if let Some(policy) = &declared.policy {
                const POLICIES: [&str; 4] = ["defer", "drop", "replace", "update"];
                if !POLICIES.contains(&policy.text.as_str()) {
                    let message = format!("there is no policy \"{}\"", policy.text);
                    let hint = did_you_mean(&policy.text, POLICIES)
                        .unwrap_or_else(|| "policies are \"defer\", \"drop\", \"replace\" and \"update\"".to_owned());
                    self.report(Diagnostic::new(Code::BadPolicy, policy.span, message).hint(hint));
                }
            }
            let target = if is_watchdog { AttributeTarget::Other } else { AttributeTarget::Queue };
            let capacity = self.check_attributes(&declared.attributes, target).capacity;
            let ty = self.signal_type(declared.ty.as_ref(), &declared.name);
            actions.push(CheckedAction { ast: declared, ty: ty.text, ty_span: ty.span, capacity });
        }
        actions
    }

    fn method(&mut self, declared: &'p ast::MethodSyntax) -> CheckedMethod<'p> {
        let mut arguments = Vec::new();
        for (name, ty) in &declared.arguments {
            let ty = self.value_type(ty.as_ref(), None, name, &[]);
            arguments.push((name.text.clone(), ty.text, ty.span));
        }
        let ty = declared.ty.as_ref().map(|ty| self.signal_type(Some(ty), &declared.name));
        CheckedMethod { ast: declared, arguments, ty: ty.map(|ty| (ty.text, ty.span)) }
    }

    /// Returns the arguments of an instance, in the order of its class's parameters.
    pub(super) fn arguments(
        &mut self,
        instance: &'p ast::Instantiation,
        container: &Class<'p>,
        class: &Class<'p>,
    ) -> Vec<Option<&'p ast::Expression>> {
        let mut arguments: Vec<Option<&'p ast::Expression>> = vec![None; class.parameters.len()];
        for given in &instance.arguments {
            let name = &given.name;
            let position = class.parameters.iter().position(|parameter| parameter.name.text == name.text);
            let Some(position) = position else {
                let message = format!("reactor `{}` has no parameter `{}`", class.name, name.text);
                let names = class.parameters.iter().map(|parameter| parameter.name.text.as_str());
                let hint = did_you_mean(&name.text, names);
                let diagnostic = Diagnostic::new(Code::UnknownParameter, name.span, message).hint_maybe(hint);
                self.report(diagnostic.also(class.ast.span(), "its declaration"));
                continue;
            };
            if let Some(first) = arguments[position] {
                let message = format!("parameter `{}` is given twice", name.text);
                let diagnostic = Diagnostic::new(Code::DuplicateValue, name.span, message).hint("remove one of them");
                self.report(diagnostic.also(first.span, "the first value"));
                continue;
            }
            let parameter = &class.parameters[position];
            let what = format!("parameter `{}` of `{}`", name.text, class.name);
            let place =
                Destination { what: &what, ty: &parameter.ty, ty_span: parameter.ty_span, is_time: parameter.is_time };
            // The index of a bank's member is no parameter of the container.
            let member = instance.width.is_some()
                && matches!(&given.init.value.kind, ast::ExpressionKind::Name(name) if name == BANK_INDEX);
            let mut value = &given.init.value;
            if !member || container.parameters.iter().any(|parameter| parameter.name.text == BANK_INDEX) {
                if container.language != class.language {
                    value = self.translatable(value, container, class);
                }
                // The value belongs to the contained reactor's language.
                self.language = class.language;
                self.check_value(value, place, &container.parameters);
                self.language = container.language;
            }
            arguments[position] = Some(value);
        }
        for (parameter, given) in class.parameters.iter().zip(&arguments) {
            if parameter.default.is_none() && given.is_none() {
                let name = &parameter.name.text;
                let message = format!("parameter `{name}` of `{}` has no value", class.name);
                let hint = format!("give it here, `{}({name} = …)`, or give it a default", class.name);
                let diagnostic = Diagnostic::new(Code::MissingValue, instance.name.span, message).hint(hint);
                self.report(diagnostic.also(parameter.name.span, "declared without a default"));
            }
        }
        arguments
    }

    /// Returns a value that has the same meaning in another language: a literal, also instead of a parameter with such
    /// a default.
    fn translatable(
        &mut self,
        value: &'p ast::Expression,
        container: &Class<'p>,
        class: &Class<'p>,
    ) -> &'p ast::Expression {
        let mut found = value;
        let mut earlier = &container.parameters[..];
        while let ast::ExpressionKind::Name(name) = &found.kind {
            let Some(position) = earlier.iter().position(|parameter| parameter.name.text == *name) else { break };
            let Some(default) = earlier[position].default else { break };
            (found, earlier) = (default, &earlier[..position]);
        }
        if matches!(found.kind, ast::ExpressionKind::Code(_)) {
            let (outer, inner) = (container.language, class.language);
            let message = format!("this value is code of {outer}, and `{}` has bodies in {inner}", class.name);
            let mut diagnostic = Diagnostic::new(Code::WrongValue, value.span, message);
            if found.span != value.span {
                diagnostic = diagnostic.also(found.span, "the code");
            }
            self.report(diagnostic.hint("give a number, a time, a text or another literal"));
        }
        found
    }
}
