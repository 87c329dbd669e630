// SPDX-License-Identifier: Apache-2.0
//! What a reactor declares.

use super::attributes::{Attributes, Target};
use super::checker::{Checker, is_opaque};
use super::model::{Action, Class, Parameter, Port, ReactorId, State};
use super::value::Destination;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::syntax::ast;

impl<'p> Checker<'p> {
    /// The declarations of a reactor with their types; contained reactors, connections and reactions follow later.
    pub(super) fn declare(&mut self, id: ReactorId, reactor: &'p ast::Reactor) -> Class<'p> {
        let name = match &reactor.name {
            Some(name) => name.text.clone(),
            None => super::mains::file_stem(&self.program.units[id.unit].path).to_owned(),
        };
        self.lenient = is_opaque(reactor);
        self.check_attributes(&reactor.attributes, Target::Other);
        let parameters = self.parameters(reactor);
        let states = self.states(reactor, &parameters);
        let ports = self.ports(reactor);
        for timer in &reactor.body.timers {
            self.check_attributes(&timer.attributes, Target::Other);
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
            ast: reactor,
            name,
            opaque: is_opaque(reactor),
            parameters,
            states,
            ports,
            timers: reactor.body.timers.iter().collect(),
            actions,
            children: Vec::new(),
            connections: Vec::new(),
            reactions: Vec::new(),
        }
    }

    fn parameters(&mut self, reactor: &'p ast::Reactor) -> Vec<Parameter<'p>> {
        let mut parameters: Vec<Parameter<'p>> = Vec::new();
        for declared in &reactor.parameters {
            self.check_attributes(&declared.attributes, Target::Other);
            // A default may name the parameters before it.
            let ty = self.value_type(declared.ty.as_ref(), declared.init.as_ref(), &declared.name, &parameters);
            if let Some(init) = &declared.init {
                let what = format!("parameter `{}`", declared.name.text);
                let place = Destination { what: &what, ty: &ty.text, ty_span: ty.span, is_time: ty.is_time };
                self.check_value(&init.value, place, &parameters);
            }
            parameters.push(Parameter {
                name: &declared.name,
                ty: ty.text,
                ty_span: ty.span,
                is_time: ty.is_time,
                default: declared.init.as_ref().map(|init| &init.value),
            });
        }
        parameters
    }

    fn states(&mut self, reactor: &'p ast::Reactor, parameters: &[Parameter<'p>]) -> Vec<State<'p>> {
        let mut states = Vec::new();
        for declared in &reactor.body.states {
            self.check_attributes(&declared.attributes, Target::Other);
            let ty = self.value_type(declared.ty.as_ref(), declared.init.as_ref(), &declared.name, parameters);
            if let Some(init) = &declared.init {
                let what = format!("state variable `{}`", declared.name.text);
                let place = Destination { what: &what, ty: &ty.text, ty_span: ty.span, is_time: ty.is_time };
                self.check_value(&init.value, place, parameters);
            }
            states.push(State {
                name: &declared.name,
                ty: ty.text,
                ty_span: ty.span,
                is_time: ty.is_time,
                init: declared.init.as_ref().map(|init| &init.value),
            });
        }
        states
    }

    fn ports(&mut self, reactor: &'p ast::Reactor) -> Vec<Port<'p>> {
        let mut ports = Vec::new();
        for declared in &reactor.body.ports {
            let target = if declared.direction == ast::Direction::Input { Target::Input } else { Target::Output };
            let Attributes { capacity, sending, .. } = self.check_attributes(&declared.attributes, target);
            let ty = self.signal_type(declared.ty.as_ref(), &declared.name);
            ports.push(Port {
                name: &declared.name,
                direction: declared.direction,
                ty: ty.text,
                ty_span: ty.span,
                wide: declared.width.is_some(),
                capacity,
                sending,
            });
        }
        ports
    }

    fn actions(&mut self, reactor: &'p ast::Reactor, parameters: &[Parameter<'p>]) -> Vec<Action<'p>> {
        let mut actions = Vec::new();
        for declared in &reactor.body.actions {
            let name = &declared.name.text;
            if let Some(delay) = &declared.min_delay {
                self.check_time(delay, &format!("the minimum delay of action `{name}`"), parameters, false);
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
            let capacity = self.check_attributes(&declared.attributes, Target::Queue).capacity;
            let ty = self.signal_type(declared.ty.as_ref(), &declared.name);
            actions.push(Action { ast: declared, ty: ty.text, ty_span: ty.span, capacity });
        }
        actions
    }

    /// The values that an instance gives to the parameters of its class, in the order of the class.
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
                if !class.opaque {
                    let message = format!("reactor `{}` has no parameter `{}`", class.name, name.text);
                    let names = class.parameters.iter().map(|parameter| parameter.name.text.as_str());
                    let hint = did_you_mean(&name.text, names);
                    let diagnostic = Diagnostic::new(Code::UnknownParameter, name.span, message).hint_maybe(hint);
                    self.report(diagnostic.also(class.ast.span(), "its declaration"));
                }
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
            self.check_value(&given.init.value, place, &container.parameters);
            arguments[position] = Some(&given.init.value);
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
}
