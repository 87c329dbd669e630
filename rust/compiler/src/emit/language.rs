// SPDX-License-Identifier: Apache-2.0
//! A plan as the crates in one of its languages see it.

use std::borrow::Cow;

use crate::languages::{self, Language, Preambles};
use crate::plan::{Cargo, ClassIndex, Federate, NativeCode, NetworkInput, Plan, Shape};

use super::EmitError;

impl Plan {
    /// The language of a class's bodies.
    pub(crate) fn language(&self, class: ClassIndex) -> &'static dyn Language {
        let own = self.files[self.classes[class.0].at.file.0].language.as_deref();
        languages::named(own.unwrap_or(&self.target.language)).unwrap_or_else(languages::default)
    }

    /// The language of a federate's bodies.
    pub(crate) fn language_of(&self, federate: &Federate) -> &'static dyn Language {
        self.language(federate.instances.first().map_or(self.main, |instance| instance.class))
    }

    /// Whether a class is in another language than the plan as it is.
    pub(crate) fn is_foreign(&self, class: ClassIndex) -> bool {
        self.files[self.classes[class.0].at.file.0].language.is_some()
    }

    /// The plan as the crates in one of its languages see it: without the code of others, and with a federated reactor
    /// that only contains.
    pub(crate) fn in_language(&self, language: &'static dyn Language) -> Cow<'_, Self> {
        if self.files.iter().all(|file| file.language.is_none()) {
            return Cow::Borrowed(self);
        }
        let mut plan = self.clone();
        plan.target.c.retain(|at| {
            let own = self.files[at.file.0].language.as_deref();
            own.unwrap_or(&self.target.language) == language.name()
        });
        for file in &mut plan.files {
            let own = file.language.take().unwrap_or_else(|| self.target.language.clone());
            if own != language.name() {
                file.preambles.clear();
                file.language = Some(own);
            }
        }
        language.name().clone_into(&mut plan.target.language);
        if language.name() == "C" {
            let Cargo { build_type, .. } = plan.target.cargo;
            plan.target.cargo = Cargo { build_type, ..Cargo::default() };
        } else {
            let NativeCode { sources, headers, folders, cmake, definitions, .. } = plan.target.c;
            plan.target.c = NativeCode { sources, headers, folders, cmake, definitions, ..NativeCode::default() };
        }
        if plan.is_foreign(plan.main) {
            let main = &mut plan.classes[plan.main.0];
            main.preambles.clear();
            main.parameters.clear();
            main.state.clear();
            main.actions.clear();
            main.timers.clear();
            main.watchdogs.clear();
            main.methods.clear();
            main.reactions.clear();
        }
        Cow::Owned(plan)
    }

    /// How many bytes the values take at most that an RTI passes on between federates of other languages than this.
    ///
    /// # Errors
    /// A connection of which that is not known.
    pub(crate) fn lengths_beside(&self, language: &'static dyn Language) -> Result<Vec<u64>, EmitError> {
        let mut lengths = Vec::new();
        for receiver in &self.federates {
            let is_other = |federate: &Federate| self.language_of(federate).name() != language.name();
            for input in receiver.inputs.iter().filter(|input| !input.direct && is_other(receiver)) {
                if self.federates.iter().find(|sender| sender.id == input.federate).is_some_and(is_other) {
                    lengths.push(self.length(receiver, input, language)?);
                }
            }
        }
        Ok(lengths)
    }

    fn length(&self, receiver: &Federate, input: &NetworkInput, rti: &dyn Language) -> Result<u64, EmitError> {
        let known = input.serializer.as_ref().and_then(|serializer| serializer.max_length);
        let all: Vec<String> =
            self.files.iter().flat_map(|file| &file.preambles).map(|preamble| preamble.text.clone()).collect();
        let preambles = Preambles { visible: &all, all: &all };
        let shape = self.language_of(receiver).shape(&input.ty.text, preambles).ok();
        let length = match &shape {
            Some(Shape::List(element)) => element.size().zip(known).map(|(size, known)| size * known as u64),
            Some(Shape::Text) => known.map(|known| known as u64 + 1),
            shape => known.map(|known| known as u64).or(shape.as_ref().and_then(Shape::size)),
        };
        length.ok_or_else(|| {
            let message = format!(
                "the RTI is part of an image of {}, and cannot know how long values of `{}` are: give it a place of \
                 its own, on a computer",
                rti.name(),
                input.name
            );
            EmitError::new(self, input.at, message)
        })
    }
}
