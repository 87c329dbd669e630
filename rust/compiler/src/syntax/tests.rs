// SPDX-License-Identifier: Apache-2.0
//! The parser terminates without a panic for any text, and reads the whole grammar.

use proptest::prelude::*;

use super::parse;
use crate::diagnostics::{Diagnostics, FileId, Style};

/// A program with every construct of the grammar.
const WHOLE_GRAMMAR: &str = include_str!("../../tests/grammar.lf");

fn rendered(text: &str) -> String {
    let mut diagnostics = Diagnostics::default();
    let file = diagnostics.sources_mut().add("test.lf".into(), text.into());
    let (_, found) = parse(file, "Main.lf", text);
    diagnostics.extend(found);
    diagnostics.render(Style::Plain)
}

#[test]
fn the_whole_grammar_is_read() {
    assert_eq!(rendered(WHOLE_GRAMMAR), "");
}

#[test]
fn older_initialisers_are_read_with_a_warning() {
    let text = "reactor R(p: time(100 msec)) { state x:int(0); state y:i32{1} }";
    let found = rendered(text);
    assert_eq!(found.matches("warning[W001-old-initialiser]").count(), 3, "{found}");
    assert!(!found.contains("error"), "{found}");
}

#[test]
fn the_comment_before_a_reactor_documents_it() {
    let text = "reactor Q {} // not this\n/** One.\n  * Two. */\nreactor R {}\n// a\n// b\n@label(\"x\")\nreactor S {}
        \n\n// c\n\nreactor T {}";
    let (unit, _) = parse(FileId::default(), "Main.lf", text);
    let docs: Vec<_> = unit.reactors.iter().map(|reactor| reactor.docs.as_deref()).collect();
    assert_eq!(docs, [None, Some("One.\nTwo."), Some("a\nb"), None]);
}

#[test]
fn several_errors_are_found_in_one_go() {
    let text = "target Rust
        reactor A { input ; output x i32
        state = 3
        timer t(
        }
        main reactor { a = new ; b -> }
        reactor {";
    let found = rendered(text);
    assert!(found.matches("error[").count() >= 6, "{found}");
}

const WORDS: &[&str] = &[
    "target",
    "Rust",
    "reactor",
    "main",
    "federated",
    "realtime",
    "input",
    "output",
    "state",
    "timer",
    "logical",
    "physical",
    "action",
    "reaction",
    "mutation",
    "preamble",
    "private",
    "import",
    "from",
    "as",
    "new",
    "at",
    "after",
    "deadline",
    "STP",
    "tardy",
    "mode",
    "initial",
    "reset",
    "history",
    "watchdog",
    "method",
    "const",
    "interleaved",
    "extends",
    "serializer",
    "startup",
    "time",
    "forever",
    "x",
    "y",
    "10",
    "msec",
    "1.5",
    "\"s\"",
    "'c'",
    "{= code =}",
    "{=",
    "=}",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    "<",
    ">",
    "->",
    "~>",
    "::",
    ":",
    ";",
    ",",
    ".",
    "+",
    "-",
    "*",
    "=",
    "@",
    "%",
    "/",
    "\\",
    "//",
    "#",
    "/*",
    "*/",
    "'''",
    "\"\"\"",
    "\"",
    "'",
    "\n",
    "\n",
    "é",
    "\u{1F600}",
];

proptest! {
    #[test]
    fn any_text_ends_without_a_panic(text in any::<String>()) {
        rendered(&text);
    }

    #[test]
    fn any_bytes_end_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        rendered(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn any_tokens_end_without_a_panic(
        words in proptest::collection::vec(proptest::sample::select(WORDS), 0..120),
        separator in proptest::sample::select(&["", " "][..]),
    ) {
        rendered(&words.join(separator));
    }

    #[test]
    fn a_mutated_program_ends_without_a_panic(
        cuts in proptest::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..12, proptest::sample::select(WORDS)), 1..6
        ),
    ) {
        let mut text: Vec<char> = WHOLE_GRAMMAR.chars().collect();
        for (at, length, word) in cuts {
            let at = at.index(text.len());
            let end = (at + length).min(text.len());
            text.splice(at..end, word.chars());
        }
        rendered(&text.into_iter().collect::<String>());
    }
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    for (open, head) in [
        ("(", "reactor R(x = "),
        ("[", "target Rust { x: "),
        ("V<", "reactor R { state s: "),
        ("{", "reactor R { state s = "),
    ] {
        let found = rendered(&format!("{head}{}", open.repeat(20_000)));
        assert!(found.contains("E006-nesting-too-deep"), "{head}");
    }
}
