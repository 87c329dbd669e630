// SPDX-License-Identifier: Apache-2.0
//! What the documents say of the language is what the compiler does.
//!
//! `INSTA_UPDATE=always cargo test -p lf-compiler --test documents` rewrites it, as `cargo xtask bless` does.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const BEGIN: &str = "<!-- refused: written by `cargo xtask bless` -->\n";
const END: &str = "<!-- refused: end -->";

#[test]
fn the_readme_has_every_part_of_the_language_that_is_refused() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let text = fs::read_to_string(&file).expect("the repository has a README");
    let mut table = "| part of LF | instead |\n|---|---|\n".to_owned();
    for (part, instead) in lf_compiler::refused() {
        writeln!(table, "| {part} | {instead} |").expect("a text takes all");
    }
    let (before, rest) = text.split_once(BEGIN).expect("the README says where the table begins");
    let (found, after) = rest.split_once(END).expect("the README says where the table ends");
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        fs::write(&file, format!("{before}{BEGIN}{table}{END}{after}")).expect("the README can be written");
    } else {
        assert_eq!(found, table, "`cargo xtask bless` writes the table into the README");
    }
}
