// SPDX-License-Identifier: Apache-2.0
//! The top of a file: target, imports, preambles, reactors.

use super::super::ast::{Import, ImportSource, ImportedReactor, Name, SourceUnit, TargetSyntax};
use super::super::token::{TokenKind, Tokens, tokens};
use super::super::words::FILE_STARTS;
use super::{Parsed, Parser};
use crate::diagnostics::{Diagnostic, FileId, Span};
use crate::lexical::{Language, MICRO, is_micro_path};

/// Parses the file at a path.
pub(crate) fn parse(file: FileId, path: &str, text: &str) -> (SourceUnit, Vec<Diagnostic>) {
    // A file of micro LF need not declare its target.
    let assumed = is_micro_path(path).then_some(MICRO);
    let language = assumed.and_then(Language::named).unwrap_or_default();
    let Tokens { list, comments, open, diagnostics } = tokens(file, text, language);
    let mut parser = Parser {
        file,
        text,
        tokens: list,
        comments,
        open,
        position: 0,
        depth: 0,
        diagnostics,
        mode: None,
        codes: Vec::new(),
        beginnings: Vec::new(),
    };
    let mut unit = parser.source_unit();
    let target = |name: &str| TargetSyntax {
        name: Name { text: name.to_owned(), span: Span::new(file, 0, 0) },
        properties: Vec::new(),
    };
    unit.target = unit.target.or(assumed.map(target));
    unit.codes = parser.codes;
    unit.comments = parser.comments;
    unit.beginnings = parser.beginnings;
    (unit, parser.diagnostics)
}

impl Parser<'_> {
    fn source_unit(&mut self) -> SourceUnit {
        let mut unit = SourceUnit::default();
        while !self.at_end() {
            let start = self.position;
            if self.file_member(&mut unit).is_err() {
                self.recover_in_file(start);
            }
        }
        unit
    }

    fn file_member(&mut self, unit: &mut SourceUnit) -> Parsed<()> {
        self.beginnings.push(self.peek(0).start);
        match self.word_ahead(0) {
            Some("target") => {
                let target = self.target()?;
                unit.target.get_or_insert(target);
            }
            Some("import") => {
                let import = self.import()?;
                unit.imports.push(import);
            }
            Some("private" | "public" | "preamble") => {
                let preamble = self.preamble()?;
                unit.preambles.push(preamble);
            }
            Some("main" | "federated" | "realtime" | "reactor") => {
                let reactor = self.reactor(Vec::new(), self.peek(0).start)?;
                unit.reactors.push(reactor);
            }
            _ if self.at(TokenKind::At) => {
                let start = self.peek(0).start;
                let attributes = self.attributes()?;
                let reactor = self.reactor(attributes, start)?;
                unit.reactors.push(reactor);
            }
            _ if self.eat(TokenKind::Semicolon) => {}
            _ => {
                let hint = self.place_of_code().or_else(|| self.meant(&[FILE_STARTS, &["preamble"]].concat()));
                return self.unexpected_but("`target`, `import`, `preamble` or a reactor", hint);
            }
        }
        Ok(())
    }

    /// Skips to the next declaration of a file, taking at least one token since `start`.
    pub(super) fn recover_in_file(&mut self, start: usize) {
        if self.position == start {
            self.advance();
        }
        while !self.at_end() && !self.at_file_start() {
            let starts = matches!(self.word_ahead(0), Some("private" | "public" | "preamble"));
            if starts || self.at(TokenKind::At) {
                break;
            }
            self.advance();
        }
    }

    fn import(&mut self) -> Parsed<Import> {
        let start = self.here();
        self.advance();
        let mut reactors = vec![self.imported_reactor()?];
        while self.eat(TokenKind::Comma) {
            reactors.push(self.imported_reactor()?);
        }
        if self.eat_word("from").is_none() {
            return self.unexpected("`,`, `as` or `from`");
        }
        let source = if self.at(TokenKind::Less) {
            ImportSource::Package(self.package_path()?)
        } else {
            ImportSource::File(self.string("a file name in quotes")?)
        };
        let span = start.to(self.before());
        self.eat(TokenKind::Semicolon);
        Ok(Import { reactors, source, span })
    }

    fn imported_reactor(&mut self) -> Parsed<ImportedReactor> {
        let name = self.name("the name of a reactor")?;
        let alias = if self.eat_word("as").is_some() { Some(self.name("a name for the reactor")?) } else { None };
        Ok(ImportedReactor { name, alias })
    }

    fn package_path(&mut self) -> Parsed<Name> {
        let open = self.expect(TokenKind::Less, "`<`")?;
        while !matches!(self.kind(), TokenKind::Greater | TokenKind::End) && !self.peek(0).first_of_line {
            self.advance();
        }
        let close = self.expect(TokenKind::Greater, "`>`")?;
        Ok(Name { text: self.text[open.end..close.start].to_owned(), span: open.to(close) })
    }
}
