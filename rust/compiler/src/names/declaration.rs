// SPDX-License-Identifier: Apache-2.0
//! The meanings of names.

use crate::diagnostics::Span;

/// The meaning of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declaration {
    /// The name in its declaration.
    pub span: Span,
    /// The kind of the declared element.
    pub kind: NameKind,
    /// The type in the spelling of the target language, or `time`; of an instance its class.
    pub ty: Option<String>,
    /// The comment directly before the declaration, without comment marks.
    pub docs: Option<String>,
}

/// The kind of a named element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameKind {
    /// A reactor.
    Reactor,
    /// A type parameter of a reactor.
    TypeParameter,
    /// A parameter of a reactor.
    Parameter,
    /// A state variable.
    State,
    /// An input.
    Input,
    /// An output.
    Output,
    /// A timer.
    Timer,
    /// A logical action.
    LogicalAction,
    /// A physical action.
    PhysicalAction,
    /// A watchdog.
    Watchdog,
    /// A contained reactor, or a bank of them.
    Instance,
    /// A mode.
    Mode,
    /// A method.
    Method,
    /// A reaction.
    Reaction,
}
