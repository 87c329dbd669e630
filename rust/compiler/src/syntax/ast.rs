// SPDX-License-Identifier: Apache-2.0
//! The tree of one file: the whole grammar, with places.
#![allow(missing_docs, reason = "fields and variants are called as the grammar calls what they hold")]

use core::ops::Range;

pub use super::expression::{CodeBlock, Expression, ExpressionKind, Initialiser, Literal, Name, TimeValue};
pub use super::type_text::{TypeKind, TypeSyntax};
use crate::diagnostics::Span;
pub use crate::lexical::CodeKind;

/// A file.
#[derive(Clone, Debug, Default)]
pub struct SourceUnit {
    pub target: Option<TargetSyntax>,
    pub imports: Vec<Import>,
    pub preambles: Vec<Preamble>,
    pub reactors: Vec<Reactor>,
    /// All closed code blocks in the file.
    pub codes: Vec<(CodeBlock, CodeKind)>,
    /// All comments, with their marks.
    pub comments: Vec<Range<usize>>,
    /// The places at which declarations and their attributes begin.
    pub beginnings: Vec<usize>,
}

/// `target Rust { … }`
#[derive(Clone, Debug)]
pub struct TargetSyntax {
    pub name: Name,
    pub properties: Vec<Property>,
}

/// `key: value`
#[derive(Clone, Debug)]
pub struct Property {
    pub key: Name,
    pub value: PropertyValue,
}

/// The value of a target property.
#[derive(Clone, Debug)]
pub struct PropertyValue {
    pub kind: PropertyKind,
    pub span: Span,
}

/// The kinds of values of target properties.
#[derive(Clone, Debug)]
pub enum PropertyKind {
    Map(Vec<Property>),
    List(Vec<PropertyValue>),
    Literal(Literal),
    Time(TimeValue),
    /// A word or a path without quotes.
    Path(String),
}

/// `import A as B, C from "file.lf"`
#[derive(Clone, Debug)]
pub struct Import {
    pub reactors: Vec<ImportedReactor>,
    pub source: ImportSource,
    pub span: Span,
}

/// Where an import comes from.
#[derive(Clone, Debug)]
pub enum ImportSource {
    /// A file, relative to the importing one.
    File(Name),
    /// A package in angle brackets.
    Package(Name),
}

/// One reactor of an import.
#[derive(Clone, Debug)]
pub struct ImportedReactor {
    pub name: Name,
    pub alias: Option<Name>,
}

/// `preamble {= … =}`; whether it is private or public makes no difference in Rust.
#[derive(Clone, Debug)]
pub struct Preamble {
    pub code: CodeBlock,
}

/// The kind of a reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReactorKind {
    Plain,
    Main,
    Federated,
}

/// `@name(parameters)`
#[derive(Clone, Debug)]
pub struct Attribute {
    pub name: Name,
    pub parameters: Vec<AttributeParameter>,
    pub span: Span,
}

impl Attribute {
    /// Returns the value of an attribute with exactly one, without a name.
    pub fn single_value(&self) -> Option<&Expression> {
        match &self.parameters[..] {
            [one] if one.name.is_none() => one.value.as_ref(),
            _ => None,
        }
    }
}

/// A parameter of an attribute.
#[derive(Clone, Debug)]
pub struct AttributeParameter {
    pub name: Option<Name>,
    pub value: Option<Expression>,
}

/// A reactor.
#[derive(Clone, Debug)]
pub struct Reactor {
    pub attributes: Vec<Attribute>,
    pub kind: ReactorKind,
    pub realtime: Option<Span>,
    /// The keyword `reactor`.
    pub keyword: Span,
    pub name: Option<Name>,
    pub type_parameters: Vec<TypeParameter>,
    pub parameters: Vec<ParameterSyntax>,
    pub host: Option<Host>,
    pub extends: Vec<Name>,
    pub body: ReactorBody,
    /// The comment directly before it, without comment marks.
    pub docs: Option<String>,
}

impl Reactor {
    /// Returns the place of its name, or of the keyword `reactor` without one.
    pub fn span(&self) -> Span {
        self.name.as_ref().map_or(self.keyword, |name| name.span)
    }
}

/// `T`, `T extends Bound`, or `{= T: Bound =}`; the target language checks the bounds.
#[derive(Clone, Debug)]
pub struct TypeParameter {
    pub name: Name,
}

/// The contents of a reactor's braces, and of those of its modes, in the order of the text.
#[derive(Clone, Debug, Default)]
pub struct ReactorBody {
    pub preambles: Vec<Preamble>,
    pub states: Vec<StateSyntax>,
    pub methods: Vec<MethodSyntax>,
    pub ports: Vec<PortSyntax>,
    pub timers: Vec<Timer>,
    pub actions: Vec<ActionSyntax>,
    pub instances: Vec<Instantiation>,
    pub connections: Vec<ConnectionSyntax>,
    pub reactions: Vec<ReactionSyntax>,
    pub modes: Vec<ModeSyntax>,
}

/// A parameter of a reactor.
#[derive(Clone, Debug)]
pub struct ParameterSyntax {
    pub attributes: Vec<Attribute>,
    pub name: Name,
    pub ty: Option<TypeSyntax>,
    pub init: Option<Initialiser>,
}

/// A state variable.
#[derive(Clone, Debug)]
pub struct StateSyntax {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    pub reset: Option<Span>,
    pub name: Name,
    pub ty: Option<TypeSyntax>,
    pub init: Option<Initialiser>,
}

/// A method.
#[derive(Clone, Debug)]
pub struct MethodSyntax {
    pub name: Name,
    /// Whether it is a `const method`, which does not change the state.
    pub constant: bool,
    pub arguments: Vec<(Name, Option<TypeSyntax>)>,
    /// The type of its result.
    pub ty: Option<TypeSyntax>,
    pub code: CodeBlock,
}

/// `[ … ]`: the number of a port's channels, or of a bank's members; the sum of the terms.
#[derive(Clone, Debug)]
pub struct Width {
    /// The terms; `None` for `[]`, which leaves the width open.
    pub terms: Vec<WidthTerm>,
    pub span: Span,
}

/// A part of a width.
#[derive(Clone, Debug)]
pub enum WidthTerm {
    /// A number, a parameter, or code.
    Value(Expression),
    /// `widthof(port)`
    WidthOf(Reference),
}

/// The direction of a port, seen from its own reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    Input,
    Output,
}

/// An input or output.
#[derive(Clone, Debug)]
pub struct PortSyntax {
    pub attributes: Vec<Attribute>,
    pub direction: Direction,
    /// Whether it is a `mutable input`.
    pub mutable: bool,
    pub width: Option<Width>,
    pub name: Name,
    pub ty: Option<TypeSyntax>,
}

/// A timer.
#[derive(Clone, Debug)]
pub struct Timer {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    pub name: Name,
    pub offset: Option<Expression>,
    pub period: Option<Expression>,
}

/// The source of an action's events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionKind {
    /// `logical action`
    Logical,
    /// `physical action`
    Physical,
    /// `watchdog`: its minimum delay is the timeout, and its handler is one of the reactions.
    Watchdog,
}

impl ActionKind {
    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        if self == Self::Watchdog { "watchdog" } else { "action" }
    }
}

/// An action.
#[derive(Clone, Debug)]
pub struct ActionSyntax {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    pub kind: ActionKind,
    pub name: Name,
    pub min_delay: Option<Expression>,
    pub min_spacing: Option<Expression>,
    pub policy: Option<Name>,
    pub ty: Option<TypeSyntax>,
}

/// A contained reactor.
#[derive(Clone, Debug)]
pub struct Instantiation {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    pub name: Name,
    pub width: Option<Width>,
    pub class: Name,
    pub type_arguments: Vec<TypeSyntax>,
    pub arguments: Vec<Assignment>,
    pub host: Option<Host>,
}

/// `parameter = value`
#[derive(Clone, Debug)]
pub struct Assignment {
    pub name: Name,
    pub init: Initialiser,
}

/// `at user@address:port`
#[derive(Clone, Debug)]
pub struct Host {
    pub user: Option<String>,
    pub address: String,
    pub port: Option<u16>,
    pub span: Span,
}

/// A connection.
#[derive(Clone, Debug)]
pub struct ConnectionSyntax {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    pub left: Vec<Reference>,
    /// `( … )+`: the left side is repeated as often as the right side needs.
    pub iterated: bool,
    /// The `~>` of a physical connection.
    pub physical: Option<Span>,
    pub right: Vec<Reference>,
    pub after: Option<Expression>,
    /// The name behind `serializer`; its place begins with that word.
    pub serializer: Option<Name>,
    pub span: Span,
}

/// A name of an element in the reactor, or in one of its contained reactors.
#[derive(Clone, Debug)]
pub struct Reference {
    pub container: Option<Name>,
    pub name: Name,
    pub interleaved: bool,
    pub alias: Option<Name>,
    /// The kind of transition to a mode, if it is written.
    pub transition: Option<Transition>,
    pub span: Span,
}

impl From<Name> for Reference {
    fn from(name: Name) -> Self {
        let span = name.span;
        Self { container: None, name, interleaved: false, alias: None, transition: None, span }
    }
}

impl Reference {
    /// Returns the text as it is written: `child.port`, `port` or `reset(mode)`.
    pub fn text(&self) -> String {
        match (&self.container, self.transition) {
            (Some(container), _) => format!("{}.{}", container.text, self.name.text),
            (None, Some(Transition::Reset)) => format!("reset({})", self.name.text),
            (None, Some(Transition::History)) => format!("history({})", self.name.text),
            (None, None) => self.name.text.clone(),
        }
    }
}

/// The keyword at the beginning of a reaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReactionKeyword {
    Reaction,
    Mutation,
    /// The keyword of a watchdog's handler, which has the watchdog's name.
    Watchdog,
}

/// A reaction.
#[derive(Clone, Debug)]
pub struct ReactionSyntax {
    /// The mode that contains it.
    pub mode: Option<usize>,
    pub attributes: Vec<Attribute>,
    /// The keyword `reaction`, `mutation` or `watchdog`.
    pub keyword: Span,
    pub kind: ReactionKeyword,
    pub name: Option<Name>,
    pub triggers: Vec<Reference>,
    pub uses: Vec<Reference>,
    pub effects: Vec<Reference>,
    pub code: Option<CodeBlock>,
    pub tardy: Option<TardySyntax>,
    pub deadline: Option<DeadlineSyntax>,
}

/// `tardy {= … =}`, `tardy`, or the older `STP(value) {= … =}` and `STAA(value) {= … =}`
#[derive(Clone, Debug)]
pub struct TardySyntax {
    /// `tardy`, `STP` or `STAA`.
    pub word: Name,
    /// The value of the older forms.
    pub absent_after: Option<Expression>,
    /// The code; without it, the body runs.
    pub code: Option<CodeBlock>,
}

/// `deadline(value) {= … =}`
#[derive(Clone, Debug)]
pub struct DeadlineSyntax {
    pub value: Expression,
    pub code: CodeBlock,
}

/// A mode. Its contents are in the body of its reactor, each with its mode.
#[derive(Clone, Debug)]
pub struct ModeSyntax {
    /// A mode without a name cannot be entered.
    pub name: Option<Name>,
    pub initial: bool,
    pub span: Span,
}

/// `reset(mode)` or `history(mode)`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transition {
    Reset,
    History,
}
