// SPDX-License-Identifier: Apache-2.0
//! The Rust of our crates, parsed.

use syn::ItemMod;

use super::tree::{File, Tree};

/// A source file of a crate that is no test.
pub(super) struct Source<'t> {
    pub(super) file: &'t File,
    /// The crate's folder.
    pub(super) folder: &'t str,
    /// The path of its module within the crate: `a/mod.rs` is `a`, the file of the crate itself has none.
    pub(super) module: Vec<String>,
    pub(super) parsed: syn::Result<syn::File>,
}

/// Returns the sources of all crates, in the order of their paths.
pub(super) fn sources(tree: &Tree) -> impl Iterator<Item = Source<'_>> {
    tree.files.iter().filter(|file| file.path.starts_with("rust/")).filter_map(|file| {
        let (folder, path) = file.path.split_once("/src/")?;
        let module = module(path.strip_suffix(".rs")?);
        let parsed = syn::parse_file(file.text.as_ref()?);
        let is_test = module.iter().any(|part| part == "tests");
        (!is_test).then_some(Source { file, folder, module, parsed })
    })
}

/// Returns the module of a file without its ending.
pub(super) fn module(path: &str) -> Vec<String> {
    let mut name: Vec<String> = path.split('/').map(str::to_owned).collect();
    if name.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
        name.pop();
    }
    name
}

/// Returns whether a module within a file is only there under a condition, such as `#[cfg(test)]`.
pub(super) fn is_conditional(item: &ItemMod) -> bool {
    item.attrs.iter().any(|attribute| attribute.path().is_ident("cfg"))
}
