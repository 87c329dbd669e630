// SPDX-License-Identifier: Apache-2.0
//! Comments, messages and documents are plain sentences with a subject that acts.
//!
//! The refused phrases hide the actor or the number. The rule searches whole lines, because no code outside of comments
//! and strings has them. Docs of functions begin with a verb, those of types and fields with a noun, and no comment in
//! other languages than Rust begins with a question.

use super::finding::Finding;
use super::rules::contains_word;
use super::tree::{File, Tree};

/// Phrases that a sentence can do without, and what to write instead.
const PHRASES: &[(&str, &str)] = &[
    (concat!("so ", "many"), "the number, or `this many`"),
    (concat!("for ", "ever"), "`forever`, `without end`, or FOREVER for the tag"),
    (concat!("some", "body"), "the user, the thread or the participant that acts"),
    (concat!("who", "ever"), "the user, the thread or the participant that acts"),
    (concat!("in place", " of"), "`instead of`"),
    (concat!("that is of", " use"), "what it is for"),
];

/// The first words of docs that are questions, and of functions whose docs have the wrong verb.
const BEGINNINGS: &[&str] = &["Gives", "Who", "Whose", "What", "How"];

/// The first words of docs of functions that are no verbs.
const NO_VERBS: &[&str] =
    &["The", "A", "An", "All", "Those", "That", "Whether", "Where", "When", "Which", "Why", "If", "For", "From"];

/// Words that can stand before `fn`, beside the visibility.
const QUALIFIERS: &[&str] = &["const", "async", "unsafe", "safe", "extern", "\"C\"", "in"];

/// Checks sources, settings and documents.
pub(super) fn plain(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in tree.files.iter().filter(|file| is_checked(file)) {
        let lines: Vec<&str> = file.text.iter().flat_map(|text| text.lines()).collect();
        let mut before = "";
        for (index, line) in lines.iter().enumerate() {
            let what = phrase(line).or_else(|| beginning(file, line, before, &lines[index + 1..]));
            findings.extend(what.map(|what| Finding { place: format!("{}:{}", file.path, index + 1), what }));
            before = line;
        }
    }
    findings
}

fn is_checked(file: &File) -> bool {
    !signs(file).is_empty() || file.kind() == "md"
}

/// Returns the signs that begin a comment whose first word is checked, of which in Rust only docs.
fn signs(file: &File) -> &'static [&'static str] {
    match file.kind() {
        "rs" => &["/// ", "//! "],
        "c" | "h" | "lf" | "ts" | "mjs" | "cjs" | "js" => &["/// ", "//! ", "// ", "/** ", "/* "],
        "py" => &["# ", "\"\"\""],
        "toml" | "cmake" | "conf" | "yaml" | "yml" | "sh" | "Kconfig" | "editorconfig" => &["# "],
        _ if file.path.ends_with("CMakeLists.txt") => &["# "],
        _ => &[],
    }
}

/// Returns the finding about the first refused phrase in a text.
fn phrase(text: &str) -> Option<String> {
    let text = text.to_lowercase();
    let (phrase, instead) = PHRASES.iter().find(|(phrase, _)| contains_word(&text, phrase))?;
    Some(format!("`{phrase}`: write {instead}"))
}

/// Returns the finding about the first word of a comment, given the line before it and the lines behind it.
fn beginning(file: &File, line: &str, before: &str, behind: &[&str]) -> Option<String> {
    let prefix = signs(file).iter().find(|sign| line.trim_start().starts_with(**sign))?;
    if before.trim_start().starts_with(prefix.trim_end()) && !before.contains("SPDX") {
        return None;
    }
    let word = line.trim_start()[prefix.len()..].split(' ').next()?;
    let is_refused = BEGINNINGS.contains(&word) || *prefix == "/// " && NO_VERBS.contains(&word) && is_function(behind);
    is_refused.then(|| format!("a comment begins with `{word}`: begin with a verb (functions) or a noun"))
}

/// Returns whether these lines, which can begin with docs and attributes, declare a function that is no test. The docs
/// of tests are statements about the program.
fn is_function(lines: &[&str]) -> bool {
    let is_before = |line: &&&str| ["///", "#["].iter().any(|sign| line.trim_start().starts_with(sign));
    let count = lines.iter().take_while(is_before).count();
    let mut words = lines.get(count).copied().unwrap_or_default().split_whitespace();
    let is_declared = words.find(|word| !word.starts_with("pub") && !QUALIFIERS.contains(word)) == Some("fn");
    is_declared && !lines[..count].iter().any(|line| line.trim_start().starts_with("#[test]"))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn found(path: &str, text: &str) -> usize {
        let file = File { path: path.to_owned(), size: text.len() as u64, text: Some(text.to_owned()) };
        plain(&Tree { root: PathBuf::new(), files: vec![file] }).len()
    }

    #[test]
    fn phrases_are_found_in_comments_messages_and_documents() {
        for (phrase, _) in PHRASES {
            let sentence = format!("It waits {phrase} federates.");
            assert_eq!(found("rust/x/src/a.rs", &format!("fn a() {{}} // {sentence}\n")), 1, "{phrase}");
            assert_eq!(found("rust/x/src/a.rs", &format!("let text = \"{sentence}\";\n")), 1, "{phrase}");
            assert_eq!(found("docs/a.md", &sentence), 1, "{phrase}");
            assert_eq!(found("zephyr/src/a.c", &format!("/* {sentence}\n * {sentence} */\n")), 2, "{phrase}");
            for path in ["a.lf", "a.py", "a.toml", "a.cmake", "a/CMakeLists.txt", "a.conf", "a/Kconfig", "a.ts"] {
                assert_eq!(found(path, &sentence), 1, "{path}");
            }
            assert_eq!(found("a.json", &sentence), 0);
        }
    }

    #[test]
    fn the_first_word_of_comments_is_checked_in_all_languages() {
        for (path, sign) in [
            ("a.lf", "//"),
            ("a.lf", "    ///"),
            ("a.lf", "/**"),
            ("a.ts", "/**"),
            ("a.c", "/*"),
            ("a.py", "    #"),
            ("a.toml", "#"),
            ("a.cmake", "#"),
            ("a/CMakeLists.txt", "#"),
            ("a.conf", "#"),
            ("a/Kconfig", "#"),
        ] {
            assert_eq!(found(path, &format!("{sign} What it waits for.\n")), 1, "{path}");
            assert_eq!(found(path, &format!("{sign} The tag.\n")), 0, "{path}");
        }
        assert_eq!(found("a.py", "def a() -> None:\n    \"\"\"How it waits.\"\"\"\n"), 1);
        assert_eq!(found("a.py", "# SPDX-License-Identifier: Apache-2.0\n# What it is.\n"), 1);
        assert_eq!(found("a.py", "# It says\n# What it is.\n"), 0);
        assert_eq!(found("rust/x/src/a.rs", "// What has come is handled.\n"), 0);
    }

    #[test]
    fn the_first_word_of_docs_is_checked() {
        let docs = |word: &str| format!("/// {word} the tag.\nfn a() {{}}\n");
        assert_eq!(
            BEGINNINGS.iter().map(|word| found("rust/x/src/a.rs", &docs(word))).sum::<usize>(),
            BEGINNINGS.len()
        );
        assert_eq!(NO_VERBS.iter().map(|word| found("rust/x/src/a.rs", &docs(word))).sum::<usize>(), NO_VERBS.len());
        assert_eq!(found("rust/x/src/a.rs", &docs("Returns")), 0);
        assert_eq!(found("rust/x/src/a.rs", "/// The tag.\n#[must_use]\npub(crate) const fn a() {}\n"), 1);
        assert_eq!(found("rust/x/src/a.rs", "/// The tag.\nconst A: u8 = 0;\n"), 0);
        assert_eq!(found("rust/x/src/a.rs", "/// The tag is kept.\n#[test]\nfn a() {}\n"), 0);
        assert_eq!(found("rust/x/src/a.rs", "/// Returns\n/// What it is.\nfn a() {}\n"), 0);
    }
}
