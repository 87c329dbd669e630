// SPDX-License-Identifier: Apache-2.0
//! Properties of a class that do not depend on the language of its bodies.

use super::bodies::ReactionPart;
use crate::emit::EmitError;
use crate::emit::view::View;
use crate::plan::{
    BANK_INDEX, Child, Federate, InstanceIndex, ModeIndex, Parameter, Plan, Reaction, ReactorClass, SourceCode, Tardy,
    Value,
};

/// The value of a contained reactor's parameter.
#[derive(Clone, Copy)]
pub(in crate::emit) enum GivenValue<'v> {
    /// A value that the container computes.
    Value(&'v Value),
    /// The index of the member of a bank.
    Member,
    /// The parameter's default.
    Default,
}

impl View<'_> {
    /// Returns the value of each parameter of a contained reactor.
    ///
    /// # Errors
    /// A parameter that has no value.
    pub(in crate::emit) fn given<'v>(
        &'v self,
        child: &'v Child,
    ) -> Result<Vec<(&'v Parameter, GivenValue<'v>)>, EmitError> {
        let parameters = &self.class(child.class).parameters;
        let given = |(parameter, argument): (&'v Parameter, &'v Option<Value>)| {
            let given = match argument {
                Some(value) => GivenValue::Value(value),
                None if child.is_bank && parameter.name == BANK_INDEX => GivenValue::Member,
                None if parameter.default.is_some() => GivenValue::Default,
                None => {
                    let message = format!("`{}` has no value for `{}`", child.name, parameter.name);
                    return Err(EmitError::new(self.plan, child.at, message));
                }
            };
            Ok((parameter, given))
        };
        parameters.iter().zip(&child.arguments).map(given).collect()
    }

    /// Returns whether a value names a variable.
    pub(in crate::emit) fn mentions(&self, value: &Value, name: &str) -> bool {
        let Value::Code(code) = value else { return false };
        let name = name.strip_prefix("r#").unwrap_or(name);
        self.language.words(&code.text).any(|word| word == name)
    }

    /// Returns whether the arguments of a bank's members name the index of the member, and the class has no parameter
    /// of this name.
    pub(in crate::emit) fn counts_members(&self, class: &ReactorClass, child: &Child) -> bool {
        child.is_bank
            && child.arguments.iter().flatten().any(|value| self.mentions(value, BANK_INDEX))
            && !class.parameters.iter().any(|parameter| parameter.name == BANK_INDEX)
    }
}

impl ReactorClass {
    /// Returns all code and all types of the class, as they are written.
    pub(in crate::emit) fn codes(&self) -> impl Iterator<Item = &str> {
        let parameters = self.parameters.iter().map(|parameter| (&parameter.ty, parameter.default.as_ref()));
        let state = self.state.iter().map(|state| (&state.ty, state.init.as_ref()));
        let arguments = self.children.iter().flat_map(|child| child.arguments.iter().flatten());
        let (types, values): (Vec<_>, Vec<_>) = parameters.chain(state).unzip();
        let types = types.into_iter().chain(self.types.iter().map(|(_, ty)| ty));
        let types = types.chain(self.ports.iter().map(|port| &port.ty)).chain(self.actions.iter().map(|it| &it.ty));
        let given = self.methods.iter().flat_map(|method| method.arguments.iter().map(|(_, ty)| ty));
        let types = types.chain(given).chain(self.methods.iter().filter_map(|method| method.ty.as_ref()));
        let values = values.into_iter().flatten().chain(arguments).filter_map(|value| match value {
            Value::Code(code) => Some(code),
            Value::Time { .. } => None,
        });
        let reactions = self.reactions.iter().flat_map(|reaction| ReactionPart::ALL.map(|part| part.code(reaction)));
        let methods = self.methods.iter().map(|method| &method.body);
        let codes = self.preambles.iter().chain(values).chain(reactions.flatten()).chain(methods);
        codes.map(|code| code.text.as_str()).chain(types.map(|ty| ty.text.as_str()))
    }

    /// Returns whether the class has a state variable of this name, which hides the parameter of the same name from
    /// bodies.
    pub(in crate::emit) fn has_state(&self, name: &str) -> bool {
        self.state.iter().any(|state| state.name == name)
    }
}

impl Plan {
    /// Returns, by mode of a federate, the instances to reset when it is entered, with the mode of the instance's own
    /// whose state is meant, or none.
    pub(in crate::emit) fn resets(&self, federate: &Federate) -> Vec<Vec<(InstanceIndex, Option<usize>)>> {
        let resets = |(id, mode): (usize, &crate::plan::Mode)| {
            let of = |(index, instance): (usize, &crate::plan::Instance)| {
                let own = (mode.instance.0 == index).then_some(Some(mode.declared));
                let whole = (instance.mode == Some(ModeIndex(id))).then_some(None);
                let class = self.class(instance);
                let of = [own, whole].into_iter().flatten().filter(|of| class.has_resets(*of));
                of.map(|of| (InstanceIndex(index), of)).collect::<Vec<_>>()
            };
            federate.instances.iter().enumerate().flat_map(of).collect()
        };
        federate.modes.iter().enumerate().map(resets).collect()
    }
}

impl ReactionPart {
    /// All parts, the body first.
    pub(in crate::emit) const ALL: [Self; 3] = [Self::Body, Self::MissedDeadline, Self::Tardy];

    /// Returns the code of this part of a reaction.
    pub(in crate::emit) fn code(self, reaction: &Reaction) -> Option<&SourceCode> {
        match (self, &reaction.tardy) {
            (Self::Body, _) => Some(&reaction.body),
            (Self::MissedDeadline, _) => reaction.deadline.as_ref(),
            (Self::Tardy, Some(Tardy::Handler(code))) => Some(code),
            (Self::Tardy, _) => None,
        }
    }

    /// Returns the part that runs instead of this one: for `tardy` without code the body, which handles tardy inputs
    /// itself.
    pub(in crate::emit) fn run(self, reaction: &Reaction) -> Option<Self> {
        let is_body = self == Self::Tardy && matches!(reaction.tardy, Some(Tardy::Body));
        let part = if is_body { Self::Body } else { self };
        part.code(reaction).map(|_| part)
    }

    /// Returns the suffix of the names of the functions for this part.
    pub(in crate::emit) fn suffix(self) -> &'static str {
        match self {
            Self::Body => "",
            Self::MissedDeadline => "_deadline",
            Self::Tardy => "_tardy",
        }
    }
}
