// SPDX-License-Identifier: Apache-2.0
//! The colours of a sample, beside those of the grammar for VS Code.

use tree_sitter::{QueryCursor, StreamingIterator};

use super::{parse, queries, read};

/// Names of tokens in VS Code's grammar, and those in the queries; the longer ones come first.
const NAMES: [(&str, &str); 23] = [
    ("comment.block.documentation", "comment.block.documentation"),
    ("comment.block", "comment.block"),
    ("comment.line", "comment.line"),
    ("constant.language", "constant.builtin"),
    ("constant.numeric", "constant.numeric"),
    ("constant.other", "constant"),
    ("entity.name.class", "type"),
    ("entity.name.function.decorator", "attribute"),
    ("entity.name.function", "function"),
    ("entity.name.namespace", "type.enum.variant"),
    ("entity.name.type", "type"),
    ("entity.other.inherited-class", "type"),
    ("keyword.control", "keyword.control"),
    ("keyword.operator.new", "keyword.operator"),
    ("keyword.operator", "operator"),
    ("keyword.other.unit", "keyword"),
    ("punctuation.definition.decorator", "attribute"),
    ("punctuation", "punctuation"),
    ("storage", "keyword.storage"),
    ("string", "string"),
    ("support.type.property-name", "variable.other.member"),
    ("support.type", "type.builtin"),
    ("variable.language", "variable.builtin"),
];

/// Returns the name of each byte: that of the innermost node, and of several names the last one, as editors do it.
fn colours(text: &str) -> Vec<Option<String>> {
    let (tree, query) = (parse(text), queries::query("highlights"));
    let mut cursor = QueryCursor::new();
    let mut captures = cursor.captures(&query, tree.root_node(), text.as_bytes());
    let mut all = Vec::new();
    while let Some((one, at)) = captures.next() {
        let capture = one.captures[*at];
        all.push((capture.node.byte_range(), one.pattern_index, query.capture_names()[capture.index as usize]));
    }
    all.sort_by_key(|(range, pattern, _)| (std::cmp::Reverse(range.len()), *pattern));
    let mut colours = vec![None; text.len()];
    for (range, _, name) in all {
        colours[range].fill(Some(name.to_owned()));
    }
    colours
}

#[test]
fn a_sample_has_the_colours_of_the_grammar_for_vs_code() {
    let sample = read("editors/vscode/tests/sample.lf");
    let snapshot = read("editors/vscode/tests/sample.snap");
    let colours = colours(&sample);
    let (mut at, mut compared) = (0, 0);
    for line in snapshot.lines() {
        let (token, scopes) = line.rsplit_once("  ").expect("two blanks are before the names");
        at += sample[at..].find(token).unwrap_or_else(|| panic!("{token} is not in the sample"));
        let scope = scopes.split(' ').next_back().unwrap_or_default();
        let is_code = scopes.contains("meta.embedded");
        // VS Code's grammar takes a host's port for a number.
        if !scope.is_empty() && !scope.starts_with("meta") && !is_code && !sample[..at].ends_with("localhost:") {
            let known = NAMES.iter().find(|(name, _)| scope.starts_with(name));
            let (_, wanted) = known.unwrap_or_else(|| panic!("{scope} has no counterpart"));
            let found = colours[at].as_deref().unwrap_or("nothing");
            let is_same = found.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
            assert!(is_same, "`{token}` at byte {at} is {found}, and {wanted} in VS Code ({scope})");
            compared += 1;
        }
        at += token.len();
    }
    assert!(compared > 100, "the sample has only {compared} names");
}
