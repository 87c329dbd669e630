// SPDX-License-Identifier: Apache-2.0
//! The messages of the compiler about a program: errors and warnings with their places, and their rendering.
//!
//! This module does not decide whether a program is right; the other modules make [`Diagnostic`]s and collect them in
//! [`Diagnostics`], which also owns the texts, so that it can render itself.

mod code;
mod render;
mod source;
mod suggest;

pub use code::{Code, Severity};
pub use render::Style;
pub use source::{FileId, Position, SourceText, SourceTexts, Span};
pub(crate) use suggest::did_you_mean;

use indexmap::{IndexMap, IndexSet};

/// A further place that explains the first one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// The text at that place, without a full stop.
    pub text: String,
}

/// An error, or a warning that the author of a program should know.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Diagnostic {
    /// The stable name of this kind of diagnostic.
    pub code: Code,
    /// The place.
    pub span: Span,
    /// The problem, as one sentence without a full stop.
    pub message: String,
    /// The text beside the underlined code; may be empty.
    pub label: String,
    /// Further places.
    pub secondary: Vec<Label>,
    /// The advice.
    pub hint: Option<String>,
}

impl Diagnostic {
    /// Returns a diagnostic with its place and its sentence.
    pub fn new(code: Code, span: Span, message: impl Into<String>) -> Self {
        Self { code, span, message: message.into(), label: String::new(), secondary: Vec::new(), hint: None }
    }

    /// Sets the text beside the underlined code.
    #[must_use]
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.label = text.into();
        self
    }

    /// Adds a further place.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Self {
        self.secondary.push(Label { span, text: text.into() });
        self
    }

    /// Sets the advice.
    #[must_use]
    pub fn hint(mut self, text: impl Into<String>) -> Self {
        self.hint = Some(text.into());
        self
    }

    /// Sets the advice, if there is some.
    #[must_use]
    pub fn hint_maybe(mut self, text: Option<String>) -> Self {
        if text.is_some() {
            self.hint = text;
        }
        self
    }

    /// Returns the text that its advice puts in the place of its span, if it is such advice.
    pub fn replacement(&self) -> Option<&str> {
        let hint = self.hint.as_deref()?;
        match self.code {
            Code::MissingUnit => hint.strip_prefix("write `")?.split('`').next(),
            _ => suggest::suggested(hint),
        }
    }

    /// Returns whether it prevents a plan.
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }
}

/// All diagnostics of a program, in the order of the text, with the texts.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    sources: SourceTexts,
    entries: IndexSet<Diagnostic>,
    errors: usize,
    /// The first one of each kind about the channels of a connection, and the number of further ones.
    of_channels: IndexMap<(Code, Span), (Diagnostic, usize)>,
}

impl Diagnostics {
    /// Adds one; keeps one of two equal ones.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let is_error = diagnostic.severity() == Severity::Error;
        if self.entries.insert(diagnostic) && is_error {
            self.errors += 1;
        }
    }

    /// Adds several.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        for diagnostic in diagnostics {
            self.push(diagnostic);
        }
    }

    /// Adds one about a channel of a connection. A connection can have tens of thousands of channels, so only the first
    /// one is kept, with the number of the others.
    pub(crate) fn push_for_channel(&mut self, diagnostic: Diagnostic) {
        let others = &mut self.of_channels.entry((diagnostic.code, diagnostic.span)).or_insert((diagnostic, 0)).1;
        *others += 1;
    }

    /// Returns whether there is at least one error.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// Returns all entries, sorted by file and place once the compilation has ended.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.entries.iter()
    }

    /// Returns the numbers of errors and of warnings.
    pub fn counts(&self) -> (usize, usize) {
        (self.errors, self.entries.len() - self.errors)
    }

    /// Returns whether there are no diagnostics.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the texts of the program.
    pub fn sources(&self) -> &SourceTexts {
        &self.sources
    }

    pub(crate) fn sources_mut(&mut self) -> &mut SourceTexts {
        &mut self.sources
    }

    /// Drops all diagnostics of files of another target, except for that error, and those of their contents; returns
    /// whether there are such files. Everything else that looks wrong in them may be right in their own language.
    pub(crate) fn keep_wrong_targets(&mut self) -> bool {
        let is_known = |entry: &Diagnostic| entry.code == Code::WrongTarget && entry.span.end > entry.span.start;
        let is_wrong = self.entries.iter().any(is_known);
        if is_wrong {
            self.entries.retain(is_known);
            self.errors = self.entries.len();
        }
        is_wrong
    }

    /// Sorts by file and place; entries of one place stay in the order in which they were found.
    pub(crate) fn sort(&mut self) {
        for (_, (mut diagnostic, count)) in std::mem::take(&mut self.of_channels) {
            diagnostic.message = match count - 1 {
                0 => diagnostic.message,
                1 => diagnostic.message + ", and so it is with another channel",
                others => format!("{}, and so it is with {others} other channels", diagnostic.message),
            };
            self.push(diagnostic);
        }
        self.entries.sort_by_key(|entry| (entry.span.file, entry.span.start));
    }
}
