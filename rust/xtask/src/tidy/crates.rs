// SPDX-License-Identifier: Apache-2.0
//! The map in ARCHITECTURE.md has every crate, and its dependencies.

use std::collections::{BTreeMap, BTreeSet};

use super::finding::Finding;
use super::tree::Tree;

/// The document with the map.
const MAP: &str = "ARCHITECTURE.md";
/// The column of crates that a crate may depend on: their folders' names in backquotes.
const COLUMN: &str = "may know";
/// The sections of a manifest that count. Dependencies of tests may be any.
const SECTIONS: [&str; 2] = ["[dependencies]", "[build-dependencies]"];

/// A crate of this repository.
struct Crate {
    name: String,
    /// All names that its manifest depends on.
    dependencies: BTreeSet<String>,
}

/// Checks that every crate is in the map.
pub(super) fn map_complete(tree: &Tree) -> Vec<Finding> {
    let mapped: Vec<&str> = text(tree, MAP).lines().filter_map(cells).flat_map(|row| quoted(row[0])).collect();
    let missing = crates(tree).into_keys().filter(|folder| !mapped.iter().any(|path| is_in(folder, path)));
    let what = |folder| format!("`{folder}` is not in its map");
    missing.map(|folder| Finding { place: MAP.to_owned(), what: what(folder) }).collect()
}

/// Checks that the dependencies of every crate are those of the map.
pub(super) fn known_crates(tree: &Tree) -> Vec<Finding> {
    let crates = crates(tree);
    let folders: BTreeMap<&str, &str> = crates.iter().map(|(folder, one)| (one.name.as_str(), short(folder))).collect();
    let mut findings = Vec::new();
    let mut column = None;
    for line in text(tree, MAP).lines() {
        let Some(row) = cells(line) else {
            // The table ends.
            column = None;
            continue;
        };
        column = row.iter().position(|cell| *cell == COLUMN).or(column);
        let Some(known) = column.and_then(|column| row.get(column)) else { continue };
        let known: BTreeSet<&str> = quoted(known).collect();
        for (folder, one) in quoted(row[0]).filter_map(|folder| crates.get_key_value(folder)) {
            let found = one.dependencies.iter().filter_map(|name| folders.get(name.as_str()).copied()).collect();
            let what = |names: Vec<&str>, text: &str| format!("`{folder}` {text} {}", names.join(", "));
            let place = || format!("{folder}/Cargo.toml");
            if !known.is_superset(&found) {
                let names = found.difference(&known).copied().collect();
                findings
                    .push(Finding { place: place(), what: what(names, "may not know, as ARCHITECTURE.md has it,") });
            }
            if !found.is_superset(&known) {
                let names = known.difference(&found).copied().collect();
                findings.push(Finding { place: MAP.to_owned(), what: what(names, "does not depend on") });
            }
        }
    }
    findings
}

/// Returns the crates by their folders.
fn crates(tree: &Tree) -> BTreeMap<String, Crate> {
    let manifests = tree.files.iter().filter_map(|file| Some((file.path.strip_suffix("/Cargo.toml")?, file)));
    manifests.map(|(folder, file)| (folder.to_owned(), read(file.text.as_deref().unwrap_or_default()))).collect()
}

fn read(manifest: &str) -> Crate {
    let (mut name, mut dependencies, mut section) = ("", BTreeSet::new(), "");
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) {
            let key = key.trim().split('.').next().unwrap_or_default();
            if section == "[package]" && key == "name" {
                name = value.trim().trim_matches('"');
            } else if SECTIONS.contains(&section) {
                dependencies.insert(key.to_owned());
            }
        }
    }
    Crate { name: name.to_owned(), dependencies }
}

/// Returns the cells of a line that is a row of a table.
pub(super) fn cells(line: &str) -> Option<Vec<&str>> {
    line.strip_prefix('|').map(|row| row.split('|').map(str::trim).collect())
}

pub(super) fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

/// Returns whether a folder is this one or lies in it.
fn is_in(folder: &str, path: &str) -> bool {
    folder.strip_prefix(path.trim_end_matches('/')).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// Returns the name of a folder in the map.
fn short(folder: &str) -> &str {
    folder.strip_prefix("rust/").unwrap_or(folder)
}

fn text<'t>(tree: &'t Tree, path: &str) -> &'t str {
    tree.files.iter().find(|file| file.path == path).and_then(|file| file.text.as_deref()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::File;
    use super::*;

    /// Returns two crates, of which `top` depends on `base`, and a map with this entry for `top`.
    fn tree(known: &str) -> Tree {
        let map = format!(
            "| path | may know |\n|---|---|\n| `rust/base` | nothing else here |\n| `rust/top` | {known} |\n\n\
             | another | table |\n|---|---|\n| `rust/top` | `nothing` |\n"
        );
        let base = "[package]\nname = \"lf-base\"\n";
        let top = "[package]\nname = \"lf-top\"\n[dependencies]\nlf-base.workspace = true\nserde = \"1\"\n\
                   [dev-dependencies]\nlf-top = { path = \".\" }\n";
        let files = [
            ("ARCHITECTURE.md", map.as_str()),
            ("Cargo.toml", "[workspace]\n"),
            ("rust/base/Cargo.toml", base),
            ("rust/top/Cargo.toml", top),
        ];
        let file = |(path, text): (&str, &str)| File { path: path.to_owned(), size: 0, text: Some(text.to_owned()) };
        Tree { root: PathBuf::new(), files: files.map(file).into() }
    }

    #[test]
    fn a_crate_that_is_not_in_the_map_is_found() {
        let mut tree = tree("`base`");
        assert_eq!(map_complete(&tree), []);
        let map = tree.files.iter_mut().find(|file| file.path == MAP).expect("it is there");
        map.text = Some("| `rust/base` | one |\n\n`rust/top` is in no table".to_owned());
        let findings = map_complete(&tree);
        assert!(findings.len() == 1 && findings[0].what.contains("rust/top"), "{findings:?}");
        let map = tree.files.iter_mut().find(|file| file.path == MAP).expect("it is there");
        map.text = Some("| `rust/` | all |".to_owned());
        assert_eq!(map_complete(&tree), []);
    }

    #[test]
    fn crates_depend_on_those_that_they_may_know() {
        assert_eq!(known_crates(&tree("words, and `base`")), []);
        let findings = known_crates(&tree("nothing else here"));
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].place == "rust/top/Cargo.toml" && findings[0].what.contains("may not know"));
        let findings = known_crates(&tree("`base`, `top`"));
        assert!(findings.len() == 1 && findings[0].what.contains("does not depend on top"), "{findings:?}");
    }
}
