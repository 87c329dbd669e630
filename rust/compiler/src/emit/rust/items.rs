// SPDX-License-Identifier: Apache-2.0
//! Names that preambles declare.

use std::collections::BTreeSet;

use syn::{File, Item, UseTree};

use crate::plan::SourceCode;

/// The names that preambles declare.
#[derive(Clone, Debug, Default)]
pub(super) struct Items {
    /// The names of items, and of the items in macros that look like items.
    pub(super) declared: BTreeSet<String>,
    /// The names in `use`.
    pub(super) imported: BTreeSet<String>,
}

impl Items {
    /// Returns the names of some preambles. Code that is not Rust has none: rustc reports the reason.
    pub(super) fn of<'c>(preambles: impl IntoIterator<Item = &'c SourceCode>) -> Self {
        let mut items = Self::default();
        for file in preambles.into_iter().filter_map(|code| syn::parse_str::<File>(&code.text).ok()) {
            file.items.iter().for_each(|item| items.add(item));
        }
        items
    }

    /// Returns whether a name is one of these.
    pub(super) fn has(&self, name: &str) -> bool {
        self.declared.contains(name) || self.imported.contains(name)
    }

    fn add(&mut self, item: &Item) {
        let name = match item {
            Item::Const(item) => &item.ident,
            Item::Enum(item) => &item.ident,
            Item::ExternCrate(item) => item.rename.as_ref().map_or(&item.ident, |(_, name)| name),
            Item::Fn(item) => &item.sig.ident,
            Item::Mod(item) => &item.ident,
            Item::Static(item) => &item.ident,
            Item::Struct(item) => &item.ident,
            Item::Trait(item) => &item.ident,
            Item::TraitAlias(item) => &item.ident,
            Item::Type(item) => &item.ident,
            Item::Union(item) => &item.ident,
            Item::Use(item) => return self.import(&item.tree),
            Item::Macro(item) => {
                if let Ok(file) = syn::parse2::<File>(item.mac.tokens.clone()) {
                    file.items.iter().for_each(|item| self.add(item));
                }
                return;
            }
            _ => return,
        };
        self.declared.insert(name.to_string());
    }

    fn import(&mut self, tree: &UseTree) {
        match tree {
            UseTree::Path(path) => self.import(&path.tree),
            UseTree::Name(name) => _ = self.imported.insert(name.ident.to_string()),
            UseTree::Rename(name) => _ = self.imported.insert(name.rename.to_string()),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.import(tree)),
            UseTree::Glob(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{FileIndex, Location};

    #[test]
    fn names_are_known_of_items_imports_and_macros() {
        let text = "use a::{b, c as d, e::*}; pub struct S; payload! { struct T { x: u8 } } fn f() { struct U; }";
        let at = Location { file: FileIndex(0), line: 1, column: 1 };
        let items = Items::of([&SourceCode { text: text.to_owned(), at }]);
        let names = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(" ");
        assert_eq!((names(&items.declared), names(&items.imported)), ("S T f".to_owned(), "b d".to_owned()));
    }
}
