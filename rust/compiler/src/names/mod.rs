// SPDX-License-Identifier: Apache-2.0
//! The meaning of each name in a program: for editors, which ask while the program is incomplete and therefore
//! incorrect.
//!
//! This module reports no errors, and instantiates nothing. A name without a meaning has no entry.

mod bodies;
mod collector;
mod declaration;

use std::collections::BTreeMap;

use crate::diagnostics::{Diagnostics, FileId, SourceTexts, Span};
use crate::resolve::{self, SourceProvider};
use crate::stack::with_stack;
use crate::syntax::ast::SourceUnit;
use collector::Collector;
pub use declaration::{Declaration, NameKind};

/// The meanings of the names in a program.
#[derive(Clone, Debug, Default)]
pub struct ResolvedNames {
    texts: SourceTexts,
    /// The trees of the texts.
    trees: Vec<SourceUnit>,
    declarations: Vec<Declaration>,
    /// The places that name declarations, including those of the declarations.
    places: BTreeMap<Span, usize>,
}

impl ResolvedNames {
    /// Returns the declaration behind the name at a byte of a text, and the whole name. The byte behind a name belongs
    /// to it.
    pub fn at(&self, file: FileId, byte: usize) -> Option<(Span, &Declaration)> {
        let until = Span::new(file, byte, usize::MAX);
        let (span, declaration) = self.places.range(..=until).next_back()?;
        let is_inside = span.file == file && byte <= span.end;
        is_inside.then(|| (*span, &self.declarations[*declaration]))
    }

    /// Returns all names with a meaning, by file and place.
    pub fn iter(&self) -> impl Iterator<Item = (Span, &Declaration)> {
        self.places.iter().map(|(span, declaration)| (*span, &self.declarations[*declaration]))
    }

    /// Returns the places that name the element declared at a place, including that place.
    pub fn places_of(&self, declared: Span) -> impl Iterator<Item = Span> {
        self.iter().filter(move |(_, declaration)| declaration.span == declared).map(|(span, _)| span)
    }

    /// Returns the tree of a text. The syntax of its code blocks is not checked.
    pub fn tree(&self, file: FileId) -> Option<&SourceUnit> {
        self.trees.get(file.index())
    }

    /// Returns the texts that the places are in.
    pub fn sources(&self) -> &SourceTexts {
        &self.texts
    }
}

/// Returns the meanings of the names in the program whose main file is `main_path`, and in all files that it imports.
///
/// The program may have errors of any kind. Unreadable parts are left out.
pub fn names(main_path: &str, sources: &dyn SourceProvider) -> ResolvedNames {
    let mut diagnostics = Diagnostics::default();
    let collected = with_stack(|| {
        let program = resolve::load(main_path, sources, &mut diagnostics)?;
        let (declarations, places) = Collector::new(&program, diagnostics.sources()).collected();
        let trees = program.units.into_iter().map(|unit| unit.ast).collect();
        Some((trees, declarations, places))
    });
    let (trees, declarations, places) = collected.unwrap_or_default();
    ResolvedNames { texts: diagnostics.sources().clone(), trees, declarations, places }
}
