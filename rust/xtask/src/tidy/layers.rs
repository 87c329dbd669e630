// SPDX-License-Identifier: Apache-2.0
//! The layers within a crate: what the files of a folder may use of other folders stands in a table of the documents.
//!
//! A table begins with a cell such as ``layer of `rust/compiler/src` `` and has a column `may use`. A layer is a folder
//! or a file; of several that hold a file, the longest counts.

use std::collections::{BTreeMap, BTreeSet};

use super::circles::{Module, Name, read, resolve};
use super::crates::{cells, quoted};
use super::finding::Finding;
use super::tree::Tree;

/// The beginning of a table's first cell.
const TABLE: &str = "layer of";
/// The column of layers that a layer may use.
const COLUMN: &str = "may use";

/// Every layer uses what its table says, and the table says no more.
pub(super) fn layers(tree: &Tree) -> Vec<Finding> {
    let (crates, _) = read(tree);
    let documents = tree.files.iter().filter(|file| file.kind() == "md");
    let mut findings = Vec::new();
    for document in documents {
        let mut lines = document.text.as_deref().unwrap_or_default().lines();
        while let Some(row) = lines.by_ref().find_map(|line| cells(line).filter(|row| row[0].starts_with(TABLE))) {
            let folder = quoted(row[0]).next().unwrap_or_default();
            let column = row.iter().position(|cell| *cell == COLUMN);
            let modules = crates.get(folder.trim_end_matches("/src"));
            let (Some(column), Some(modules)) = (column, modules) else {
                let what = format!("has a table of layers of `{folder}` without a column `{COLUMN}`, or of no crate");
                findings.push(Finding { place: document.path.clone(), what });
                continue;
            };
            let rows: Vec<_> = lines.by_ref().map_while(cells).collect();
            let allowed =
                rows.iter().filter_map(|row| Some((quoted(row[0]).next()?, quoted(row.get(column)?).collect())));
            findings.extend(check(folder, modules, &allowed.collect(), &document.path));
        }
    }
    findings
}

/// Compares what the files of a crate use with a table.
fn check(
    folder: &str,
    modules: &BTreeMap<Name, Module>,
    allowed: &BTreeMap<&str, BTreeSet<&str>>,
    document: &str,
) -> Vec<Finding> {
    let layer = |path: &str| {
        let inside = path.strip_prefix(folder).map(|rest| rest.trim_start_matches('/')).unwrap_or_default().to_owned();
        let holds = |layer: &&&str| {
            inside.strip_prefix(**layer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.']))
        };
        allowed.keys().filter(holds).max_by_key(|layer| layer.len()).copied()
    };
    let mut findings = Vec::new();
    let mut used: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (name, module) in modules.iter().filter(|(name, _)| !name.is_empty()) {
        let Some(own) = layer(&module.path) else {
            findings.push(Finding { place: module.path.clone(), what: format!("is in no layer of {document}") });
            continue;
        };
        let targets = module.named.iter().filter_map(|path| resolve(modules, name, path, modules.len()));
        let targets: BTreeSet<&str> = targets.filter_map(|target| layer(&modules[&target].path)).collect();
        for target in targets.into_iter().filter(|target| *target != own) {
            used.entry(own).or_default().insert(target);
            if !allowed[own].contains(target) {
                let what = format!("is in layer `{own}`, which may not use `{target}` as {document} has it");
                findings.push(Finding { place: module.path.clone(), what });
            }
        }
    }
    for (layer, uses) in allowed {
        let found = used.get(layer).cloned().unwrap_or_default();
        for unused in uses.difference(&found) {
            findings.push(Finding { place: document.to_owned(), what: format!("`{layer}` does not use `{unused}`") });
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::File;
    use super::*;

    /// Returns a crate of two layers, with a table that lets the upper one use these.
    fn found(allowed: &str) -> Vec<String> {
        let table = format!("| layer of `rust/one/src` | may use |\n|---|---|\n| `low` | |\n| `high` | {allowed} |\n");
        let files = [
            ("docs/one.md", table.as_str()),
            ("rust/one/src/lib.rs", "mod high; mod low;"),
            ("rust/one/src/high/mod.rs", "pub use crate::low::Thing; struct Own(Thing);"),
            ("rust/one/src/high/part.rs", "fn make(_: crate::low::Thing) {}"),
            ("rust/one/src/low.rs", "pub struct Thing;"),
        ];
        let file = |(path, text): (&str, &str)| File { path: path.to_owned(), size: 0, text: Some(text.to_owned()) };
        let tree = Tree { root: PathBuf::new(), files: files.map(file).into() };
        layers(&tree).into_iter().map(|finding| finding.place + " " + &finding.what).collect()
    }

    #[test]
    fn arrows_that_a_table_does_not_allow_are_found() {
        assert_eq!(found("`low`"), Vec::<String>::new());
        assert_eq!(
            found(""),
            ["rust/one/src/high/part.rs is in layer `high`, which may not use `low` as docs/one.md has it"]
        );
    }

    #[test]
    fn unused_rows_of_a_table_are_found() {
        assert_eq!(found("`low`, `other`"), ["docs/one.md `high` does not use `other`"]);
    }
}
