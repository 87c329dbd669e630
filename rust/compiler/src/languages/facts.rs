// SPDX-License-Identifier: Apache-2.0
//! The properties of a target language that the compiler needs to check and plan a program.

use core::ops::Range;

use crate::diagnostics::{Code, Diagnostic};
use crate::plan::{Serializer, Shape};
use crate::syntax::ast::{Expression, Literal, TypeSyntax};

/// The facts about a target language. Each language has one table, and users of the table need not know the language.
#[allow(clippy::struct_excessive_bools, reason = "these are facts, each of its own")]
pub(crate) struct Facts {
    /// The diagnostic for a name that is invalid in the language.
    pub(crate) name_code: Code,
    /// The separator that bodies write between a contained reactor and its port.
    pub(crate) between_child_and_port: &'static str,
    /// The prefix that bodies write before a state variable or a parameter.
    pub(crate) before_member: &'static str,
    /// The type of LF's times.
    pub(crate) time_type: &'static str,
    /// The type without values.
    pub(crate) empty_type: &'static str,
    /// The serializers that a program can name.
    pub(crate) serializers: &'static [&'static str],
    /// Whether a logical action that is scheduled twice for one tag keeps only the last value. Otherwise the second
    /// event happens a microstep later.
    pub(crate) replaces_events: bool,
    /// Whether reactions with a deadline, and those that they wait for, precede those of the same tag without.
    pub(crate) deadlines_come_first: bool,
    /// Whether a value can be a negative time.
    pub(crate) negative_times: bool,
    /// Whether LF lets a program name types for a reactor that has no type parameters.
    pub(crate) superfluous_types: bool,
    /// Whether a reaction with a name and without a body calls a function of this name elsewhere in the program.
    pub(crate) external_bodies: bool,
    /// Whether any thread may schedule a physical action at any time, so that a program with one stays although it has
    /// no more events. Otherwise the runtime knows all threads that can schedule.
    pub(crate) unknown_threads: bool,
    /// Whether a C compiler compiles the bodies, so that all settings of the program for that compiler apply to them.
    pub(crate) native_bodies: bool,
    /// Whether a preprocessor can replace names of the program.
    pub(crate) preprocessor: bool,
    /// Returns a type in the language's spelling.
    pub(crate) type_text: fn(&TypeSyntax) -> String,
    /// Returns the problem of a type as it is written; its arguments are checked separately.
    pub(crate) type_problem: fn(&TypeSyntax) -> Option<Diagnostic>,
    /// Returns the type of a literal without a declared type.
    pub(crate) type_of_literal: fn(&Literal) -> &'static str,
    /// Returns the literals that a type accepts; `None` for an unknown type.
    pub(crate) literals_of: fn(&str) -> Option<LiteralKind>,
    /// Returns whether values can go from a port of one type to a port of the other, as far as the compiler knows.
    pub(crate) is_same_type: fn(&str, &str) -> bool,
    /// Returns a value as an expression of the language, for a place of this type.
    pub(crate) value_text: fn(&Expression, &str) -> String,
    /// Returns the value of arithmetic code with integers and parameters; `None` for any other code.
    pub(crate) integer: IntegerOf,
    /// Returns all reasons why values of a type cannot go to another federate, as far as the program's text shows. The
    /// language's own compiler reports the others.
    pub(crate) unsendable: fn(&str, Option<&Serializer>, Preambles<'_>) -> Vec<Unsendable>,
    /// Returns all reasons why a state of a type cannot be handed over to another instance of its federate, as far as
    /// the program's text shows.
    pub(crate) not_handed_over: fn(&str, Option<&Serializer>, Preambles<'_>) -> Vec<Unsendable>,
    /// Returns the layout of a type's values in messages, for a federate in another language; or all reasons why no
    /// other language can know it.
    pub(crate) shape: fn(&str, Preambles<'_>) -> Result<Shape, Vec<Unsendable>>,
    /// Returns the reason why a connection cannot copy values of a type, as far as the program's text shows.
    pub(crate) uncopyable: fn(&str, Preambles<'_>) -> Option<Unsendable>,
}

/// Evaluates code with the values of the parameters that it names.
pub(crate) type IntegerOf = fn(&str, &dyn Fn(&str) -> Option<i64>) -> Option<i64>;

/// The preambles of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Preambles<'a> {
    /// Those whose declarations a type can name without a path.
    pub(crate) visible: &'a [String],
    /// All of them.
    pub(crate) all: &'a [String],
}

/// The reason why a type cannot be sent to another federate, and its replacement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Unsendable {
    pub(crate) message: String,
    pub(crate) hint: String,
    /// The place of the reason, unless it is the type itself.
    pub(crate) place: Option<PlaceInPreamble>,
}

/// A place in the declaration of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlaceInPreamble {
    /// The position of the preamble among the visible ones.
    pub(crate) preamble: usize,
    /// The bytes of its text.
    pub(crate) range: Range<usize>,
}

/// The kind of literals that a simple type accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LiteralKind {
    /// Any number, character or boolean, which the language converts.
    Number,
    Signed,
    Unsigned,
    Float,
    Bool,
    Char,
    Text,
}
