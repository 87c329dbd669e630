// SPDX-License-Identifier: Apache-2.0
//! The tree of a program with everything that the language has.

use std::fmt::Write;

use tree_sitter::TreeCursor;

use super::{parse, read};

/// Adds the named nodes at the cursor and below, each with its field and, without children, its text.
fn render(cursor: &mut TreeCursor<'_>, text: &str, depth: usize, out: &mut String) {
    loop {
        let node = cursor.node();
        if node.is_named() {
            let field = cursor.field_name().map(|name| format!("{name}: ")).unwrap_or_default();
            let leaf = match node.named_child_count() {
                0 => format!(" {:?}", &text[node.byte_range()]),
                _ => String::new(),
            };
            writeln!(out, "{:width$}{field}{}{leaf}", "", node.kind(), width = 2 * depth).expect("strings grow");
            if cursor.goto_first_child() {
                render(cursor, text, depth + 1, out);
                cursor.goto_parent();
            }
        }
        if !cursor.goto_next_sibling() {
            return;
        }
    }
}

#[test]
fn the_tree_of_the_whole_grammar() {
    let text = read("rust/compiler/tests/grammar.lf");
    let (tree, mut out) = (parse(&text), String::new());
    render(&mut tree.walk(), &text, 0, &mut out);
    insta::assert_snapshot!(out);
}
