// SPDX-License-Identifier: Apache-2.0
//! Rules that no compiler checks: the size of files and lines, licence headers, marks of unfinished work, phrases of
//! comments, paths in the documentation and its map, and files that do not belong in the tree.

mod circles;
mod crates;
mod documents;
mod finding;
mod layers;
mod names;
mod phrases;
mod rules;
mod sources;
pub(crate) mod tree;

use std::path::Path;

use crate::counts::Counts;
use crate::report::Report;
use finding::Finding;

/// A rule looks at the whole tree and reports what breaks it.
type Rule = fn(&tree::Tree) -> Vec<Finding>;

const RULES: &[(&str, Rule)] = &[
    ("file sizes", rules::file_sizes),
    ("line lengths", rules::line_lengths),
    ("licence headers", rules::licence_headers),
    ("unfinished work", rules::unfinished_work),
    ("waiting in tests", rules::waiting_in_tests),
    ("files of other crates", rules::modules_of_others),
    ("stray files", rules::stray_files),
    ("paths in documents", documents::paths_exist),
    ("links between documents", documents::pages_linked),
    ("sizes of documents", documents::sizes),
    ("crates in the map", crates::map_complete),
    ("what crates may know", crates::known_crates),
    ("circles of files", circles::no_circles),
    ("layers of crates", layers::layers),
    ("names of types", names::unique),
    ("phrases of comments and messages", phrases::plain),
];

/// Checks the repository; every rule counts as one test.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    let tree = match tree::Tree::read(repository) {
        Ok(tree) => tree,
        Err(error) => {
            report.fail("tidy", &format!("cannot read the tree: {error}"));
            return;
        }
    };
    let mut counts = Counts::default();
    for (name, rule) in RULES {
        let findings = rule(&tree);
        for finding in &findings {
            eprintln!("{}: {} ({name})", finding.place, finding.what);
        }
        counts += Counts::one(findings.is_empty());
    }
    println!("{} files checked", tree.files.len());
    report.add("tidy", counts);
}
