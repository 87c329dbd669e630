// SPDX-License-Identifier: Apache-2.0
//! A map from places in generated files to places in the LF program.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The origins of the pieces of generated files. Lines and columns count from 1, columns in characters.
///
/// It can be stored beside a crate that another tool compiles; a later version need not be able to read it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceMap {
    lf_paths: Vec<String>,
    files: BTreeMap<String, FileMap>,
}

/// The map of one generated file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FileMap {
    /// Verbatim pieces, at most one per line where they span lines; sorted by place.
    pub(crate) pieces: Vec<Piece>,
    /// Lines of scaffolding from which on all code belongs to one declaration; sorted by line.
    pub(crate) anchors: Vec<Anchor>,
}

/// A piece of one generated line that is a verbatim part of the LF program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Piece {
    pub(crate) line: usize,
    pub(crate) column: usize,
    /// The length in characters; the position directly after the last one still belongs to the piece.
    pub(crate) len: usize,
    pub(crate) to: Origin,
}

/// A generated line that belongs to a declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Anchor {
    pub(crate) line: usize,
    /// `None` ends the anchor before it.
    pub(crate) to: Option<Origin>,
}

/// A part of a line of a generated file that is text of the program. Lines and columns count from 1, columns and the
/// length in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerbatimPart<'m> {
    /// The generated file.
    pub generated: &'m str,
    /// Its line.
    pub line: usize,
    /// The column of the part's beginning.
    pub column: usize,
    /// The length.
    pub len: usize,
    /// The LF file.
    pub lf: &'m str,
    /// The line there.
    pub lf_line: usize,
    /// The column there.
    pub lf_column: usize,
}

/// A place in the LF program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Origin {
    /// Position in the list of LF paths.
    pub(crate) file: usize,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

impl SourceMap {
    pub(crate) fn new(lf_paths: Vec<String>) -> Self {
        Self { lf_paths, files: BTreeMap::new() }
    }

    pub(crate) fn insert(&mut self, generated_path: String, map: FileMap) {
        self.files.insert(generated_path, map);
    }

    /// Returns the map of the files in one folder, such as a crate's, by their paths in it.
    #[must_use]
    pub fn in_folder(&self, folder: &str) -> Self {
        let inside = |path: &str| Some(path.strip_prefix(folder)?.strip_prefix('/')?.to_owned());
        let files = self.files.iter().filter_map(|(path, map)| Some((inside(path)?, map.clone()))).collect();
        Self { lf_paths: self.lf_paths.clone(), files }
    }

    /// Returns the place in the LF program for a place in a generated file.
    ///
    /// A place in a verbatim piece (a body, a preamble, a value) maps exactly; any other place maps to the declaration
    /// for which it was generated. Returns `None` for code without an origin in the program.
    pub fn to_lf(&self, generated_path: &str, line: usize, column: usize) -> Option<(&str, usize, usize)> {
        let file = self.files.get(generated_path)?;
        let place = file.piece(line, column).or_else(|| file.anchor(line))?;
        Some((self.lf_paths.get(place.file)?.as_str(), place.line, place.column))
    }

    /// Returns all verbatim parts, by generated file and place.
    pub fn verbatim(&self) -> impl Iterator<Item = VerbatimPart<'_>> {
        let all = self.files.iter().flat_map(|(path, file)| file.pieces.iter().map(move |piece| (path, piece)));
        all.filter_map(|(path, Piece { line, column, len, to })| {
            let lf = self.lf_paths.get(to.file)?;
            let (line, column, len) = (*line, *column, *len);
            Some(VerbatimPart { generated: path, line, column, len, lf, lf_line: to.line, lf_column: to.column })
        })
    }

    /// Returns whether a place in a generated file lies in a verbatim piece, so that an excerpt of the LF file shows
    /// it.
    pub fn is_verbatim(&self, generated_path: &str, line: usize, column: usize) -> bool {
        self.files.get(generated_path).is_some_and(|file| file.piece(line, column).is_some())
    }
}

/// Lines of a generated file that are consecutive in the program, too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines {
    /// The first one, from the column at which it begins in the program.
    pub(crate) first: Piece,
    pub(crate) count: usize,
}

impl FileMap {
    /// Returns the verbatim lines, in as few rows as possible.
    pub(crate) fn lines(&self) -> Vec<Lines> {
        let mut all: Vec<Lines> = Vec::new();
        for piece in &self.pieces {
            let follows = |Lines { first, count }: &Lines| {
                let to = Origin { line: first.to.line + count, ..first.to };
                (piece.line, piece.column, piece.to) == (first.line + count, first.column, to)
            };
            match all.last_mut().filter(|last| follows(last)) {
                Some(last) => last.count += 1,
                None => all.push(Lines { first: *piece, count: 1 }),
            }
        }
        all
    }

    fn piece(&self, line: usize, column: usize) -> Option<Origin> {
        let until = self.pieces.partition_point(|piece| (piece.line, piece.column) <= (line, column));
        let piece = self.pieces[..until].last()?;
        let offset = column - piece.column.min(column);
        let inside = piece.line == line && offset <= piece.len;
        inside.then(|| Origin { column: piece.to.column + offset, ..piece.to })
    }

    fn anchor(&self, line: usize) -> Option<Origin> {
        let until = self.anchors.partition_point(|anchor| anchor.line <= line);
        self.anchors[..until].last()?.to
    }
}
