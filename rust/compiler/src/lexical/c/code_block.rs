// SPDX-License-Identifier: Apache-2.0
//! C's strings and comments, which hide the end of a block of code, and brackets.

use crate::lexical::blocks::{brackets, is_word, strange, too_deep};
use crate::lexical::{CodeKind, CodeProblem};

/// Directives behind which arbitrary text can stand.
const DIRECTIVES: [&str; 2] = ["if", "define"];

/// Returns the problem with the characters and the brackets of a block. Macros and conditions of the preprocessor can
/// open brackets that are closed elsewhere, so for a block with such directives only the nesting is checked.
pub(in crate::lexical) fn problem(text: &str, kind: CodeKind) -> Option<CodeProblem> {
    let directive = |line: &str| {
        let directive = line.trim_start().strip_prefix('#').map(str::trim_start);
        directive.is_some_and(|directive| DIRECTIVES.iter().any(|one| directive.starts_with(one)))
    };
    // The text of such a line is prose.
    let is_prose =
        |line: &str| line.trim_start().starts_with('#') && (line.contains("error") || line.contains("warning"));
    if kind == CodeKind::TypeParameter {
        return None;
    }
    let found = too_deep(text, skip);
    if found.is_some() || text.lines().any(directive) {
        return found;
    }
    let strange = if text.lines().any(is_prose) { None } else { strange(text, skip, "C") };
    strange.or_else(|| brackets(text, skip))
}

/// Returns the end of the token that begins at a byte: a comment, a literal, a word, or a character.
pub(in crate::lexical) fn skip(text: &str, at: usize) -> usize {
    let bytes = text.as_bytes();
    match bytes[at] {
        b'/' if bytes.get(at + 1) == Some(&b'/') => line_end(bytes, at),
        b'/' if bytes.get(at + 1) == Some(&b'*') => text[at + 2..].find("*/").map_or(text.len(), |end| at + 4 + end),
        quote @ (b'"' | b'\'') => literal_end(bytes, at + 1, quote),
        byte if is_word(byte) => word_end(bytes, at),
        _ => at + text[at..].chars().next().map_or(1, char::len_utf8),
    }
}

/// Returns the end of a line: a line feed without a backslash before it.
fn line_end(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() && bytes[at] != b'\n' {
        at += skipped(bytes, at);
    }
    at.min(bytes.len())
}

/// Returns the number of bytes of an escape sequence; one for any other byte.
fn skipped(bytes: &[u8], at: usize) -> usize {
    match &bytes[at..] {
        [b'\\', b'\r', b'\n', ..] => 3,
        [b'\\', _, ..] => 2,
        _ => 1,
    }
}

/// Returns the end of a literal, which is on its line; otherwise the quote begins none, as in the text of `#error`.
fn literal_end(bytes: &[u8], begin: usize, quote: u8) -> usize {
    let mut at = begin;
    while at < bytes.len() && bytes[at] != b'\n' {
        if bytes[at] == quote {
            return at + 1;
        }
        at += skipped(bytes, at);
    }
    begin
}

/// Returns the end of a word. Numbers can have quotes between their digits.
fn word_end(bytes: &[u8], at: usize) -> usize {
    let is_number = bytes[at].is_ascii_digit();
    let part = |byte: &u8| is_word(*byte) || (is_number && *byte == b'\'');
    bytes[at..].iter().position(|byte| !part(byte)).map_or(bytes.len(), |length| at + length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexical::BlockEnd;
    use crate::lexical::blocks::block_end;

    fn rest(text: &str) -> Option<&str> {
        match block_end(text, skip) {
            BlockEnd::Found(end) => Some(&text[end..]),
            BlockEnd::Hidden { .. } | BlockEnd::Missing => None,
        }
    }

    #[test]
    fn strings_and_comments_hide_the_end() {
        assert_eq!(rest(r#" "=}\"=}" =} rest"#), Some(" rest"));
        assert_eq!(rest(" '\\'' '=' 1'000 =} rest"), Some(" rest"));
        assert_eq!(rest(" /* =} /* =} */ =} rest"), Some(" rest"));
        assert_eq!(rest(" // =} \\\n =}\n =} rest"), Some(" rest"));
        assert_eq!(rest(" // =} \\\r\n =}\n =} rest"), Some(" rest"));
        assert_eq!(rest(" #error don't\n #error say \"no\n =} rest"), Some(" rest"));
        assert_eq!(rest(" // =}"), None);
        assert_eq!(rest(" \"\\"), None);
    }

    #[test]
    fn brackets_have_counterparts_unless_the_preprocessor_takes_part() {
        let message = |text| problem(text, CodeKind::Statements).map(|problem| problem.message);
        assert_eq!(message(" if (a) { f(\")\"); // {\n }"), None);
        assert_eq!(message(" f(1;").as_deref(), Some("this `(` is not closed"));
        assert_eq!(message(" }").as_deref(), Some("this `}` closes nothing"));
        assert_eq!(message("\n #ifdef A\n if (a) {\n #else\n {\n # endif\n }"), None);
        assert_eq!(message("#define BEGIN {\n"), None);
    }
}
