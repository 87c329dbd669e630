// SPDX-License-Identifier: Apache-2.0
//! What each name of a program means: for editors, which ask while a program is being written and so is wrong.
//!
//! Nothing here is refused or reported, and nothing is instantiated. A name that means nothing has no entry.

mod collector;
mod declaration;

use std::collections::BTreeMap;

use crate::diagnostics::{Diagnostics, FileId, SourceTexts, Span};
use crate::resolve::{self, SourceProvider};
use crate::stack::with_stack;
use collector::Collector;
pub use declaration::{Declaration, NameKind};

/// What the names of a program mean.
#[derive(Clone, Debug, Default)]
pub struct ResolvedNames {
    texts: SourceTexts,
    declarations: Vec<Declaration>,
    /// Where declarations are named, their own places included.
    places: BTreeMap<Span, usize>,
}

impl ResolvedNames {
    /// Returns what the name at a byte of a text means, and the whole name. The byte behind a name belongs to it.
    pub fn at(&self, file: FileId, byte: usize) -> Option<(Span, &Declaration)> {
        let until = Span::new(file, byte, usize::MAX);
        let (span, declaration) = self.places.range(..=until).next_back()?;
        let is_inside = span.file == file && byte <= span.end;
        is_inside.then(|| (*span, &self.declarations[*declaration]))
    }

    /// Returns all names that mean something, by file and place.
    pub fn iter(&self) -> impl Iterator<Item = (Span, &Declaration)> {
        self.places.iter().map(|(span, declaration)| (*span, &self.declarations[*declaration]))
    }

    /// Returns the places that name what is declared at a place, which is one of them.
    pub fn places_of(&self, declared: Span) -> impl Iterator<Item = Span> {
        self.iter().filter(move |(_, declaration)| declaration.span == declared).map(|(span, _)| span)
    }

    /// Returns the texts that the places are in.
    pub fn sources(&self) -> &SourceTexts {
        &self.texts
    }
}

/// Finds out what the names of the program mean whose main file is `main_path`, and those of all files that it imports.
///
/// The program may have errors of any kind. What cannot be read is left out.
pub fn names(main_path: &str, sources: &dyn SourceProvider) -> ResolvedNames {
    let mut diagnostics = Diagnostics::default();
    let collected = with_stack(|| {
        let program = resolve::load(main_path, sources, &mut diagnostics)?;
        Some(Collector::new(&program, diagnostics.sources()).collected())
    });
    let (declarations, places) = collected.unwrap_or_default();
    ResolvedNames { texts: diagnostics.sources().clone(), declarations, places }
}
