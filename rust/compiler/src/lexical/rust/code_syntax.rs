// SPDX-License-Identifier: Apache-2.0
//! The problems with the syntax of a block of Rust that are visible without rustc: first its brackets, because a parser
//! names the place where it notices a missing bracket, and not that of the unmatched one; then the nesting, because a
//! parser recurses; then the errors of a parser.

use proc_macro2::{LineColumn, TokenStream, TokenTree};
use syn::parse::Parser as _;

use super::code_block::skip;
use super::nesting;
use super::words::raw;
use crate::diagnostics::Code;
use crate::lexical::blocks::{brackets, strange};
use crate::lexical::{CodeKind, CodeProblem};

/// Returns the first problem.
pub(in crate::lexical) fn problem(text: &str, kind: CodeKind) -> Option<CodeProblem> {
    let found = strange(text, skip, "Rust").or_else(|| brackets(text, skip));
    found.or_else(|| nesting::problem(text)).or_else(|| parse(text, kind))
}

/// Returns the error of a parser.
fn parse(text: &str, kind: CodeKind) -> Option<CodeProblem> {
    let error = match kind {
        CodeKind::Statements => syn::Block::parse_within.parse_str(text).err(),
        CodeKind::Items => syn::parse_str::<syn::File>(text).err(),
        CodeKind::Expression => syn::parse_str::<syn::Expr>(text).err(),
        CodeKind::Type => syn::parse_str::<syn::Type>(text).err(),
        CodeKind::TypeParameter => syn::parse_str::<syn::TypeParam>(text).err(),
    }?;
    let message = error.to_string();
    let (start, end) = (byte_of(text, error.span().start()), byte_of(text, error.span().end()));
    // A missing token behind a statement is noticed at the beginning of the next one.
    let missing = message.ends_with("expected `;`").then(|| end_before(text, start)).flatten();
    let range = if start == 0 && (text.starts_with(char::is_whitespace) || message.starts_with("unexpected end")) {
        // The parser has no place for the end.
        text.trim_end().len()..text.trim_end().len()
    } else if let Some(end) = missing {
        end..end
    } else {
        start..end.max(start)
    };
    let what = match kind {
        CodeKind::Statements => "these are no statements",
        CodeKind::Items => "these are no items",
        CodeKind::Expression => "this is no expression",
        CodeKind::Type => "this is no type",
        CodeKind::TypeParameter => "this is no type parameter",
    };
    let is_end = missing.is_some();
    let message = if is_end {
        "this statement of Rust has no `;` at its end".to_owned()
    } else {
        format!("{what} of Rust: {message}")
    };
    let word = &text[range.clone()];
    let raw = raw(word);
    let hint = (raw != word && !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_lowercase()))
        .then(|| format!("`{word}` is a word of Rust; a port or an action of this name is written `{raw}`"));
    let hint = hint.or_else(|| is_end.then(|| "write `;` behind it".to_owned()));
    Some(CodeProblem { code: Code::CodeSyntax, range, message, also: None, hint })
}

/// Returns the end of the last token that ends at a byte or before it; comments are no tokens.
fn end_before(text: &str, byte: usize) -> Option<usize> {
    let mut last = None;
    let mut streams = vec![text.parse::<TokenStream>().ok()?];
    while let Some(stream) = streams.pop() {
        for token in stream {
            let ends = match token {
                TokenTree::Group(group) => {
                    streams.push(group.stream());
                    [group.span_open().end(), group.span_close().end()]
                }
                token => [token.span().end(); 2],
            };
            let ends = ends.map(|end| byte_of(text, end)).into_iter().filter(|end| *end <= byte);
            last = last.max(ends.max());
        }
    }
    last
}

pub(crate) fn byte_of(text: &str, place: LineColumn) -> usize {
    let start: usize = text.split_inclusive('\n').take(place.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[start..];
    start + rest.char_indices().nth(place.column).map_or(rest.len(), |(offset, _)| offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the place and the problem.
    fn found(text: &str, kind: CodeKind) -> Option<(usize, String)> {
        problem(text, kind).map(|problem| (problem.range.start, problem.message))
    }

    #[test]
    fn a_bracket_is_named_at_its_own_place() {
        for (text, at, message) in [
            ("f(1;", 1, "this `(` is not closed"),
            ("if a {\n  f([1);\n}", 11, "this `[` is not closed"),
            ("f(1));", 4, "this `)` closes nothing"),
            ("if a {\n}\n}", 9, "this `}` closes nothing"),
            ("f(1]", 3, "this `]` does not close `(`"),
            // The indentation shows that the second one is meant.
            ("\n  if a {\n    if b {\n      f();\n  }\n", 19, "this `{` is not closed"),
            ("\n  if a {\n    if b {\n    }\n", 8, "this `{` is not closed"),
            ("'(' \"(\" /* ( */ r#\"(\"# // (\n (", 29, "this `(` is not closed"),
        ] {
            assert_eq!(found(text, CodeKind::Statements), Some((at, message.to_owned())), "{text}");
        }
    }

    #[test]
    fn errors_of_the_parser_are_at_their_place() {
        let (at, message) = found("\n  é = 1 + ;", CodeKind::Statements).expect("it is wrong");
        assert_eq!(at, 12, "{message}");
        let (at, _) = found("1 + ", CodeKind::Expression).expect("it is wrong");
        assert_eq!(at, 3);
        assert!(found("fn f() {}\nlet a = 1;", CodeKind::Items).is_some_and(|(at, _)| at == 10));
        assert!(found("\n  let a = 1\n  let b = 2;", CodeKind::Statements).is_some_and(|(at, _)| at == 12));
        assert!(found("\n  é(1) // é\n\n  g(2);", CodeKind::Statements).is_some_and(|(at, _)| at == 8));
        let (at, message) = found("println!(\"a\")\nlet y = { 2 };", CodeKind::Statements).expect("it is wrong");
        assert_eq!((at, message.as_str()), (13, "this statement of Rust has no `;` at its end"));
        assert!(found(" Vec<u8 ", CodeKind::Type).is_some_and(|(at, _)| at == 7));
    }

    #[test]
    fn correct_code_has_no_problem() {
        for text in ["", " let a: &'static str = \"}\";\n a ", "if let Some(x) = y && x > 0 { } else { loop {} }"] {
            assert_eq!(found(text, CodeKind::Statements), None, "{text}");
        }
        assert_eq!(found("use a::b; payload! { struct X { y: u8 } }", CodeKind::Items), None);
        assert_eq!(found("[u8; 4]", CodeKind::Type), None);
    }
}
