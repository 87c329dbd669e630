// SPDX-License-Identifier: Apache-2.0
//! The queries, in which each file is for another purpose of editors.

use std::fs;

use tree_sitter::{Query, QueryCursor, StreamingIterator};

use super::{language, parse};

/// Returns a query by the name of its file.
pub(crate) fn query(name: &str) -> Query {
    let path = format!("{}/queries/{name}.scm", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    Query::new(&language(), &text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn every_query_is_one_of_this_grammar() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/queries");
    let mut names = 0;
    for entry in fs::read_dir(folder).expect("the queries are there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        query(name.strip_suffix(".scm").expect("only queries are there"));
        names += 1;
    }
    assert_eq!(names, 7);
}

/// Returns the languages of code in a text, in its order.
fn injected(text: &str) -> Vec<String> {
    let (tree, query) = (parse(text), query("injections"));
    let mut cursor = QueryCursor::new();
    let mut matches = cursor.matches(&query, tree.root_node(), text.as_bytes());
    let mut all = Vec::new();
    while let Some(one) = matches.next() {
        let settings = query.property_settings(one.pattern_index);
        let language = settings.iter().find(|setting| &*setting.key == "injection.language");
        let language = language.and_then(|setting| setting.value.as_deref()).expect("each injection has a language");
        if one.captures[0].node.kind().ends_with("_code") {
            all.push(language.to_owned());
        }
    }
    all
}

#[test]
fn the_target_chooses_the_language_of_code() {
    for (target, expected) in [
        ("target Rust", &["rust"][..]),
        ("target rust { timeout: 1 s }", &["rust"]),
        ("target C", &["c"]),
        ("target uC;", &["c"]),
        ("target CCpp", &["cpp"]),
        ("target /* not Rust */ Cpp", &["cpp"]),
        ("target Python", &[]),
        ("", &["rust"]),
    ] {
        assert_eq!(injected(&format!("{target}\nreactor A {{\n  reaction(x) {{= y =}}\n}}")), expected, "{target}");
    }
}
