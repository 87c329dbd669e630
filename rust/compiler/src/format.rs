// SPDX-License-Identifier: Apache-2.0
//! Formats a file: indentation, blanks between tokens, and empty lines. The author decides where lines end.
//!
//! A line that begins a declaration, a property or the end of a block stands as deep as its block. Any other line goes
//! on with the one before, and moves with it, as the lines of comments and of code blocks do. What stands in code after
//! the blanks at the beginning of a line stays as it is.

use core::ops::Range;

use crate::compilation::{leaves_gaps, parse};
use crate::diagnostics::{Diagnostics, FileId};
use crate::lexical::Language;
use crate::syntax::ast::SourceUnit;
use crate::syntax::{Token, TokenKind, tokens};

/// The indentation of a block, in blanks.
const INDENT: usize = 2;
/// The distance of tabulators in a file that has some.
const TAB: usize = 4;

/// Returns the formatted text of a file. It has the same tokens, and formatting it again changes nothing.
///
/// # Errors
/// The errors of syntax, outside of code blocks, for which the file is left as it is.
pub fn format(path: &str, text: &str) -> Result<String, Box<Diagnostics>> {
    let tree = parse(path, text);
    if tree.diagnostics.iter().any(|entry| leaves_gaps(entry.code)) {
        return Err(Box::new(tree.diagnostics));
    }
    let mut formatter = Formatter::new(text, tree.unit);
    for index in 0..formatter.items.len() {
        formatter.add(index);
    }
    Ok(formatter.finish())
}

/// A token or a comment.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Item {
    kind: TokenKind,
    start: usize,
    end: usize,
}

/// A kind of bracket that is open.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Open {
    /// The braces of a reactor or a mode.
    Block,
    /// The braces of properties, of which each stands by itself.
    Properties,
    /// Parentheses.
    Parentheses,
    /// Square brackets, and the braces of a list of values.
    List,
}

/// The text so far.
struct Formatter<'t> {
    text: &'t str,
    /// The language of code, if it is known.
    language: Option<Language>,
    items: Vec<Item>,
    /// The beginnings of declarations, in the order of the text.
    beginnings: Vec<usize>,
    out: String,
    open: Vec<Open>,
    /// The bracket that the current item closes.
    closed: Option<Open>,
    /// By how many columns the current line, and what goes on with it, moves.
    shift: isize,
    /// Whether the current line is one of several between parentheses or of a list, whose columns may stand below each
    /// other.
    in_table: bool,
    /// The first word of the current declaration.
    declaration: &'t str,
    /// Whether the place of a reactor on a network is under way, which consists of many tokens.
    in_host: bool,
}

impl<'t> Formatter<'t> {
    fn new(text: &'t str, unit: SourceUnit) -> Self {
        let SourceUnit { target, mut beginnings, .. } = unit;
        let language = target.map_or(Some(Language::default()), |target| Language::named(&target.name.text));
        let read = tokens(FileId::default(), text, language.unwrap_or_default());
        let token = |&Token { kind, start, end, .. }: &Token| Item { kind, start, end };
        let comment = |&Range { start, end }: &Range<usize>| Item { kind: TokenKind::Comment, start, end };
        let tokens = read.list.iter().filter(|token| token.kind != TokenKind::End).map(token);
        let mut items: Vec<Item> = tokens.chain(read.comments.iter().map(comment)).collect();
        items.sort_by_key(|item| item.start);
        beginnings.sort_unstable();
        Self {
            text,
            language,
            items,
            beginnings,
            out: String::new(),
            open: Vec::new(),
            closed: None,
            shift: 0,
            in_table: false,
            declaration: "",
            in_host: false,
        }
    }

    fn slice(&self, item: Item) -> &'t str {
        &self.text[item.start..item.end]
    }

    /// Adds the item at this position, and what stands between it and the one before.
    fn add(&mut self, index: usize) {
        let item = self.items[index];
        let before = index.checked_sub(1).map(|before| self.items[before]);
        let gap = &self.text[before.map_or(0, |before| before.end)..item.start];
        let lines = gap.matches('\n').count();
        let closes = matches!(item.kind, TokenKind::CloseBrace | TokenKind::CloseParenthesis | TokenKind::CloseBracket);
        self.closed = if closes { self.open.pop() } else { None };
        if before.is_none() || lines > 0 {
            if before.is_some() {
                self.out.push_str(if lines > 1 { "\n\n" } else { "\n" });
            }
            // The place can stand in the line below `at`.
            self.in_host &= before.is_some_and(|before| self.slice(before) == "at");
            self.in_table = matches!(self.open.last(), Some(Open::Parentheses | Open::List));
            let indent = self.indent(index);
            self.out.push_str(&" ".repeat(indent));
        } else if let Some(before) = before {
            let blanks = self.blanks(before, item, gap);
            self.out.push_str(&" ".repeat(blanks));
        }
        self.push(item);
        let word = self.slice(item);
        if self.beginnings.binary_search(&item.start).is_ok() {
            self.declaration = word;
        }
        match item.kind {
            TokenKind::OpenBrace | TokenKind::OpenParenthesis | TokenKind::OpenBracket => {
                self.open.push(self.opened(item, before));
                self.in_host &= item.kind != TokenKind::OpenBrace;
            }
            TokenKind::Word if word == "at" => self.in_host = true,
            _ => {}
        }
    }

    /// Adds the text of an item. The lines of a comment, or of code, move together.
    fn push(&mut self, item: Item) {
        let text = self.slice(item);
        let is_comment = item.kind == TokenKind::Comment;
        let moves = is_comment || item.kind == TokenKind::Code && self.can_move(text);
        if !moves {
            self.out.push_str(text);
            return;
        }
        for (number, line) in text.trim_end().split('\n').enumerate() {
            if number > 0 {
                let inner = line.trim_start();
                let width = moved(columns(&line[..line.len() - inner.len()]), self.shift);
                self.out.push('\n');
                if !inner.is_empty() {
                    self.out.push_str(&" ".repeat(width));
                }
                self.out.push_str(if is_comment { inner.trim_end() } else { inner });
            } else {
                self.out.push_str(if is_comment { line.trim_end() } else { line });
            }
        }
    }

    /// Returns whether code means the same when its lines move: each has room for that, and none is within a literal.
    fn can_move(&self, code: &str) -> bool {
        let blanks = |line: &str| line.len() - line.trim_start().len();
        let has_room = |line: &str| line.trim().is_empty() || blanks(line).cast_signed() >= -self.shift;
        let is_well = self.shift != 0 && !code.contains('\t') && code.split('\n').skip(1).all(has_room);
        let is_literal = |piece: &str| piece.contains('\n') && piece.len() > 1 && !piece.starts_with('/');
        is_well
            && match self.language {
                Some(language) => !language.pieces(code).any(is_literal),
                // Strings of several lines in Python, TypeScript and C++.
                None => !["\"\"\"", "'''", "`", "R\""].iter().any(|mark| code.contains(mark)),
            }
    }

    /// Returns the indentation of the line that an item begins.
    fn indent(&mut self, index: usize) -> usize {
        let item = self.items[index];
        let line = self.text[..item.start].rfind('\n').map_or(0, |end| end + 1);
        let old = columns(&self.text[line..item.start]);
        // A comment belongs to what follows.
        let next = self.items[index..].iter().find(|item| item.kind != TokenKind::Comment);
        if next.is_none_or(|next| self.begins(index, *next)) {
            let new = INDENT * self.open.iter().filter(|open| matches!(open, Open::Block | Open::Properties)).count();
            self.shift = new.cast_signed() - old.cast_signed();
            return new;
        }
        moved(old, self.shift)
    }

    /// Returns whether this item begins a declaration or a property, or ends a block.
    fn begins(&self, index: usize, item: Item) -> bool {
        // Comments may stand before the end of a block.
        let block = if item == self.items[index] { self.closed } else { self.open.last().copied() };
        let ends = item.kind == TokenKind::CloseBrace && matches!(block, Some(Open::Block | Open::Properties));
        if ends || self.beginnings.binary_search(&item.start).is_ok() {
            return true;
        }
        let before = self.items[..index].iter().rev().find(|before| before.kind != TokenKind::Comment);
        let is_first = before.is_none_or(|before| matches!(before.kind, TokenKind::OpenBrace | TokenKind::Comma));
        is_first && self.open.last() == Some(&Open::Properties)
    }

    /// Returns the number of blanks between two items on a line.
    fn blanks(&self, left: Item, right: Item, gap: &str) -> usize {
        use TokenKind as Kind;
        let as_it_is = usize::from(!gap.is_empty());
        let is_argument = self.open.last() == Some(&Open::Parentheses);
        match (left.kind, right.kind) {
            // Comments at the ends of lines may stand below each other.
            (_, Kind::Comment) => gap.chars().count().max(1),
            (Kind::Comment, _) => 1,
            _ if self.in_host => as_it_is,
            (
                _,
                Kind::Comma
                | Kind::Semicolon
                | Kind::Colon
                | Kind::CloseParenthesis
                | Kind::CloseBracket
                | Kind::Greater,
            )
            | (Kind::OpenParenthesis | Kind::OpenBracket | Kind::At | Kind::Less, _)
            | (Kind::Greater, Kind::OpenParenthesis)
            | (Kind::Word, Kind::OpenBracket) => 0,
            (Kind::Comma, _) if self.in_table => gap.chars().count(),
            (_, Kind::OpenBrace) if (self.is_state() || is_argument) && left.kind != Kind::Equals => as_it_is,
            // `a=1` and `a = 1` are both usual there.
            (Kind::Equals, _) | (_, Kind::Equals) if is_argument => as_it_is,
            (Kind::Word, Kind::OpenParenthesis | Kind::Less) if !is_operator(self.slice(left)) => 0,
            // `+=` is two tokens.
            (Kind::Plus, Kind::Equals) | (Kind::OpenBrace, _) | (_, Kind::CloseBrace) => as_it_is,
            (Kind::Comma | Kind::Semicolon | Kind::Colon | Kind::Arrow | Kind::PhysicalArrow | Kind::Equals, _)
            | (_, Kind::Arrow | Kind::PhysicalArrow | Kind::Equals | Kind::OpenBrace)
            | (Kind::Code | Kind::CloseBracket | Kind::CloseParenthesis, Kind::Word)
            | (Kind::Word, Kind::Text | Kind::Less)
            | (Kind::Word | Kind::CloseParenthesis, Kind::Code) => 1,
            _ => as_it_is,
        }
    }

    /// Returns whether a state variable is declared, whose value may follow its type in braces.
    fn is_state(&self) -> bool {
        matches!(self.declaration, "state" | "reset")
    }

    /// Returns what a bracket opens, behind the item before it.
    fn opened(&self, bracket: Item, before: Option<Item>) -> Open {
        let is_value = before.is_some_and(|before| matches!(before.kind, TokenKind::Equals | TokenKind::Comma));
        let is_block = matches!(self.open.last(), None | Some(Open::Block)) && !self.is_state() && !is_value;
        match bracket.kind {
            TokenKind::OpenParenthesis => Open::Parentheses,
            TokenKind::OpenBrace if self.declaration == "target" => Open::Properties,
            TokenKind::OpenBrace if is_block => Open::Block,
            _ => Open::List,
        }
    }

    fn finish(mut self) -> String {
        if !self.out.is_empty() && !self.out.ends_with('\n') {
            self.out.push('\n');
        }
        self.out
    }
}

/// Returns whether a word stands before an expression, so that no blank is missing behind it.
fn is_operator(word: &str) -> bool {
    matches!(word, "after" | "at" | "extends" | "from" | "of")
}

/// Returns the number of columns that blanks take.
fn columns(blanks: &str) -> usize {
    blanks.chars().fold(0, |column, blank| if blank == '\t' { (column / TAB + 1) * TAB } else { column + 1 })
}

/// Returns a column that moves with its line, as far as there is room.
fn moved(column: usize, shift: isize) -> usize {
    column.saturating_add_signed(shift)
}
