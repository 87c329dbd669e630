// SPDX-License-Identifier: Apache-2.0
//! A type's name is defined once in a crate, so that its meaning is clear without its module.

use std::collections::{BTreeMap, BTreeSet};

use syn::{Ident, Item};

use super::finding::Finding;
use super::sources::{is_conditional, sources};
use super::tree::Tree;

/// This file, which a name leaves when it becomes unique.
const HERE: &str = "rust/xtask/src/tidy/names.rs";

/// Names that a crate defines more than once on purpose, and why.
const TWINS: &[(&str, &[&str], &str)] = &[
    (
        "rust/coordination",
        &["ClockSync", "Config", "Phase", "Rounds", "Stop", "Tags"],
        "a federate and an RTI have one each of the same thing; who uses both names them by their modules",
    ),
    (
        "rust/coordination",
        &["Stage"],
        "private: how far a round is for the clock that asks, and for the one that answers",
    ),
    ("rust/embedded", &["Memory"], "that of a federate and that of an RTI, by the names of their modules"),
];

/// The files that define a name, by crate and name.
type Definitions<'t> = BTreeMap<(&'t str, String), Vec<&'t str>>;

/// Checks that every name of a type is defined once in its crate, except for those of twins.
pub(super) fn unique(tree: &Tree) -> Vec<Finding> {
    findings(&definitions(tree), TWINS)
}

fn findings(definitions: &Definitions<'_>, twins: &[(&str, &[&str], &str)]) -> Vec<Finding> {
    let kept: BTreeSet<(&str, &str)> =
        twins.iter().flat_map(|(folder, names, _)| names.iter().map(|name| (*folder, *name))).collect();
    let twice: BTreeSet<(&str, &str)> = definitions
        .iter()
        .filter(|(_, places)| places.len() > 1)
        .map(|((folder, name), _)| (*folder, name.as_str()))
        .collect();
    let mut findings = Vec::new();
    for (folder, name) in twice.difference(&kept) {
        let places = &definitions[&(*folder, (*name).to_owned())];
        let what = format!("`{name}` is also the name of {}: one of them needs another", places[1..].join(" and of "));
        findings.push(Finding { place: places[0].to_owned(), what });
    }
    for (folder, name) in kept.difference(&twice) {
        let what = format!("`{folder}` no longer defines `{name}` twice: take it out of the table");
        findings.push(Finding { place: HERE.to_owned(), what });
    }
    findings
}

fn definitions(tree: &Tree) -> Definitions<'_> {
    let mut definitions = Definitions::new();
    for source in sources(tree) {
        let mut names = Vec::new();
        // The rule about circles finds a file that is not Rust.
        types(source.parsed.as_ref().map_or(&[], |file| &file.items), &mut names);
        for name in names {
            definitions.entry((source.folder, name.to_string())).or_default().push(&source.file.path);
        }
    }
    definitions
}

/// Collects the types of a file, those within its modules included.
fn types<'f>(items: &'f [Item], names: &mut Vec<&'f Ident>) {
    for item in items {
        match item {
            Item::Enum(item) => names.push(&item.ident),
            Item::Struct(item) => names.push(&item.ident),
            Item::Trait(item) => names.push(&item.ident),
            Item::Type(item) => names.push(&item.ident),
            Item::Union(item) => names.push(&item.ident),
            Item::Mod(item) if !is_conditional(item) => {
                types(item.content.as_ref().map_or(&[], |(_, items)| items), names);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::File;
    use super::*;

    fn tree(files: &[(&str, &str)]) -> Tree {
        let file = |(path, text): &(&str, &str)| File {
            path: (*path).to_owned(),
            size: text.len() as u64,
            text: Some((*text).to_owned()),
        };
        Tree { root: PathBuf::new(), files: files.iter().map(file).collect() }
    }

    #[test]
    fn a_name_that_a_crate_defines_twice_is_found() {
        let tree = tree(&[
            ("rust/a/src/lib.rs", "mod b;\nstruct Port;"),
            ("rust/a/src/b.rs", "mod inner { enum Port {} }"),
            ("rust/c/src/lib.rs", "type Port = u16;"),
        ]);
        let found = findings(&definitions(&tree), &[]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].place == "rust/a/src/lib.rs" && found[0].what.contains("rust/a/src/b.rs"), "{found:?}");
        assert_eq!(findings(&definitions(&tree), &[("rust/a", &["Port"], "")]), []);
    }

    #[test]
    fn names_in_tests_and_of_traits_do_not_count() {
        let tree = tree(&[
            ("rust/a/src/lib.rs", "struct Port; trait Has { type Port; } #[cfg(test)] mod tests { struct Port; }"),
            ("rust/a/src/b/tests.rs", "struct Port;"),
            ("rust/a/tests/c.rs", "struct Port;"),
        ]);
        assert_eq!(findings(&definitions(&tree), &[]), []);
    }

    #[test]
    fn an_entry_of_the_table_that_is_no_longer_needed_is_found() {
        let tree = tree(&[("rust/a/src/lib.rs", "struct Port;")]);
        let found = findings(&definitions(&tree), &[("rust/a", &["Port"], "")]);
        assert!(found.len() == 1 && found[0].place == HERE, "{found:?}");
    }
}
