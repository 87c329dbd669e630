// SPDX-License-Identifier: Apache-2.0
//! The origins of a plan's parts: source files, positions in them, and pieces of code taken from them verbatim.

use serde::{Deserialize, Serialize};

use crate::lexical::Language;

/// Declares an index into one of the plan's lists.
macro_rules! index {
    ($(#[$doc:meta] $name:ident;)*) => {$(
        #[$doc]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub usize);

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

index! {
    /// Position in [`Plan::files`](super::Plan::files).
    FileIndex;
    /// Position in [`Plan::classes`](super::Plan::classes).
    ClassIndex;
    /// Position in [`Federate::instances`](super::Federate::instances).
    InstanceIndex;
    /// Position in [`Federate::ports`](super::Federate::ports).
    PortIndex;
    /// Position in [`Federate::triggers`](super::Federate::triggers).
    TriggerIndex;
    /// Position in [`Federate::reactions`](super::Federate::reactions): the order of execution.
    ReactionIndex;
    /// Position in [`Federate::modes`](super::Federate::modes).
    ModeIndex;
    /// Position in [`Federate::outputs`](super::Federate::outputs).
    OutputIndex;
    /// Position in [`Federate::inputs`](super::Federate::inputs): the port number on the wire.
    InputIndex;
}

/// A source file that takes part in the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// The path as the user gave it, or as the import resolved to.
    pub path: String,
    /// The language of its bodies, if it differs from that of the main file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub language: Option<Language>,
    /// The files whose reactors it has imported.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub imports: Vec<FileIndex>,
    /// The file's top-level preambles, in order.
    pub preambles: Vec<SourceCode>,
}

/// A place in a source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Location {
    /// The file.
    pub file: FileIndex,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
}

/// Code taken verbatim from the source, without its `{=` and `=}`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceCode {
    /// The text, with the line structure of the source.
    pub text: String,
    /// The place of the first character of `text`, directly after `{=`.
    pub at: Location,
}

/// A type of the target language, as text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Type {
    /// The language's spelling; LF's `time` and a missing type are replaced by the language's types.
    pub text: String,
    /// The place of the type, or of the declaration without one.
    pub at: Location,
}

/// The value of a parameter or the initial value of a state variable.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Value {
    /// A duration in nanoseconds, written in LF as `100 msec` or `0`.
    Time {
        /// Nanoseconds.
        ns: i64,
    },
    /// An expression of the target language: a literal, the name of a parameter that is in scope, or code.
    Code(SourceCode),
}
