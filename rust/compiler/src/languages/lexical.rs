// SPDX-License-Identifier: Apache-2.0
//! What all languages have in common that know strings, comments and brackets: where a code block ends, and whether
//! its brackets have counterparts.

use core::ops::Range;

use super::language::{BlockEnd, CodeProblem};

/// The end of what begins at a byte that is not within anything else: of a comment, of a literal, of a word, or of the
/// character.
pub(super) type Skip = fn(text: &str, at: usize) -> usize;

/// Whether a byte is part of a word of ASCII.
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
            // A line that begins so within a string of several lines: the string's own end is missing.
            if inside.starts_with('"') && inside.lines().skip(1).any(|line| line.trim_start().starts_with("=}")) {
                return first;
            }
            hidden.get_or_insert(first);
        }
        at = end;
    }
    hidden.unwrap_or(BlockEnd::Missing)
}

/// An open bracket and where it closes, whose lines begin at different columns.
struct Askew {
    open: usize,
    close: usize,
}

/// The first bracket that has no counterpart.
pub(super) fn brackets(text: &str, skip: Skip) -> Option<CodeProblem> {
    let bytes = text.as_bytes();
    let mut open: Vec<usize> = Vec::new();
    let mut askew: Option<Askew> = None;
    let mut at = 0;
    while at < bytes.len() {
        let end = skip(text, at);
        let close = bytes[at];
        match close {
            b'(' | b'[' | b'{' => open.push(at),
            b')' | b']' | b'}' => {
                let Some(start) = open.pop() else { return Some(superfluous(text, at, askew)) };
                if counterpart(bytes[start]) != close {
                    let outer = open.last().copied();
                    return Some(crossed(text, start, at, outer));
                }
                let begins_line = |at: usize| indentation(text, at).filter(|(_, is_first)| *is_first);
                let (line, other) = (indentation(text, start), begins_line(at));
                if askew.is_none() && line.zip(other).is_some_and(|((one, _), (other, _))| one != other) {
                    askew = Some(Askew { open: start, close: at });
                }
            }
            _ => {}
        }
        at = end;
    }
    Some(unclosed(text, *open.last()?, askew))
}

/// A bracket that closes nothing.
fn superfluous(text: &str, at: usize, askew: Option<Askew>) -> CodeProblem {
    let also = askew.filter(|askew| text[askew.open..at].contains('\n'));
    CodeProblem {
        range: one(at),
        message: format!("this `{}` closes nothing", &text[one(at)]),
        also: also
            .map(|askew| (one(askew.close), "its line does not begin where that of its other bracket does".into())),
        hint: Some("remove it, or open a bracket before it".into()),
    }
}

/// A bracket that nothing closes.
fn unclosed(text: &str, at: usize, askew: Option<Askew>) -> CodeProblem {
    let (at, also) = match askew {
        // What closes it belongs to another one, as far as the lines tell.
        Some(askew) if askew.open > at => (askew.open, Some((one(askew.close), "this closes another one".into()))),
        _ => (at, None),
    };
    let bracket = &text[one(at)];
    CodeProblem {
        range: one(at),
        message: format!("this `{bracket}` is not closed"),
        also,
        hint: Some(format!("close it with `{}`", char::from(counterpart(text.as_bytes()[at])))),
    }
}

/// Two brackets that do not belong together.
fn crossed(text: &str, open: usize, close: usize, outer: Option<usize>) -> CodeProblem {
    let (bytes, shown) = (text.as_bytes(), &text[one(close)]);
    if outer.is_some_and(|outer| counterpart(bytes[outer]) == bytes[close]) {
        let also = Some((one(close), "before this".into()));
        return CodeProblem { also, ..unclosed(text, open, None) };
    }
    CodeProblem {
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

/// At which column the line of a place begins, and whether it begins with the place. Nothing in the first line, whose
/// beginning is not part of the text.
fn indentation(text: &str, at: usize) -> Option<(usize, bool)> {
    let start = text[..at].rfind('\n')? + 1;
    let blanks = text[start..].len() - text[start..].trim_start_matches([' ', '\t']).len();
    Some((blanks, start + blanks == at))
}
