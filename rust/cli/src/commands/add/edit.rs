// SPDX-License-Identifier: Apache-2.0
//! Adds an entry to `cargo-dependencies` in the text of a program, whose other characters stay as they are.

use std::ops::Range;

use lf_compiler::parse;
use lf_compiler::syntax::ast::{Property, PropertyKind, SourceUnit};

use crate::failure::Failure;
use crate::terminal;

/// The target property with the crates.
const CRATES: &str = "cargo-dependencies";

/// An entry of `cargo-dependencies`.
pub(super) struct Dependency {
    pub(super) name: String,
    pub(super) value: String,
}

/// Returns the text with a dependency, which replaces one with its name.
///
/// # Errors
/// When the text has errors, or its target has no crates; the user has seen those of the text.
pub(super) fn with_dependency(path: &str, text: &str, dependency: &Dependency) -> Result<String, Failure> {
    let tree = parse(path, text);
    if tree.diagnostics.has_errors() {
        terminal::report(tree.diagnostics.render(terminal::style()));
        return Err(Failure::message(format!("{path} has errors, so it stays as it is")));
    }
    let refused = |reason: &str| Failure::message(format!("{path} {reason}, so it stays as it is"));
    let Some(target) = &tree.unit.target else { return Err(refused("has no target declaration")) };
    if target.name.text != "Rust" {
        return Err(refused("has bodies in another language than Rust, which have no crates"));
    }
    let edited = edited(text, &tree.unit, dependency).ok_or_else(|| refused("is written in an unusual way"))?;
    // A mistake here would be one in the user's file.
    let again = parse(path, &edited);
    let found = again.unit.target.as_ref().and_then(|target| crates(&target.properties));
    let is_there = found.is_some_and(|crates| crates.iter().any(|property| property.key.text == dependency.name));
    if again.diagnostics.has_errors() || !is_there {
        let Dependency { name, value } = dependency;
        let line = format!("write `{CRATES}: {{ {name}: {value} }}` into its target declaration");
        return Err(refused(&format!("is written in an unusual way: {line}")));
    }
    Ok(edited)
}

/// Returns the entries of `cargo-dependencies`.
fn crates(properties: &[Property]) -> Option<&[Property]> {
    let property = properties.iter().find(|property| property.key.text == CRATES)?;
    match &property.value.kind {
        PropertyKind::Map(crates) => Some(crates),
        _ => None,
    }
}

fn edited(text: &str, unit: &SourceUnit, Dependency { name, value }: &Dependency) -> Option<String> {
    let target = unit.target.as_ref()?;
    let entry = format!("{name}: {value}");
    let property = target.properties.iter().find(|property| property.key.text == CRATES);
    if let Some(property) = property {
        let PropertyKind::Map(crates) = &property.value.kind else { return None };
        if let Some(known) = crates.iter().find(|known| known.key.text == *name) {
            return Some(replaced(text, known.value.span.start..known.value.span.end, value));
        }
        return match crates.last() {
            Some(last) => Some(inserted(text, unit, last, &entry)),
            None => Some(replaced(text, property.value.span.start..property.value.span.end, &format!("{{ {entry} }}"))),
        };
    }
    let property = format!("{CRATES}: {{ {entry} }}");
    if let Some(last) = target.properties.last() {
        return Some(inserted(text, unit, last, &property));
    }
    let indentation = indentation(text);
    let block = format!("{{\n{indentation}{property}\n}}");
    let end = target.name.span.end;
    let open = code_from(text, &unit.comments, end);
    if text[open..].starts_with('{') {
        let close = code_from(text, &unit.comments, open + 1);
        return text[close..].starts_with('}').then(|| replaced(text, open..close + 1, &block));
    }
    Some(replaced(text, end..end, &format!(" {block}")))
}

fn replaced(text: &str, range: Range<usize>, new: &str) -> String {
    format!("{}{new}{}", &text[..range.start], &text[range.end..])
}

/// Returns the text with an entry behind the last one of a list: on a line of its own if the closing brace is on one.
fn inserted(text: &str, unit: &SourceUnit, last: &Property, entry: &str) -> String {
    let end = last.value.span.end;
    let comma = Some(code_from(text, &unit.comments, end)).filter(|at| text[*at..].starts_with(','));
    let close = code_from(text, &unit.comments, comma.map_or(end, |comma| comma + 1));
    if !text[end..close].contains('\n') {
        return replaced(text, end..end, &format!(", {entry}"));
    }
    // A comment on the line of the last entry stays there.
    let mut line_end = comma.map_or(end, |comma| comma + 1);
    while let Some(more) = text[line_end..].find('\n') {
        line_end += more;
        match unit.comments.iter().find(|comment| comment.start < line_end && line_end < comment.end) {
            Some(comment) => line_end = comment.end,
            None => break,
        }
    }
    let key = last.key.span.start;
    let line_start = text[..key].rfind('\n').map_or(0, |at| at + 1);
    let line = &text[line_start..key];
    let indentation = &line[..line.len() - line.trim_start().len()];
    let (own, others) = if comma.is_some() { (",", "") } else { ("", ",") };
    let (begin, middle, rest) = (&text[..end], &text[end..line_end], &text[line_end..]);
    format!("{begin}{others}{middle}\n{indentation}{entry}{own}{rest}")
}

/// Returns the position of the first character that is neither blank nor in a comment.
fn code_from(text: &str, comments: &[Range<usize>], from: usize) -> usize {
    let mut at = from;
    loop {
        at += text[at..].len() - text[at..].trim_start().len();
        match comments.iter().find(|comment| comment.start <= at && at < comment.end) {
            Some(comment) => at = comment.end,
            None => return at,
        }
    }
}

/// Returns the blanks before the first indented line.
fn indentation(text: &str) -> &str {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let line = lines.find(|line| line.starts_with([' ', '\t']));
    line.map_or("  ", |line| &line[..line.len() - line.trim_start().len()])
}

#[cfg(test)]
mod tests {
    use super::{Dependency, with_dependency};

    fn added(text: &str) -> String {
        let dependency = Dependency { name: "libm".to_owned(), value: "\"0.2\"".to_owned() };
        let edited = with_dependency("P.lf", text, &dependency).expect("it has no errors");
        let again = with_dependency("P.lf", &edited, &dependency).expect("it has no errors");
        assert_eq!(again, edited, "a second time changes nothing");
        edited
    }

    #[test]
    fn a_crate_is_added_in_the_style_of_the_file() {
        let rest = "\nmain reactor {\n    timer t\n}\n";
        for (before, after) in [
            ("target Rust", "target Rust {\n    cargo-dependencies: { libm: \"0.2\" }\n}"),
            ("target Rust; // first", "target Rust {\n    cargo-dependencies: { libm: \"0.2\" }\n}; // first"),
            ("target Rust {}", "target Rust {\n    cargo-dependencies: { libm: \"0.2\" }\n}"),
            ("target Rust { timeout: 1 s }", "target Rust { timeout: 1 s, cargo-dependencies: { libm: \"0.2\" } }"),
            (
                "target Rust {\n  timeout: 1 s, // short\n  /* more */\n}",
                "target Rust {\n  timeout: 1 s, // short\n  cargo-dependencies: { libm: \"0.2\" },\n  /* more */\n}",
            ),
            (
                "target Rust {\n  timeout: 1 s /* a\n b */\n}",
                "target Rust {\n  timeout: 1 s, /* a\n b */\n  cargo-dependencies: { libm: \"0.2\" }\n}",
            ),
            (
                "target Rust { cargo-dependencies: { a: \"1\", } }",
                "target Rust { cargo-dependencies: { a: \"1\", libm: \"0.2\", } }",
            ),
            ("target Rust { cargo-dependencies: {} }", "target Rust { cargo-dependencies: { libm: \"0.2\" } }"),
            (
                "target Rust {\n  cargo-dependencies: {\n    a: { path: \"a\" }\n  }\n}",
                "target Rust {\n  cargo-dependencies: {\n    a: { path: \"a\" },\n    libm: \"0.2\"\n  }\n}",
            ),
            (
                "target Rust { cargo-dependencies: { libm: { version: \"0.1\" } /* old */ } }",
                "target Rust { cargo-dependencies: { libm: \"0.2\" /* old */ } }",
            ),
        ] {
            assert_eq!(added(&format!("{before}{rest}")), format!("{after}{rest}"));
        }
    }

    #[test]
    fn files_with_errors_and_other_targets_stay_as_they_are() {
        for text in ["", "target Rust {", "target C\nmain reactor {\n}\n", "reactor A {\n}\n"] {
            let dependency = Dependency { name: "libm".to_owned(), value: "\"0.2\"".to_owned() };
            assert!(with_dependency("P.lf", text, &dependency).is_err(), "{text}");
        }
    }
}
