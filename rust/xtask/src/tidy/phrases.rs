// SPDX-License-Identifier: Apache-2.0
//! Comments and documents are plain sentences with a subject that acts.
//!
//! The refused phrases hide the actor or the number. Docs of functions begin with a verb, those of types and fields
//! with a noun.

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

/// Checks the comments of sources, and the documents.
pub(super) fn plain(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in tree.files.iter().filter(|file| is_checked(file)) {
        let lines: Vec<&str> = file.text.iter().flat_map(|text| text.lines()).collect();
        let mut before = "";
        for (index, line) in lines.iter().enumerate() {
            let what = comment(file, line).and_then(phrase).or_else(|| beginning(line, before, &lines[index + 1..]));
            findings.extend(what.map(|what| Finding { place: format!("{}:{}", file.path, index + 1), what }));
            before = line;
        }
    }
    findings
}

fn is_checked(file: &File) -> bool {
    matches!(file.kind(), "rs" | "c" | "h" | "md")
}

/// Returns the part of a line that is prose: a comment, or all of a document.
fn comment<'l>(file: &File, line: &'l str) -> Option<&'l str> {
    let is_c = matches!(file.kind(), "c" | "h");
    let signs: &[&str] = if is_c { &["//", "/*"] } else { &["//"] };
    let begins = signs.iter().find_map(|sign| line.split_once(sign)).map(|(_, text)| text);
    let goes_on = is_c && line.trim_start().starts_with("* ");
    if file.kind() == "md" || goes_on { Some(line) } else { begins }
}

/// Returns the finding about the first refused phrase in a text.
fn phrase(text: &str) -> Option<String> {
    let text = text.to_lowercase();
    let (phrase, instead) = PHRASES.iter().find(|(phrase, _)| contains_word(&text, phrase))?;
    Some(format!("`{phrase}`: write {instead}"))
}

/// Returns the finding about the first word of a doc comment, given the line before it and the lines behind it.
fn beginning(line: &str, before: &str, behind: &[&str]) -> Option<String> {
    let prefix = ["/// ", "//! "].into_iter().find(|prefix| line.trim_start().starts_with(prefix))?;
    if before.trim_start().starts_with(prefix.trim_end()) {
        return None;
    }
    let word = line.trim_start()[prefix.len()..].split(' ').next()?;
    let is_refused = BEGINNINGS.contains(&word) || prefix == "/// " && NO_VERBS.contains(&word) && is_function(behind);
    is_refused.then(|| format!("docs begin with `{word}`: begin with a verb (functions) or a noun"))
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
    fn phrases_are_found_in_comments_and_documents() {
        for (phrase, _) in PHRASES {
            let sentence = format!("It waits {phrase} federates.");
            assert_eq!(found("rust/x/src/a.rs", &format!("fn a() {{}} // {sentence}\n")), 1, "{phrase}");
            assert_eq!(found("docs/a.md", &sentence), 1, "{phrase}");
            assert_eq!(found("zephyr/src/a.c", &format!("/* {sentence}\n * {sentence} */\n")), 2, "{phrase}");
            assert_eq!(found("rust/x/src/a.rs", &format!("let text = \"{sentence}\";\n")), 0, "{phrase}");
        }
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
