// SPDX-License-Identifier: Apache-2.0
//! The kinds of places, by the words and brackets before it. The text behind it, and whether all of it is a program,
//! does not matter.

use lf_compiler::syntax::{Lexeme, LexemeKind, lexemes};

/// A kind of place, called as what it asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Nothing: it is in a comment or a string.
    Nothing,
    /// An attribute, behind `@`.
    Attribute,
    /// A unit of time, behind a number.
    Unit,
    /// A key among the target's properties, with the keys around it.
    PropertyKey(Vec<String>),
    /// The value of the last of these keys.
    PropertyValue(Vec<String>),
    /// A port of an instance.
    PortOf(String),
    /// A reactor.
    Class,
    /// A file, within quotes or before them.
    ImportFile { quoted: bool },
    /// A reactor of a file, if that is known.
    Imported(Option<String>),
    /// A parameter of a reactor.
    Argument(String),
    /// A value.
    Value,
    /// A trigger of a reaction.
    Trigger,
    /// An effect of a reaction.
    Effect,
    /// An end of a connection.
    End,
    /// A word of the target language.
    Code,
    /// A declaration in a reactor.
    Member,
    /// A declaration in a file.
    Top,
}

/// The lexemes of a text up to a place.
struct Before<'t> {
    text: &'t str,
    list: Vec<Lexeme>,
}

/// Returns what a place asks for; a word that ends there is being typed.
pub(super) fn wanted(text: &str, byte: usize) -> Wanted {
    let start = text[..byte].trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len();
    let all = lexemes(text);
    for lexeme in all.iter().filter(|one| one.start < byte && byte <= one.end) {
        let piece = &text[lexeme.start..lexeme.end];
        let is_closed = byte == lexeme.end;
        match lexeme.kind {
            LexemeKind::Comment if !(is_closed && (piece.ends_with("*/") || piece.ends_with("'''"))) => {
                return Wanted::Nothing;
            }
            LexemeKind::Text if !(is_closed && piece.len() > 1 && piece.ends_with('"')) => {
                let before =
                    Before { text, list: all.iter().copied().take_while(|one| one.end <= lexeme.start).collect() };
                let is_import = before.word(0) == "from";
                return if is_import { Wanted::ImportFile { quoted: true } } else { Wanted::Nothing };
            }
            LexemeKind::Code if lexeme.start + 2 <= byte && !(piece.ends_with("=}") && byte + 2 > lexeme.end) => {
                return Wanted::Code;
            }
            _ => {}
        }
    }
    let is_before = |one: &Lexeme| one.end <= start && one.kind != LexemeKind::Comment;
    let after = all.iter().copied().filter(|one| one.start >= byte && one.kind != LexemeKind::Comment).collect();
    let before = Before { text, list: all.iter().copied().filter(is_before).collect() };
    before.wanted(&Before { text, list: after })
}

impl<'t> Before<'t> {
    /// Returns the text of the lexeme this many places before the last one; empty where there is none.
    fn word(&self, back: usize) -> &'t str {
        let index = self.list.len().checked_sub(back + 1);
        index.map_or("", |index| self.at(index))
    }

    fn at(&self, index: usize) -> &'t str {
        self.list.get(index).map_or("", |one| &self.text[one.start..one.end])
    }

    /// Returns the index of the last bracket that is open before a lexeme.
    fn open(&self, end: usize) -> Option<usize> {
        let mut depth = 0_usize;
        for index in (0..end).rev() {
            match self.list[index].kind {
                LexemeKind::Close => depth += 1,
                LexemeKind::Open if depth == 0 => return Some(index),
                LexemeKind::Open => depth -= 1,
                _ => {}
            }
        }
        None
    }

    fn wanted(&self, after: &Before<'_>) -> Wanted {
        let end = self.list.len();
        let open = self.open(end);
        let is_number = self.list.last().is_some_and(|one| one.kind == LexemeKind::Number) && !self.is_new_line();
        let in_brackets = open.is_some_and(|open| self.at(open) == "[");
        match self.word(0) {
            "@" => return Wanted::Attribute,
            "." => return Wanted::PortOf(self.word(1).to_owned()),
            "new" | "extends" => return Wanted::Class,
            "]" if self.before_pair(end - 1).is_some_and(|index| self.at(index) == "new") => return Wanted::Class,
            "from" => return Wanted::ImportFile { quoted: false },
            "after" => return Wanted::Value,
            _ if is_number && !in_brackets => return Wanted::Unit,
            _ => {}
        }
        if let Some(import) = self.import(after) {
            return import;
        }
        let Some(open) = open else { return Wanted::Top };
        match self.at(open) {
            "(" => self.in_parentheses(open),
            "[" => Wanted::Value,
            _ => self.target(open).unwrap_or_else(|| self.in_reactor(open)),
        }
    }

    /// Returns the index before the bracket that this one closes.
    fn before_pair(&self, close: usize) -> Option<usize> {
        self.open(close)?.checked_sub(1)
    }

    /// Returns what an import asks for, if the place is in one.
    fn import(&self, after: &Before<'_>) -> Option<Wanted> {
        let mut begin = (0..self.list.len()).rev().take_while(|index| {
            matches!(self.list[*index].kind, LexemeKind::Word) || matches!(self.at(*index), "," | "as" | "import")
        });
        let import = begin.find(|index| self.at(*index) == "import")?;
        let is_name = self.list.len() == import + 1 || self.word(0) == ",";
        if !is_name {
            return Some(Wanted::Nothing);
        }
        let from = (0..after.list.len()).find(|index| after.at(*index) == "from").filter(|index| {
            (0..*index).all(|index| {
                matches!(after.list[index].kind, LexemeKind::Word) || matches!(after.at(index), "," | "as")
            })
        });
        let file = from.map(|index| after.at(index + 1)).filter(|text| text.starts_with('"'));
        Some(Wanted::Imported(file.map(|text| text.trim_matches('"').to_owned())))
    }

    /// Returns what the target's properties ask for, if this brace is within them.
    fn target(&self, open: usize) -> Option<Wanted> {
        let mut path = Vec::new();
        let mut outer = open;
        while self.at(outer.checked_sub(1)?) == ":" {
            path.push(self.key(outer - 1));
            outer = self.open(outer)?;
        }
        if outer < 2 || self.at(outer - 2) != "target" {
            return None;
        }
        path.reverse();
        // What stands behind the last comma of this brace.
        let separator = (open..self.list.len()).rev().find(|index| {
            matches!(self.at(*index), "," | "{") && self.open(*index + 1).unwrap_or(*index) <= open.max(*index)
        });
        let colon = (separator.unwrap_or(open)..self.list.len()).rev().find(|index| self.at(*index) == ":");
        match colon {
            Some(colon) => {
                path.push(self.key(colon));
                Some(Wanted::PropertyValue(path))
            }
            None => Some(Wanted::PropertyKey(path)),
        }
    }

    /// Returns the key before a colon: words with dashes between them.
    fn key(&self, colon: usize) -> String {
        let mut begin = colon;
        while begin > 0 && (self.at(begin - 1) == "-" || self.list[begin - 1].kind.is_word()) {
            begin -= 1;
        }
        self.text.get(self.list[begin].start..self.list[colon].start).unwrap_or_default().trim().to_owned()
    }

    fn in_parentheses(&self, open: usize) -> Wanted {
        let back = |count: usize| open.checked_sub(count).map_or("", |index| self.at(index));
        if ["reaction", "mutation"].contains(&back(1)) || ["reaction", "mutation"].contains(&back(2)) {
            return Wanted::Trigger;
        }
        let is_new =
            back(2) == "new" || back(2) == "]" && self.before_pair(open - 2).is_some_and(|at| self.at(at) == "new");
        if is_new && ["(", ","].contains(&self.word(0)) {
            return Wanted::Argument(back(1).to_owned());
        }
        if back(1) == "reset" || back(1) == "history" {
            return Wanted::Effect;
        }
        Wanted::Value
    }

    /// Returns what the statement asks for that the place is in.
    fn in_reactor(&self, open: usize) -> Wanted {
        let statement: Vec<usize> = (open + 1..self.list.len())
            .rev()
            .take_while(|index| self.is_within_statement(*index))
            .filter(|index| self.open(*index) == Some(open))
            .collect();
        let has = |word: &str| statement.iter().any(|index| self.at(*index) == word);
        let goes_on = ["->", "~>", ",", "+"].contains(&self.word(0));
        let is_reaction = has("reaction") || has("mutation");
        match () {
            () if is_reaction && has("->") => Wanted::Effect,
            () if is_reaction => Wanted::Trigger,
            () if has("watchdog") && has("->") => Wanted::Effect,
            () if (has("->") || has("~>")) && (goes_on || !self.is_new_line()) => Wanted::End,
            () if ["=", ":"].contains(&self.word(0)) => Wanted::Value,
            () => Wanted::Member,
        }
    }

    /// Returns whether the place is not on the line of what is before it.
    fn is_new_line(&self) -> bool {
        let end = self.list.last().map_or(0, |last| last.end);
        let blanks = self.text[end..].split(|c: char| !c.is_whitespace()).next().unwrap_or_default();
        blanks.contains('\n')
    }

    /// Returns whether a lexeme does not end the statement before the place.
    fn is_within_statement(&self, index: usize) -> bool {
        let kind = self.list[index].kind;
        let is_end = kind == LexemeKind::Code || matches!(self.at(index), ";" | "}");
        // A line that begins with a word begins a statement, unless the one before goes on.
        let is_after_line = index > 0 && {
            let (last, this) = (self.list[index - 1], self.list[index]);
            let goes_on = ["->", "~>", ",", "+", "("].contains(&self.at(index - 1)) || self.at(index) == "->";
            self.text[last.end..this.start].contains('\n')
                && !goes_on
                && self.list.len() > index + 1
                && !["reaction", "mutation", "watchdog"].contains(&self.at(index))
                && self.at(index - 1) != "{"
        };
        !is_end && !is_after_line
    }
}

/// Tells words from other lexemes.
trait IsWord {
    fn is_word(&self) -> bool;
}

impl IsWord for LexemeKind {
    fn is_word(&self) -> bool {
        matches!(self, Self::Word | Self::Keyword)
    }
}

#[cfg(test)]
mod tests {
    use super::{Wanted, wanted};

    /// Returns what the place asks for that a text marks with `|`.
    fn at(text: &str) -> Wanted {
        let byte = text.find('|').expect("it has a mark");
        wanted(&text.replacen('|', "", 1), byte)
    }

    #[test]
    fn a_place_asks_by_what_is_before_it() {
        let key = |path: &[&str]| Wanted::PropertyKey(path.iter().map(|one| (*one).to_owned()).collect());
        let value = |path: &[&str]| Wanted::PropertyValue(path.iter().map(|one| (*one).to_owned()).collect());
        for (text, expected) in [
            ("|", Wanted::Top),
            ("target Rust\nre|", Wanted::Top),
            ("target Rust { |", key(&[])),
            ("target Rust { timeout: 1 s, lo|\n}", key(&[])),
            ("target Rust { timeout: 10 |", Wanted::Unit),
            ("target Rust { coordination: |}", value(&["coordination"])),
            ("target Rust { fast: true, clock-sync: o|}", value(&["clock-sync"])),
            ("target Rust { clock-sync-options: { tr|", key(&["clock-sync-options"])),
            (
                "target Rust { clock-sync-options: { trials: 3, local-federates-on: |",
                value(&["clock-sync-options", "local-federates-on"]),
            ),
            ("import | from \"lib.lf\"", Wanted::Imported(Some("lib.lf".to_owned()))),
            ("import A, B|", Wanted::Imported(None)),
            ("import A from |", Wanted::ImportFile { quoted: false }),
            ("import A from \"|\"", Wanted::ImportFile { quoted: true }),
            ("import A from \"li|", Wanted::ImportFile { quoted: true }),
            ("reactor R { |", Wanted::Member),
            ("target Rust\nimport |", Wanted::Imported(None)),
            ("reactor R { state n: u8 = 0\n  |", Wanted::Member),
            ("reactor R { input x: u8\n  in|", Wanted::Member),
            ("reactor R {\n  @|\n  input x: u8 }", Wanted::Attribute),
            ("reactor R { a = new |", Wanted::Class),
            ("reactor R { a = new[3] B|", Wanted::Class),
            ("reactor R extends |", Wanted::Class),
            ("reactor R { a = new B(|", Wanted::Argument("B".to_owned())),
            ("reactor R { a = new[2] B(x = 1, |", Wanted::Argument("B".to_owned())),
            ("reactor R { a = new B(x = |", Wanted::Value),
            ("reactor R { timer t(|", Wanted::Value),
            ("reactor R { timer t(0, 10 m|", Wanted::Unit),
            ("reactor R { reaction(|", Wanted::Trigger),
            ("reactor R { reaction r(a, |) {= =}", Wanted::Trigger),
            ("reactor R { reaction(a) -> |", Wanted::Effect),
            ("reactor R { reaction(a) -> y, reset(|", Wanted::Effect),
            ("reactor R { reaction(a)\n  -> y, | {= =}", Wanted::Effect),
            ("reactor R { reaction(a) | {= =}", Wanted::Trigger),
            ("reactor R { reaction(a) {= =}\n  |", Wanted::Member),
            ("reactor R { reaction(a) -> y {= ctx.| =}", Wanted::Code),
            ("reactor R { reaction(a) -> y {= ctx.|", Wanted::Code),
            ("reactor R { reaction(a) -> y {= =}|", Wanted::Member),
            ("reactor R { a.x -> |", Wanted::End),
            ("reactor R { a.x, b.y -> c.z,\n  |", Wanted::End),
            ("reactor R { a.x -> b.x\n  |", Wanted::Member),
            ("reactor R { a.|", Wanted::PortOf("a".to_owned())),
            ("reactor R { a.x -> b.y after |", Wanted::Value),
            ("reactor R { a.x -> b.y after 10 |", Wanted::Unit),
            ("reactor R { input[2|", Wanted::Value),
            ("reactor R { // no|", Wanted::Nothing),
            ("/* a | b */", Wanted::Nothing),
            ("target Rust { federation-id: \"|", Wanted::Nothing),
            ("reactor R { mode M {\n |", Wanted::Member),
        ] {
            assert_eq!(at(text), expected, "{text}");
        }
    }
}
