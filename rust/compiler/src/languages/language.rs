// SPDX-License-Identifier: Apache-2.0
//! What the compiler asks of a target language.

use core::fmt::Debug;

use crate::diagnostics::{Code, Diagnostic};
use crate::emit::{EmitError, File, Job, SourceMap};
use crate::plan::{Plan, Serializer, Shape};
use crate::syntax::ast::{Expression, Literal, TypeSyntax};

/// A target language: how it reads what is written in it, and what it makes of a plan.
pub(crate) trait Language: Debug + Sync {
    /// Its name in the target declaration.
    fn name(&self) -> &'static str;

    /// Other names that the target declaration can have for it.
    fn aliases(&self) -> &'static [&'static str];

    /// Looks for the end of a code block in the text after its `{=`: what strings and comments hide does not count.
    fn block_end(&self, text: &str) -> BlockEnd;

    /// What is wrong with the syntax of a code block, as far as can be told without the language's own compiler.
    fn code_problem(&self, text: &str, kind: CodeKind) -> Option<CodeProblem>;

    /// Why a name of the program cannot be one of generated code, or of the variables of bodies; `target` is the name
    /// that the target declaration has for the language.
    fn name_problem(&self, name: &str, in_bodies: bool, target: &str) -> Option<&'static str>;

    /// What a name is reported as that the language cannot have.
    fn name_code(&self) -> Code;

    /// What the body of a reaction calls the port of a contained reactor.
    fn port_of_child(&self, child: &str, port: &str) -> String;

    /// How a body names a state variable or a parameter.
    fn member_of_self(&self, name: &str) -> String;

    /// A type in the language's spelling.
    fn type_text(&self, ty: &TypeSyntax) -> String;

    /// What is wrong with a type as it is written; its arguments are looked at by themselves.
    fn type_problem(&self, ty: &TypeSyntax) -> Option<Diagnostic>;

    /// The type of LF's times.
    fn time_type(&self) -> &'static str;

    /// The type of what has no value.
    fn empty_type(&self) -> &'static str;

    /// The type of a literal that is written without one.
    fn type_of_literal(&self, literal: &Literal) -> &'static str;

    /// The literals that a type takes; `None` for a type of which nothing is known.
    fn literals_of(&self, ty: &str) -> Option<LiteralKind>;

    /// The serializers that a program can name.
    fn serializers(&self) -> &'static [&'static str];

    /// All reasons why values of a type cannot go to another federate, as far as the program's text tells; what only
    /// the language's own compiler knows, it says.
    fn unsendable(&self, ty: &str, serializer: Option<&Serializer>, preambles: Preambles<'_>) -> Vec<Unsendable>;

    /// What values of a type are in messages, as far as that is known here: for a federate in another language.
    ///
    /// # Errors
    /// All reasons why no other language can know it.
    fn shape(&self, ty: &str, preambles: Preambles<'_>) -> Result<Shape, Vec<Unsendable>>;

    /// Why a connection cannot copy values of a type, as far as the program's text tells.
    fn uncopyable(&self, ty: &str, preambles: Preambles<'_>) -> Option<Unsendable>;

    /// Whether values can go from a port of one type to a port of the other, as far as that is known here.
    fn is_same_type(&self, one: &str, other: &str) -> bool;

    /// A value as an expression of the language, for a place of this type.
    fn value_text(&self, value: &Expression, ty: &str) -> String;

    /// The value of code that is arithmetic of integers and parameters; nothing for any other code.
    fn integer(&self, code: &str, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64>;

    /// Whether a logical action that is scheduled twice for one tag keeps the last value alone. Otherwise the second
    /// event happens a microstep later.
    fn replaces_events(&self) -> bool;

    /// Whether reactions with a deadline, and what they wait for, run before those of the same tag without.
    fn deadlines_come_first(&self) -> bool;

    /// Whether a value can be a time below zero.
    fn has_negative_times(&self) -> bool;

    /// Whether LF lets a program name types for a reactor that has no type parameters.
    fn allows_superfluous_types(&self) -> bool;

    /// Whether reactions of different reactors can run side by side.
    fn has_workers(&self) -> bool;

    /// Whether a reaction that has a name and no body calls a function of this name, which the program has elsewhere.
    fn has_external_bodies(&self) -> bool;

    /// Adds the files of a participant's program, and what they stem from.
    ///
    /// # Errors
    /// The first thing of which no program can be made.
    fn emit(&self, job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError>;

    /// The file by which the programs for this computer, which are in these folders, are built together.
    fn workspace(&self, plan: &Plan, folders: &[String]) -> File;
}

/// The preambles of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Preambles<'a> {
    /// Those whose declarations a type can name without a path.
    pub(crate) visible: &'a [String],
    /// All of them.
    pub(crate) all: &'a [String],
}

/// Why a type cannot be sent to another federate, and what to write instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Unsendable {
    pub(crate) message: String,
    pub(crate) hint: String,
    /// Where the reason is, unless it is the type itself.
    pub(crate) place: Option<PlaceInPreamble>,
}

/// A place in the declaration of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlaceInPreamble {
    /// The position of the preamble among the visible ones.
    pub(crate) preamble: usize,
    /// The bytes of its text.
    pub(crate) range: core::ops::Range<usize>,
}

/// The end of a code block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockEnd {
    /// The position directly after `=}`.
    Found(usize),
    /// Every `=}` lies within a string or comment; the position directly after the first one, to go on from there.
    Hidden {
        /// Directly after the first one.
        end: usize,
        /// Where the string or comment begins that it lies in.
        by: usize,
    },
    /// There is no `=}` at all.
    Missing,
}

/// What a code block is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CodeKind {
    /// The body of a reaction, of a handler or of a method.
    Statements,
    /// A preamble.
    Items,
    /// A value.
    Expression,
    /// A type.
    Type,
    /// A type parameter with its bounds.
    TypeParameter,
}

/// What is wrong with a code block; places are bytes of its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CodeProblem {
    /// What is reported.
    pub(crate) code: Code,
    /// Where it is.
    pub(crate) range: core::ops::Range<usize>,
    /// One sentence without a full stop.
    pub(crate) message: String,
    /// A further place that explains it.
    pub(crate) also: Option<(core::ops::Range<usize>, String)>,
    /// What to do about it.
    pub(crate) hint: Option<String>,
}

/// What kind of literals a simple type takes.
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
