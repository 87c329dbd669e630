// SPDX-License-Identifier: Apache-2.0
//! The common parts of all languages with strings, comments and brackets: the end of a code block, and the matching of
//! its brackets.

use core::ops::Range;

use super::code::{BlockEnd, CodeProblem};
use crate::characters::{instead, is_invisible, shown};
use crate::diagnostics::Code;

/// The maximum nesting of brackets. Compilers have such limits; Clang's is the same.
pub(super) const BRACKETS_MAX: usize = 256;

/// Returns the end of the token that begins at a byte: a comment, a literal, a word, or a character.
pub(super) type Skip = fn(text: &str, at: usize) -> usize;

/// Returns whether a byte is part of a word of ASCII.
pub(super) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Looks for the end of a block in the text after its `{=`: the first `=}` that nothing hides.
pub(super) fn block_end(text: &str, skip: Skip) -> BlockEnd {
    let mut hidden = None;
    let mut at = 0;
    while at < text.len() {
        if text[at..].starts_with("=}") {
            return BlockEnd::Found(at + 2);
        }
        let end = skip(text, at);
        let inside = &text[at..end];
        if let Some(found) = inside.find("=}") {
            let first = BlockEnd::Hidden { end: at + found + 2, by: at };
            // A string of several lines with such a line: the string's own end is missing.
            if inside.starts_with('"') && inside.lines().skip(1).any(|line| line.trim_start().starts_with("=}")) {
                return first;
            }
            hidden.get_or_insert(first);
        }
        at = end;
    }
    hidden.unwrap_or(BlockEnd::Missing)
}

/// A bracket and its counterpart, whose lines begin at different columns.
struct Misaligned {
    open: usize,
    close: usize,
}

/// The beginning of a line, without line feeds, and the number of its leading blanks.
#[derive(Clone, Copy)]
struct LineStart {
    at: usize,
    blanks: usize,
}

impl LineStart {
    /// Returns the last line that begins in a part of the text.
    fn last_in(text: &str, range: Range<usize>) -> Option<Self> {
        let at = range.start + text[range].rfind('\n')? + 1;
        let blanks = text[at..].len() - text[at..].trim_start_matches([' ', '\t']).len();
        Some(Self { at, blanks })
    }
}

/// Returns the problem of the first bracket without a counterpart.
pub(super) fn brackets(text: &str, skip: Skip) -> Option<CodeProblem> {
    let bytes = text.as_bytes();
    // The beginning of the first line is not part of the text.
    let mut line: Option<LineStart> = None;
    let mut open: Vec<(usize, Option<LineStart>)> = Vec::new();
    let mut pair: Option<Misaligned> = None;
    let mut at = 0;
    while at < bytes.len() {
        let end = skip(text, at);
        let close = bytes[at];
        match close {
            b'(' | b'[' | b'{' => open.push((at, line)),
            b')' | b']' | b'}' => {
                let Some((start, opened)) = open.pop() else { return Some(superfluous(text, at, pair)) };
                if counterpart(bytes[start]) != close {
                    let outer = open.last().map(|(at, _)| *at);
                    return Some(crossed(text, start, at, outer));
                }
                let begins_line = line.filter(|line| line.at + line.blanks == at);
                if pair.is_none() && opened.zip(begins_line).is_some_and(|(one, other)| one.blanks != other.blanks) {
                    pair = Some(Misaligned { open: start, close: at });
                }
            }
            _ => {}
        }
        line = LineStart::last_in(text, at..end).or(line);
        at = end;
    }
    Some(unclosed(text, open.last()?.0, pair))
}

/// Returns the problem of the first bracket that exceeds the nesting limit.
pub(super) fn too_deep(text: &str, skip: Skip) -> Option<CodeProblem> {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < text.len() {
        match text.as_bytes()[at] {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > BRACKETS_MAX {
            return Some(CodeProblem::too_deep(one(at)));
        }
        at = skip(text, at);
    }
    None
}

impl CodeProblem {
    /// Returns the problem of code that is nested too deeply.
    pub(super) fn too_deep(range: Range<usize>) -> Self {
        Self {
            code: Code::NestingTooDeep,
            range,
            message: format!("this code is nested more than {BRACKETS_MAX} levels deep, or one expression is too long"),
            also: None,
            hint: Some("move a part of it to a function in a preamble, or to variables".into()),
        }
    }
}

/// Invisible characters that Rust accepts as blanks.
const BLANKS: [char; 6] = ['\u{B}', '\u{85}', '\u{200E}', '\u{200F}', '\u{2028}', '\u{2029}'];

/// Returns the problem of the first meaningless character outside of strings and comments: one that is invisible or
/// looks like another.
pub(super) fn strange(text: &str, skip: Skip, language: &str) -> Option<CodeProblem> {
    if text.is_ascii() && !text.bytes().any(|byte| is_invisible(char::from(byte))) {
        return None;
    }
    let mut at = 0;
    while at < text.len() {
        let c = text[at..].chars().next().filter(|c| is_invisible(*c) || (!c.is_ascii() && instead(*c).is_some()));
        if let Some(c) = c.filter(|c| !BLANKS.contains(c)) {
            return Some(CodeProblem {
                code: Code::CodeSyntax,
                range: at..at + c.len_utf8(),
                message: format!("{} has no meaning in {language}", shown(c)),
                also: None,
                hint: instead(c),
            });
        }
        at = skip(text, at);
    }
    None
}

/// Returns the problem of a bracket that closes nothing.
fn superfluous(text: &str, at: usize, pair: Option<Misaligned>) -> CodeProblem {
    let also = pair.filter(|pair| text[pair.open..at].contains('\n'));
    CodeProblem {
        code: Code::CodeSyntax,
        range: one(at),
        message: format!("this `{}` closes nothing", &text[one(at)]),
        also: also.map(|pair| (one(pair.close), "its line does not begin where that of its other bracket does".into())),
        hint: Some("remove it, or open a bracket before it".into()),
    }
}

/// Returns the problem of a bracket that is not closed.
fn unclosed(text: &str, at: usize, pair: Option<Misaligned>) -> CodeProblem {
    let (at, also) = match pair {
        // According to the lines, its counterpart belongs to another bracket.
        Some(pair) if pair.open > at => (pair.open, Some((one(pair.close), "this closes another one".into()))),
        _ => (at, None),
    };
    let bracket = &text[one(at)];
    CodeProblem {
        code: Code::CodeSyntax,
        range: one(at),
        message: format!("this `{bracket}` is not closed"),
        also,
        hint: Some(format!("close it with `{}`", char::from(counterpart(text.as_bytes()[at])))),
    }
}

/// Returns the problem of two brackets that do not match.
fn crossed(text: &str, open: usize, close: usize, outer: Option<usize>) -> CodeProblem {
    let (bytes, shown) = (text.as_bytes(), &text[one(close)]);
    if outer.is_some_and(|outer| counterpart(bytes[outer]) == bytes[close]) {
        let also = Some((one(close), "before this".into()));
        return CodeProblem { also, ..unclosed(text, open, None) };
    }
    CodeProblem {
        code: Code::CodeSyntax,
        range: one(close),
        message: format!("this `{shown}` does not close `{}`", &text[one(open)]),
        also: Some((one(open), "opened here".into())),
        hint: Some(format!("write `{}`, or open a bracket before it", char::from(counterpart(bytes[open])))),
    }
}

fn counterpart(open: u8) -> u8 {
    match open {
        b'(' => b')',
        b'[' => b']',
        _ => b'}',
    }
}

fn one(at: usize) -> Range<usize> {
    at..at + 1
}
