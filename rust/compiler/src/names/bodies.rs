// SPDX-License-Identifier: Apache-2.0
//! The words of bodies that can name elements of a reactor.
//!
//! A body is not parsed: a local variable with the name of an element counts as that element. So a rename changes both,
//! and the body means what it meant.

use crate::lexical::Language;

/// The place of a word in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WordUse<'c> {
    /// Behind `self.` or `self->`.
    Field,
    /// Behind another word and a dot.
    Of(&'c str),
    /// By itself.
    Variable,
    /// By itself, before a parenthesis, where that calls a method.
    Call,
}

/// A word of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CodeWord<'c> {
    pub(super) text: &'c str,
    /// The first byte in the body.
    pub(super) start: usize,
    pub(super) kind: WordUse<'c>,
}

/// Finds the words of a body.
pub(super) struct CodeWords;

impl CodeWords {
    /// Returns the words of a body, in the order of the text.
    pub(super) fn of(language: Language, code: &str) -> Vec<CodeWord<'_>> {
        let mut at = 0;
        let pieces: Vec<(usize, &str)> = language
            .pieces(code)
            .map(|piece| {
                let start = at;
                at += piece.len();
                (start, piece)
            })
            .filter(|(_, piece)| !piece.trim().is_empty())
            .filter(|(_, piece)| !piece.starts_with("//") && !piece.starts_with("/*"))
            .collect();
        let text = |index: usize| pieces.get(index).map_or("", |(_, text)| *text);
        let before = |index: usize, back: usize| index.checked_sub(back).map_or("", text);
        let mut words = Vec::new();
        for (index, (start, piece)) in pieces.iter().enumerate() {
            if piece.starts_with('"') && language == Language::Rust {
                words.extend(captured(piece, *start));
            }
            if !is_word(piece) {
                continue;
            }
            let kind = match before(index, 1) {
                "." if before(index, 2) == "self" => WordUse::Field,
                "." if is_word(before(index, 2)) => WordUse::Of(before(index, 2)),
                ">" if before(index, 2) == "-" && before(index, 3) == "self" => WordUse::Field,
                ">" if before(index, 2) == "-" && language == Language::C => continue,
                // `child[i].port`
                "." if language == Language::C && before(index, 2) == "]" => match indexed(&pieces[..index - 1]) {
                    Some(container) => WordUse::Of(container),
                    None => continue,
                },
                "." => continue,
                ":" if before(index, 2) == ":" => continue,
                // The name of a field.
                "{" | "," if text(index + 1) == ":" && text(index + 2) != ":" => continue,
                _ if language == Language::C && text(index + 1) == "(" => WordUse::Call,
                _ => WordUse::Variable,
            };
            words.push(CodeWord { text: piece, start: *start, kind });
        }
        words
    }
}

fn is_word(piece: &str) -> bool {
    !piece.is_empty() && piece.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// Returns the word before the index that these pieces end with.
fn indexed<'c>(pieces: &[(usize, &'c str)]) -> Option<&'c str> {
    let mut depth = 0_usize;
    for (_, piece) in pieces.iter().rev() {
        match *piece {
            "]" => depth += 1,
            "[" => depth = depth.saturating_sub(1),
            word if depth == 0 => return is_word(word).then_some(word),
            _ => {}
        }
    }
    None
}

/// Returns the variables that a string of Rust may capture: `{x}` and `{x:?}`.
fn captured(string: &str, start: usize) -> impl Iterator<Item = CodeWord<'_>> {
    string.match_indices('{').filter_map(move |(open, _)| {
        let rest = &string[open + 1..];
        let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_')?;
        let is_one = length > 0 && rest[length..].starts_with(['}', ':']);
        let text = &rest[..length];
        is_one.then_some(CodeWord { text, start: start + open + 1, kind: WordUse::Variable })
    })
}

#[cfg(test)]
mod tests {
    use super::{CodeWords, Language};

    fn words(language: Language, code: &str) -> String {
        let all = CodeWords::of(language, code);
        assert!(all.iter().all(|word| code[word.start..].starts_with(word.text)));
        let line = all.iter().map(|word| format!("{} {:?}", word.text, word.kind));
        line.collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn words_are_told_from_fields_paths_strings_and_comments() {
        let rust = "let y = ctx.get(x) /* x */; self.n = P { x: a__b }; m::x; \"{x} {y:?} {{}} {0}\"; // x";
        assert_eq!(
            words(Language::Rust, rust),
            "let Variable, y Variable, ctx Variable, get Of(\"ctx\"), x Variable, self Variable, n Field, P Variable, \
             a__b Variable, m Variable, x Variable, y Variable, 0 Variable"
        );
        let c = "lf_set(y, self->n + a.x->value + bank[i + 1].x->value + run(2) + \"x {y}\");";
        assert_eq!(
            words(Language::C, c),
            "lf_set Call, y Variable, self Variable, n Field, a Variable, x Of(\"a\"), bank Variable, i Variable, 1 \
             Variable, x Of(\"bank\"), run Call, 2 Variable"
        );
    }
}
