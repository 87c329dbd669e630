// SPDX-License-Identifier: Apache-2.0
//! The documents must name paths that exist.

use super::Finding;
use super::tree::Tree;

/// The documents that describe the repository.
const DOCUMENTS: &[&str] = &["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md"];

/// Checks every path in backquotes that begins with a folder of the repository, and every relative link.
pub(super) fn paths_exist(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for name in DOCUMENTS {
        let Some(text) = tree.files.iter().find(|file| file.path == *name).and_then(|file| file.text.as_ref()) else {
            findings.push(Finding { place: (*name).to_owned(), what: "is missing".to_owned() });
            continue;
        };
        for (index, line) in text.lines().enumerate() {
            for path in quoted(line).chain(links(line)).filter(|path| names_a_file(tree, path)) {
                if !tree.root.join(path).exists() {
                    let place = format!("{name}:{}", index + 1);
                    findings.push(Finding { place, what: format!("names `{path}`, which does not exist") });
                }
            }
        }
    }
    findings
}

/// The texts in backquotes.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// The targets of Markdown links that stay in the repository.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()).filter(|target| !target.contains("://"))
}

/// Whether a text claims to be a path here: it begins with a folder of the top level, or is a file name of it.
fn names_a_file(tree: &Tree, text: &str) -> bool {
    if text.is_empty() || text.contains(|c: char| c.is_whitespace() || "<>{}*…$".contains(c)) {
        return false;
    }
    let Some((top, rest)) = text.split_once('/') else {
        // A single name is a file of the top level when it looks like one of those.
        return matches!(text.rsplit_once('.'), Some((_, "md" | "toml" | "yml")));
    };
    // Below a build folder nothing exists until somebody builds.
    let is_built = top == "build" || top == "target" || rest.split('/').any(|part| part == "build");
    !is_built && tree.files.iter().any(|file| file.path.split('/').next() == Some(top))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::{File, Tree};
    use super::{links, names_a_file, paths_exist, quoted};

    #[test]
    fn paths_are_found_in_text() {
        assert_eq!(quoted("a `b/c` d `e`").collect::<Vec<_>>(), ["b/c", "e"]);
        assert_eq!(links("see [x](docs/y.md#z) and [w](https://example.org)").collect::<Vec<_>>(), ["docs/y.md"]);
    }

    #[test]
    fn a_path_that_does_not_exist_is_found() {
        let file = |path: &str, text: &str| File { path: path.to_owned(), size: 0, text: Some(text.to_owned()) };
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let readme = file("README.md", "`src/main.rs`, `src/nothing.rs`, `other/x`, `src/*.rs`");
        let others = ["ARCHITECTURE.md", "CONTRIBUTING.md", "src/main.rs"].map(|path| file(path, ""));
        let tree = Tree { root, files: std::iter::once(readme).chain(others).collect() };
        let findings = paths_exist(&tree);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].what.contains("src/nothing.rs"));
        assert!(!names_a_file(&tree, "src/build/x"));
    }
}
