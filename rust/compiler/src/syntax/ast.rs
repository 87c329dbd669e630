// SPDX-License-Identifier: Apache-2.0
//! The tree of one file: the whole grammar, as it is written, with places.

pub(crate) use super::expression::{CodeBlock, Expression, ExpressionKind, Initialiser, Literal, Name, TimeValue};
pub(crate) use super::type_text::{TypeKind, TypeSyntax};
use crate::diagnostics::Span;
use crate::lexical::CodeKind;

/// A file.
#[derive(Clone, Debug, Default)]
pub(crate) struct SourceUnit {
    pub(crate) target: Option<TargetSyntax>,
    pub(crate) imports: Vec<Import>,
    pub(crate) preambles: Vec<Preamble>,
    pub(crate) reactors: Vec<Reactor>,
    /// All code blocks that are closed, wherever they stand.
    pub(crate) codes: Vec<(CodeBlock, CodeKind)>,
}

/// `target Rust { … }`
#[derive(Clone, Debug)]
pub(crate) struct TargetSyntax {
    pub(crate) name: Name,
    pub(crate) properties: Vec<Property>,
}

/// `key: value`
#[derive(Clone, Debug)]
pub(crate) struct Property {
    pub(crate) key: Name,
    pub(crate) value: PropertyValue,
}

/// The value of a target property.
#[derive(Clone, Debug)]
pub(crate) struct PropertyValue {
    pub(crate) kind: PropertyKind,
    pub(crate) span: Span,
}

/// The kinds of values of target properties.
#[derive(Clone, Debug)]
pub(crate) enum PropertyKind {
    Map(Vec<Property>),
    List(Vec<PropertyValue>),
    Literal(Literal),
    Time(TimeValue),
    /// A word or a path without quotes.
    Path(String),
}

/// `import A as B, C from "file.lf"`
#[derive(Clone, Debug)]
pub(crate) struct Import {
    pub(crate) reactors: Vec<ImportedReactor>,
    pub(crate) source: ImportSource,
    pub(crate) span: Span,
}

/// Where an import comes from.
#[derive(Clone, Debug)]
pub(crate) enum ImportSource {
    /// A file, relative to the importing one.
    File(Name),
    /// A package in angle brackets.
    Package(Name),
}

/// One reactor of an import.
#[derive(Clone, Debug)]
pub(crate) struct ImportedReactor {
    pub(crate) name: Name,
    pub(crate) alias: Option<Name>,
}

/// `preamble {= … =}`; whether it is private or public makes no difference in Rust.
#[derive(Clone, Debug)]
pub(crate) struct Preamble {
    pub(crate) code: CodeBlock,
}

/// What kind of reactor it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReactorKind {
    Plain,
    Main,
    Federated,
}

/// `@name(parameters)`
#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) name: Name,
    pub(crate) parameters: Vec<AttributeParameter>,
    pub(crate) span: Span,
}

/// A parameter of an attribute.
#[derive(Clone, Debug)]
pub(crate) struct AttributeParameter {
    pub(crate) name: Option<Name>,
    pub(crate) value: Option<Expression>,
}

/// A reactor.
#[derive(Clone, Debug)]
pub(crate) struct Reactor {
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) kind: ReactorKind,
    pub(crate) realtime: Option<Span>,
    /// The word `reactor`.
    pub(crate) keyword: Span,
    pub(crate) name: Option<Name>,
    pub(crate) type_parameters: Vec<TypeParameter>,
    pub(crate) parameters: Vec<ParameterSyntax>,
    pub(crate) host: Option<Host>,
    pub(crate) extends: Vec<Name>,
    pub(crate) body: ReactorBody,
    /// The comment directly before it, without comment marks.
    pub(crate) docs: Option<String>,
}

impl Reactor {
    /// Its name, or the word `reactor` where it has none.
    pub(crate) fn span(&self) -> Span {
        self.name.as_ref().map_or(self.keyword, |name| name.span)
    }
}

/// `T`, `T extends Bound`, or `{= T: Bound =}`; what a type has to be able to do, the target language checks.
#[derive(Clone, Debug)]
pub(crate) struct TypeParameter {
    pub(crate) name: Name,
}

/// What stands in the braces of a reactor, and in those of its modes, in the order of the text.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReactorBody {
    pub(crate) preambles: Vec<Preamble>,
    pub(crate) states: Vec<StateSyntax>,
    pub(crate) methods: Vec<MethodSyntax>,
    pub(crate) ports: Vec<PortSyntax>,
    pub(crate) timers: Vec<Timer>,
    pub(crate) actions: Vec<ActionSyntax>,
    pub(crate) instances: Vec<Instantiation>,
    pub(crate) connections: Vec<ConnectionSyntax>,
    pub(crate) reactions: Vec<ReactionSyntax>,
    pub(crate) modes: Vec<ModeSyntax>,
}

/// A parameter of a reactor.
#[derive(Clone, Debug)]
pub(crate) struct ParameterSyntax {
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) name: Name,
    pub(crate) ty: Option<TypeSyntax>,
    pub(crate) init: Option<Initialiser>,
}

/// A state variable.
#[derive(Clone, Debug)]
pub(crate) struct StateSyntax {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) reset: Option<Span>,
    pub(crate) name: Name,
    pub(crate) ty: Option<TypeSyntax>,
    pub(crate) init: Option<Initialiser>,
}

/// A method.
#[derive(Clone, Debug)]
pub(crate) struct MethodSyntax {
    pub(crate) name: Name,
    /// Whether it is a `const method`, which does not change the state.
    pub(crate) constant: bool,
    pub(crate) arguments: Vec<(Name, Option<TypeSyntax>)>,
    /// What it returns.
    pub(crate) ty: Option<TypeSyntax>,
    pub(crate) code: CodeBlock,
}

/// `[ … ]`: how many channels a port has, or how many instances a bank; the sum of the terms.
#[derive(Clone, Debug)]
pub(crate) struct Width {
    /// None for `[]`, which leaves it open.
    pub(crate) terms: Vec<WidthTerm>,
    pub(crate) span: Span,
}

/// A part of a width.
#[derive(Clone, Debug)]
pub(crate) enum WidthTerm {
    /// A number, a parameter, or code.
    Value(Expression),
    /// `widthof(port)`
    WidthOf(Reference),
}

/// The direction of a port, seen from its own reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Input,
    Output,
}

/// An input or output.
#[derive(Clone, Debug)]
pub(crate) struct PortSyntax {
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) direction: Direction,
    /// Whether it is a `mutable input`.
    pub(crate) mutable: bool,
    pub(crate) width: Option<Width>,
    pub(crate) name: Name,
    pub(crate) ty: Option<TypeSyntax>,
}

/// A timer.
#[derive(Clone, Debug)]
pub(crate) struct Timer {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) name: Name,
    pub(crate) offset: Option<Expression>,
    pub(crate) period: Option<Expression>,
}

/// What schedules the events of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ActionKind {
    /// `logical action`
    Logical,
    /// `physical action`
    Physical,
    /// `watchdog`: its minimum delay is the timeout, and its handler is one of the reactions.
    Watchdog,
}

impl ActionKind {
    /// For people.
    pub(crate) fn name(self) -> &'static str {
        if self == Self::Watchdog { "watchdog" } else { "action" }
    }
}

/// An action.
#[derive(Clone, Debug)]
pub(crate) struct ActionSyntax {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) kind: ActionKind,
    pub(crate) name: Name,
    pub(crate) min_delay: Option<Expression>,
    pub(crate) min_spacing: Option<Expression>,
    pub(crate) policy: Option<Name>,
    pub(crate) ty: Option<TypeSyntax>,
}

/// A contained reactor.
#[derive(Clone, Debug)]
pub(crate) struct Instantiation {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) name: Name,
    pub(crate) width: Option<Width>,
    pub(crate) class: Name,
    pub(crate) type_arguments: Vec<TypeSyntax>,
    pub(crate) arguments: Vec<Assignment>,
    pub(crate) host: Option<Host>,
}

/// `parameter = value`
#[derive(Clone, Debug)]
pub(crate) struct Assignment {
    pub(crate) name: Name,
    pub(crate) init: Initialiser,
}

/// `at user@address:port`
#[derive(Clone, Debug)]
pub(crate) struct Host {
    pub(crate) user: Option<String>,
    pub(crate) address: String,
    pub(crate) port: Option<u16>,
    pub(crate) span: Span,
}

/// A connection.
#[derive(Clone, Debug)]
pub(crate) struct ConnectionSyntax {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) left: Vec<Reference>,
    /// `( … )+`: the left side is repeated as often as the right side needs.
    pub(crate) iterated: bool,
    /// The `~>` of a physical connection.
    pub(crate) physical: Option<Span>,
    pub(crate) right: Vec<Reference>,
    pub(crate) after: Option<Expression>,
    /// The name behind `serializer`; its place begins with that word.
    pub(crate) serializer: Option<Name>,
    pub(crate) span: Span,
}

/// A name of something in the reactor, or in one of its contained reactors.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    pub(crate) container: Option<Name>,
    pub(crate) name: Name,
    pub(crate) interleaved: bool,
    pub(crate) alias: Option<Name>,
    /// How a mode is to be entered, where it is said.
    pub(crate) transition: Option<Transition>,
    pub(crate) span: Span,
}

impl From<Name> for Reference {
    fn from(name: Name) -> Self {
        let span = name.span;
        Self { container: None, name, interleaved: false, alias: None, transition: None, span }
    }
}

impl Reference {
    /// As it is written: `child.port`, `port` or `reset(mode)`.
    pub(crate) fn text(&self) -> String {
        match (&self.container, self.transition) {
            (Some(container), _) => format!("{}.{}", container.text, self.name.text),
            (None, Some(Transition::Reset)) => format!("reset({})", self.name.text),
            (None, Some(Transition::History)) => format!("history({})", self.name.text),
            (None, None) => self.name.text.clone(),
        }
    }
}

/// With which word a reaction begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReactionKeyword {
    Reaction,
    Mutation,
    /// It is the handler of a watchdog, whose name it has.
    Watchdog,
}

/// A reaction.
#[derive(Clone, Debug)]
pub(crate) struct ReactionSyntax {
    /// The mode that it is in.
    pub(crate) mode: Option<usize>,
    pub(crate) attributes: Vec<Attribute>,
    /// The word `reaction`, `mutation` or `watchdog`.
    pub(crate) keyword: Span,
    pub(crate) kind: ReactionKeyword,
    pub(crate) name: Option<Name>,
    pub(crate) triggers: Vec<Reference>,
    pub(crate) uses: Vec<Reference>,
    pub(crate) effects: Vec<Reference>,
    pub(crate) code: Option<CodeBlock>,
    pub(crate) tardy: Option<TardySyntax>,
    pub(crate) deadline: Option<DeadlineSyntax>,
}

/// `tardy {= … =}`, `tardy`, or the older `STP(value) {= … =}` and `STAA(value) {= … =}`
#[derive(Clone, Debug)]
pub(crate) struct TardySyntax {
    /// `tardy`, `STP` or `STAA`.
    pub(crate) word: Name,
    /// The value of the older forms.
    pub(crate) absent_after: Option<Expression>,
    /// What runs; without it, the body does.
    pub(crate) code: Option<CodeBlock>,
}

/// `deadline(value) {= … =}`
#[derive(Clone, Debug)]
pub(crate) struct DeadlineSyntax {
    pub(crate) value: Expression,
    pub(crate) code: CodeBlock,
}

/// A mode. What is in it stands in the body of its reactor, and says in which mode it is.
#[derive(Clone, Debug)]
pub(crate) struct ModeSyntax {
    /// A mode without a name cannot be entered.
    pub(crate) name: Option<Name>,
    pub(crate) initial: bool,
    pub(crate) span: Span,
}

/// `reset(mode)` or `history(mode)`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Transition {
    Reset,
    History,
}
