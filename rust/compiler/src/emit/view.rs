// SPDX-License-Identifier: Apache-2.0
//! A plan as the crates in one of its languages see it.

use super::file::EmitError;
use crate::languages::Preambles;
use crate::lexical::Language;
use crate::plan::{
    Cargo, ClassIndex, Federate, FileIndex, Location, NativeCode, NetworkInput, Plan, ReactorClass, Shape, SourceCode,
};

/// A plan without the code of other languages than one. Crates in that language hold what it shows.
///
/// The plan itself has all data that do not depend on a language.
#[derive(Debug)]
pub(crate) struct View<'p> {
    pub(crate) plan: &'p Plan,
    pub(crate) language: Language,
    /// The program's settings for the C compiler, as far as they are for this language.
    pub(crate) native: NativeCode,
    /// The program's settings for cargo, as far as they are for this language.
    pub(crate) cargo: Cargo,
    /// The federated reactor without its code, if that is in another language.
    container: Option<ReactorClass>,
}

impl<'p> View<'p> {
    pub(crate) fn new(plan: &'p Plan, language: Language) -> Self {
        let is_own = |at: Location| plan.language_of_file(at.file) == language;
        let (native, cargo) = if language.facts().native_bodies {
            let cargo = Cargo { build_type: plan.target.cargo.build_type, ..Cargo::default() };
            (plan.target.c.clone(), cargo)
        } else {
            let NativeCode { sources, headers, folders, cmake, definitions, .. } = plan.target.c.clone();
            let native = NativeCode { sources, headers, folders, cmake, definitions, ..NativeCode::default() };
            (native, plan.target.cargo.clone())
        };
        let native = native.of(is_own);
        let main = &plan.classes[plan.main.0];
        let container = (!is_own(main.at)).then(|| main.only_containing());
        Self { plan, language, native, cargo, container }
    }

    /// Returns a class: the federated reactor without its code, if that is in another language.
    pub(crate) fn class(&self, index: ClassIndex) -> &ReactorClass {
        match &self.container {
            Some(container) if index == self.plan.main => container,
            _ => &self.plan.classes[index.0],
        }
    }

    /// Returns whether the bodies of a class are in this language.
    pub(crate) fn is_own(&self, class: ClassIndex) -> bool {
        self.plan.language_of_class(class) == self.language
    }

    /// Returns the preambles of a file; none of a file in another language.
    pub(crate) fn preambles(&self, file: FileIndex) -> &'p [SourceCode] {
        let is_own = self.plan.language_of_file(file) == self.language;
        if is_own { &self.plan.files[file.0].preambles } else { &[] }
    }
}

impl Plan {
    fn language_of_file(&self, file: FileIndex) -> Language {
        self.files[file.0].language.unwrap_or(self.target.language)
    }

    /// Returns the language of a class's bodies.
    pub(crate) fn language_of_class(&self, class: ClassIndex) -> Language {
        self.language_of_file(self.classes[class.0].at.file)
    }

    /// Returns the language of a federate's bodies.
    pub(crate) fn language_of(&self, federate: &Federate) -> Language {
        self.language_of_class(federate.instances.first().map_or(self.main, |instance| instance.class))
    }

    /// Returns the maximum lengths of the values that an RTI forwards between federates of other languages than this.
    ///
    /// # Errors
    /// A connection of which the length is unknown.
    pub(crate) fn lengths_beside(&self, language: Language) -> Result<Vec<u64>, EmitError> {
        let mut lengths = Vec::new();
        for receiver in &self.federates {
            let is_other = |federate: &Federate| self.language_of(federate) != language;
            for input in receiver.inputs.iter().filter(|input| !input.direct && is_other(receiver)) {
                if self.federates.iter().find(|sender| sender.id == input.federate).is_some_and(is_other) {
                    lengths.push(self.length(receiver, input, language)?);
                }
            }
        }
        Ok(lengths)
    }

    fn length(&self, receiver: &Federate, input: &NetworkInput, rti: Language) -> Result<u64, EmitError> {
        let known = input.serializer.as_ref().and_then(|serializer| serializer.max_length);
        let all: Vec<String> =
            self.files.iter().flat_map(|file| &file.preambles).map(|preamble| preamble.text.clone()).collect();
        let preambles = Preambles { visible: &all, all: &all };
        let shape = (self.language_of(receiver).facts().shape)(&input.ty.text, preambles).ok();
        let length = match &shape {
            Some(Shape::List(element)) => element.size().zip(known).map(|(size, known)| size * known as u64),
            Some(Shape::Text) => known.map(|known| known as u64 + 1),
            shape => known.map(|known| known as u64).or(shape.as_ref().and_then(Shape::size)),
        };
        length.ok_or_else(|| {
            let message = format!(
                "the RTI is part of an image of {rti}, and cannot know how long values of `{}` are: give it a place of \
                 its own, on a computer",
                input.name
            );
            EmitError::new(self, input.at, message)
        })
    }
}
