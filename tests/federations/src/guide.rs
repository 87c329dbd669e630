// SPDX-License-Identifier: Apache-2.0
//! Tables of the guide, which tests compare with the behavior of programs.

use std::path::Path;

/// Returns the cells of all rows of a table on a page of the guide, whose head begins with this cell.
///
/// # Panics
/// When there is no such page or table.
pub fn table(page: &str, head: &str) -> Vec<Vec<String>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/src").join(page);
    let text = std::fs::read_to_string(file).expect("the guide is there");
    let head = format!("| {head} |");
    let rows = text.lines().skip_while(|line| !line.starts_with(&head)).skip(2);
    let rows = rows.map_while(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
    let rows: Vec<_> = rows.map(|row| row.split(" | ").map(str::to_owned).collect()).collect();
    assert!(!rows.is_empty(), "{page} has a table that begins with `{head}`");
    rows
}
