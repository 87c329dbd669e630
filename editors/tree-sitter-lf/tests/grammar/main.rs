// SPDX-License-Identifier: Apache-2.0
//! The grammar for editors reads what the compiler reads, in broken programs too, and its colours are those of the
//! grammar for VS Code.

mod broken;
mod colours;
mod programs;
mod queries;
mod trees;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use tree_sitter::{Language, Node, Parser, Tree};

/// Returns the top of the repository.
fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Returns the text of a file of the repository.
fn read(path: &str) -> String {
    let text = fs::read_to_string(repository().join(path));
    text.unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn language() -> Language {
    tree_sitter_lf::LANGUAGE.into()
}

fn parser() -> Parser {
    let mut parser = Parser::new();
    parser.set_language(&language()).expect("the library knows the version of the generated parser");
    parser
}

fn parse(text: &str) -> Tree {
    parser().parse(text, None).expect("without a time limit, each text has a tree")
}

/// Returns all nodes of a tree, parents first.
fn nodes(tree: &Tree) -> Vec<Node<'_>> {
    let (mut all, mut next) = (Vec::new(), vec![tree.root_node()]);
    while let Some(node) = next.pop() {
        all.push(node);
        next.extend((0..node.child_count()).rev().filter_map(|at| node.child(u32::try_from(at).ok()?)));
    }
    all
}

fn is_code(node: &Node<'_>) -> bool {
    matches!(node.kind(), "rust_code" | "c_code" | "cpp_code" | "other_code")
}

/// Returns the places of all code in a tree.
fn codes(tree: &Tree) -> Vec<Range<usize>> {
    nodes(tree).iter().filter(|node| is_code(node)).map(Node::byte_range).collect()
}

/// Returns all programs in a folder and those below it, apart from what builds put there.
fn programs(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            let name = name.to_string_lossy();
            let is_built = matches!(&*name, "target" | "build" | "node_modules" | "out") || name.starts_with('.');
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.extend((!is_built && !name.starts_with("twister-out")).then_some(path));
            } else if path.extension().is_some_and(|extension| extension == "lf" || extension == "ulf") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
