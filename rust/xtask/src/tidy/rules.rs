// SPDX-License-Identifier: Apache-2.0
//! The rules about single files.

use super::finding::Finding;
use super::tree::{File, Tree};

/// A source file of more lines is more than one thing.
const FILE_LINES_MAX: usize = 600;
/// In characters.
const LINE_LENGTH_MAX: usize = 120;
/// In bytes; recordings and the lock file are larger than any source.
const FILE_SIZE_MAX: u64 = 512 * 1024;
/// The last line of the licence header: below a `#!` line and a document marker.
const HEADER_LINES: usize = 3;

/// Marks of unfinished work, put together here so that this file does not contain them.
const UNFINISHED: &[&str] = &[
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("to", "do!("),
    concat!("unimple", "mented!("),
    concat!("db", "g!("),
    concat!("#[ig", "nore"),
    concat!("pytest.mark.", "skip"),
    concat!("/wo", "rk/"),
    concat!("/ro", "ot/"),
];

pub(super) fn file_sizes(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in &tree.files {
        let lines = file.text.as_ref().map_or(0, |text| text.lines().count());
        if is_source(file) && lines > FILE_LINES_MAX {
            let what = format!("{lines} lines, more than {FILE_LINES_MAX}; split it by topic");
            findings.push(Finding { place: file.path.clone(), what });
        }
    }
    findings
}

pub(super) fn line_lengths(tree: &Tree) -> Vec<Finding> {
    lines(tree, is_source, |line| {
        let length = line.chars().count();
        // An address cannot be broken.
        (length > LINE_LENGTH_MAX && !line.contains("https://"))
            .then(|| format!("{length} characters, more than {LINE_LENGTH_MAX}"))
    })
}

pub(super) fn licence_headers(tree: &Tree) -> Vec<Finding> {
    let header = concat!("SPDX-License-", "Identifier: Apache-2.0");
    let has_header = |text: &String| text.lines().take(HEADER_LINES).any(|line| line.contains(header));
    let bare = tree.files.iter().filter(|file| needs_header(file) && !file.text.as_ref().is_some_and(has_header));
    bare.map(|file| Finding { place: file.path.clone(), what: format!("the first line is not `{header}`") }).collect()
}

pub(super) fn unfinished_work(tree: &Tree) -> Vec<Finding> {
    lines(tree, is_source, |line| {
        let mark = UNFINISHED.iter().find(|mark| contains_word(line, mark))?;
        Some(format!("`{mark}` does not belong in a finished file"))
    })
}

pub(super) fn waiting_in_tests(tree: &Tree) -> Vec<Finding> {
    let is_test = |file: &File| is_source(file) && format!("/{}", file.path).contains("/tests/");
    let is_wait =
        |line: &str| line.contains(concat!("thread::", "sleep(")) || line.contains(concat!("time.", "sleep("));
    lines(tree, is_test, |line| is_wait(line).then(|| "a test waits for an event, not for a time".to_owned()))
}

/// Checks that code which several crates share is a crate: no module is a file of another one.
pub(super) fn modules_of_others(tree: &Tree) -> Vec<Finding> {
    let is_rust = |file: &File| file.kind() == "rs";
    let names_file = |line: &str| ["#[path =", "include!(\""].iter().any(|start| line.trim_start().starts_with(start));
    lines(tree, is_rust, |line| {
        let is_elsewhere = names_file(line) && line.contains("../");
        is_elsewhere.then(|| "a file that is not below this one; share it by a crate, as rust/testkit".to_owned())
    })
}

pub(super) fn stray_files(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in &tree.files {
        let parts: Vec<&str> = file.path.split('/').collect();
        let generated = parts.iter().any(|part| matches!(*part, "build" | "target" | "twister-out"))
            || matches!(file.kind(), "o" | "a" | "elf" | "so" | "new" | "orig" | "rej");
        if generated {
            let what = "a generated file; it belongs into a build folder that git ignores".to_owned();
            findings.push(Finding { place: file.path.clone(), what });
        } else if file.size > FILE_SIZE_MAX {
            let what = format!("{} bytes, more than {FILE_SIZE_MAX}", file.size);
            findings.push(Finding { place: file.path.clone(), what });
        }
    }
    findings
}

/// Applies a check to each line of the files that are chosen.
fn lines(tree: &Tree, chosen: impl Fn(&File) -> bool, check: impl Fn(&str) -> Option<String>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in tree.files.iter().filter(|file| chosen(file)) {
        for (index, line) in file.text.iter().flat_map(|text| text.lines()).enumerate() {
            if let Some(what) = check(line) {
                findings.push(Finding { place: format!("{}:{}", file.path, index + 1), what });
            }
        }
    }
    findings
}

fn is_source(file: &File) -> bool {
    matches!(file.kind(), "rs" | "py" | "c" | "h" | "sh" | "cmake" | "ts" | "mjs") || file.path == ".ci/run"
}

fn needs_header(file: &File) -> bool {
    is_source(file)
        || matches!(file.kind(), "toml" | "yaml" | "yml" | "conf" | "overlay" | "Kconfig")
        || file.path.ends_with("CMakeLists.txt")
}

/// Returns whether a mark occurs that is not part of a longer word.
pub(super) fn contains_word(line: &str, mark: &str) -> bool {
    line.match_indices(mark).any(|(start, _)| {
        let before = line[..start].chars().next_back();
        let after = line[start + mark.len()..].chars().next();
        let is_word = |character: Option<char>| character.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let open_end = mark.ends_with(|c: char| !c.is_alphanumeric());
        !is_word(before) && (open_end || !is_word(after))
    })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::{File, Tree};
    use super::{
        contains_word, file_sizes, licence_headers, line_lengths, modules_of_others, stray_files, unfinished_work,
        waiting_in_tests,
    };

    fn tree(path: &str, text: &str) -> Tree {
        let file = File { path: path.to_owned(), size: text.len() as u64, text: Some(text.to_owned()) };
        Tree { root: PathBuf::new(), files: vec![file] }
    }

    #[test]
    fn a_module_of_another_crate_is_found() {
        assert_eq!(modules_of_others(&tree("a.rs", "#[path = \"../../b/world.rs\"]\nmod world;\n")).len(), 1);
        assert_eq!(modules_of_others(&tree("a.rs", "  include!(\"../b.rs\");\n")).len(), 1);
        assert_eq!(modules_of_others(&tree("a.rs", "#[path = \"world/mod.rs\"]\nmod world;\n")), []);
    }

    #[test]
    fn a_long_file_and_a_long_line_are_found() {
        assert_eq!(file_sizes(&tree("a.rs", &"x\n".repeat(601))).len(), 1);
        assert_eq!(file_sizes(&tree("a.rs", &"x\n".repeat(600))), []);
        let findings = line_lengths(&tree("a.rs", &format!("x\n{}", "é".repeat(121))));
        assert_eq!(findings[0].place, "a.rs:2");
        assert_eq!(line_lengths(&tree("a.rs", &"é".repeat(120))), []);
        assert_eq!(line_lengths(&tree("a.md", &"x".repeat(500))), []);
    }

    #[test]
    fn a_missing_header_is_found() {
        assert_eq!(licence_headers(&tree("a.py", "import os\n")).len(), 1);
        assert_eq!(
            licence_headers(&tree("a.py", "#!/usr/bin/env python3\n# SPDX-License-Identifier: Apache-2.0\n")),
            []
        );
        assert_eq!(licence_headers(&tree("notes.md", "words\n")), []);
    }

    #[test]
    fn marks_of_unfinished_work_are_found_as_words() {
        assert_eq!(unfinished_work(&tree("a.rs", concat!("// TO", "DO: later"))).len(), 1);
        assert!(!contains_word("MASTODON", concat!("TO", "DO")));
        assert!(contains_word(concat!("x = to", "do!(\"y\")"), concat!("to", "do!(")));
    }

    #[test]
    fn waiting_is_found_in_tests_only() {
        let text = concat!("std::thread::", "sleep(second);");
        assert_eq!(waiting_in_tests(&tree("rust/x/tests/a.rs", text)).len(), 1);
        assert_eq!(waiting_in_tests(&tree("rust/x/src/a.rs", text)), []);
    }

    #[test]
    fn generated_files_are_found() {
        assert_eq!(stray_files(&tree("applications/a/build/lfz/x.rs", "")).len(), 1);
        assert_eq!(stray_files(&tree("rust/x/src/a.rs.orig", "")).len(), 1);
        assert_eq!(stray_files(&tree("Cargo.lock", "")), []);
    }
}
