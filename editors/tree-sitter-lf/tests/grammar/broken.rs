// SPDX-License-Identifier: Apache-2.0
//! Programs while they are written.

use lf_compiler::syntax::{LexemeKind, lexemes};
use tree_sitter::{InputEdit, Point};

use super::{codes, nodes, parse, parser, read};

/// A program with everything that the language has.
const WHOLE_GRAMMAR: &str = "rust/compiler/tests/grammar.lf";

#[test]
fn without_any_one_token_all_other_code_is_still_code() {
    let text = read(WHOLE_GRAMMAR);
    let whole: Vec<String> = codes(&parse(&text)).into_iter().map(|place| text[place].to_owned()).collect();
    // Quotes and the marks of code and comments decide where these end.
    let deciding = [LexemeKind::Code, LexemeKind::Comment, LexemeKind::Text];
    for token in lexemes(&text).iter().filter(|token| !deciding.contains(&token.kind)) {
        let broken = format!("{}{}", &text[..token.start], &text[token.end..]);
        let found: Vec<&str> = codes(&parse(&broken)).into_iter().map(|place| &broken[place]).collect();
        assert_eq!(found, whole, "without `{}` at byte {}", &text[token.start..token.end], token.start);
    }
}

#[test]
fn a_text_that_ends_too_early_has_all_reactors_before_its_end() {
    let text = read(WHOLE_GRAMMAR);
    let tree = parse(&text);
    let complete: Vec<_> = nodes(&tree).into_iter().filter(|node| node.kind() == "reactor").collect();
    assert!(complete.len() > 2, "the program has several reactors");
    for token in lexemes(&text) {
        let tree = parse(&text[..token.end]);
        let found = nodes(&tree);
        for reactor in complete.iter().filter(|reactor| reactor.end_byte() <= token.end) {
            let is_there = found.iter().any(|node| node.kind() == "reactor" && node.range() == reactor.range());
            assert!(is_there, "the reactor in line {} of {} bytes", reactor.start_position().row + 1, token.end);
        }
    }
}

#[test]
fn code_without_an_end_takes_no_code_of_the_next_line_that_begins_with_one() {
    for (target, string) in [("Rust", "\"open"), ("C", "\"open"), ("C", "'o"), ("Rust", "/* open")] {
        let text = format!("target {target}\nreactor {{\n  reaction(a) {{=\n    {string}\n  =}}\n  timer t\n}}\n");
        let tree = parse(&text);
        assert!(nodes(&tree).iter().any(|node| node.kind() == "timer"), "{text}");
    }
}

#[test]
fn another_target_changes_the_language_of_code_that_was_read_before() {
    let text = "target Rust\nreactor A {\n  reaction(startup) {= a =}\n}\n";
    let mut tree = parse(text);
    let at = "target ".len();
    let end = at + "Rust".len();
    tree.edit(&InputEdit {
        start_byte: at,
        old_end_byte: end,
        new_end_byte: at + 1,
        start_position: Point::new(0, at),
        old_end_position: Point::new(0, end),
        new_end_position: Point::new(0, at + 1),
    });
    let changed = format!("{}C{}", &text[..at], &text[end..]);
    let tree = parser().parse(&changed, Some(&tree)).expect("each text has a tree");
    assert!(nodes(&tree).iter().any(|node| node.kind() == "c_code"));
}
