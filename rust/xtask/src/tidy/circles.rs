// SPDX-License-Identifier: Apache-2.0
//! No circles among the files of a crate: the common needs of two files belong into a third, or they are one.
//!
//! A file uses another one if it names something that is defined there, by `use` or by a path; a re-export counts where
//! it is defined. Methods do not count, nor uses of tests.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use syn::visit::{self, Visit};
use syn::{Item, ItemMod, ItemUse, UseTree, Visibility};

use super::finding::Finding;
use super::sources::{is_conditional, sources};
use super::tree::Tree;

/// The path of a module within its crate.
pub(super) type Name = Vec<String>;

/// Checks every crate's files.
pub(super) fn no_circles(tree: &Tree) -> Vec<Finding> {
    let (crates, mut findings) = read(tree);
    for modules in crates.values() {
        findings.extend(circles(modules));
    }
    findings
}

/// Returns the files of every crate, and those that are no Rust.
pub(super) fn read(tree: &Tree) -> (BTreeMap<&str, BTreeMap<Name, Module>>, Vec<Finding>) {
    let mut crates: BTreeMap<&str, BTreeMap<Name, Module>> = BTreeMap::new();
    let mut findings = Vec::new();
    for source in sources(tree) {
        let place = &source.file.path;
        match source.parsed {
            Ok(parsed) => {
                let read = Module::read(place, &parsed.items);
                crates.entry(source.folder).or_default().insert(source.module, read);
            }
            Err(error) => findings.push(Finding { place: place.clone(), what: format!("is no Rust: {error}") }),
        }
    }
    (crates, findings)
}

/// The names that a file defines and uses.
#[derive(Default)]
pub(super) struct Module {
    pub(super) path: String,
    defined: BTreeSet<String>,
    /// The imports of `use`: the name here, and its origin.
    imported: BTreeMap<String, Name>,
    /// The names with a path that are not re-exports.
    pub(super) named: Vec<Name>,
}

impl Module {
    fn read(path: &str, items: &[Item]) -> Self {
        let mut module = Self { path: path.to_owned(), ..Self::default() };
        for item in items {
            module.defined.extend(defines(item));
            module.visit_item(item);
        }
        module
    }

    fn take_use(&mut self, tree: &UseTree, before: &Name, is_export: bool) {
        let extended = |name: String| before.iter().cloned().chain([name]).collect::<Name>();
        let (name, path) = match tree {
            UseTree::Path(path) => return self.take_use(&path.tree, &extended(path.ident.to_string()), is_export),
            UseTree::Group(group) => return group.items.iter().for_each(|one| self.take_use(one, before, is_export)),
            UseTree::Name(name) if name.ident == "self" => (before.last().cloned().unwrap_or_default(), before.clone()),
            UseTree::Name(name) => (name.ident.to_string(), extended(name.ident.to_string())),
            UseTree::Rename(rename) => (rename.rename.to_string(), extended(rename.ident.to_string())),
            UseTree::Glob(_) => return,
        };
        if !is_export {
            self.name(&path);
        }
        self.imported.insert(name, path);
    }

    fn name(&mut self, path: &Name) {
        // A path of one word is an item of this file.
        if path.len() > 1 {
            self.named.push(path.clone());
        }
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_conditional(item) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.take_use(&item.tree, &Name::new(), !matches!(item.vis, Visibility::Inherited));
    }

    // `pub(in crate::a)` names nothing.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.name(&path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }
}

fn defines(item: &Item) -> Option<String> {
    Some(match item {
        Item::Const(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Macro(item) => item.ident.as_ref()?.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        _ => return None,
    })
}

/// Returns the module in which this path ends, seen from a module.
pub(super) fn resolve(modules: &BTreeMap<Name, Module>, from: &Name, path: &[String], depth: usize) -> Option<Name> {
    let (mut at, mut rest) = match path.first()?.as_str() {
        "crate" => (Name::new(), &path[1..]),
        "self" | "super" => (from.clone(), path),
        first if modules.contains_key(&child(from, first)) => (from.clone(), path),
        first => {
            // A name that `use` has brought here, such as that of a module.
            let origin = modules.get(from)?.imported.get(first).filter(|origin| depth > 0 && *origin != path)?;
            let whole: Name = origin.iter().chain(&path[1..]).cloned().collect();
            return resolve(modules, from, &whole, depth - 1);
        }
    };
    while let Some((first, others)) = rest.split_first() {
        match first.as_str() {
            "self" => {}
            "super" => drop(at.pop()),
            first if modules.contains_key(&child(&at, first)) => at.push(first.to_owned()),
            _ => break,
        }
        rest = others;
    }
    let (here, Some(item)) = (modules.get(&at)?, rest.first()) else { return Some(at) };
    match here.imported.get(item) {
        Some(origin) if !here.defined.contains(item) && depth > 0 => resolve(modules, &at, origin, depth - 1),
        _ => Some(at),
    }
}

fn child(of: &Name, name: &str) -> Name {
    of.iter().cloned().chain([name.to_owned()]).collect()
}

/// Returns the shortest circle through each file, each circle once.
fn circles(modules: &BTreeMap<Name, Module>) -> Vec<Finding> {
    let uses: BTreeMap<&Name, BTreeSet<Name>> = modules
        .iter()
        .map(|(name, module)| {
            let used = module.named.iter().filter_map(|path| resolve(modules, name, path, modules.len()));
            (name, used.filter(|used| used != name).collect())
        })
        .collect();
    let mut seen = BTreeSet::new();
    let mut findings = Vec::new();
    for start in modules.keys() {
        let Some(circle) = shortest_circle(&uses, start) else { continue };
        if seen.insert(circle.iter().collect::<BTreeSet<_>>().into_iter().cloned().collect::<Vec<_>>()) {
            let others: Vec<_> = circle[1..].iter().map(|name| modules[name].path.as_str()).collect();
            let what = format!("uses {}, which uses this file", others.join(", which uses "));
            findings.push(Finding { place: modules[start].path.clone(), what });
        }
    }
    findings
}

fn shortest_circle(uses: &BTreeMap<&Name, BTreeSet<Name>>, start: &Name) -> Option<Vec<Name>> {
    let mut came_from: BTreeMap<&Name, &Name> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(at) = queue.pop_front() {
        for next in &uses[at] {
            if next == start {
                let mut circle = vec![at.clone()];
                let mut back = at;
                while back != start {
                    back = came_from[back];
                    circle.push(back.clone());
                }
                circle.reverse();
                return Some(circle);
            }
            if !came_from.contains_key(next) {
                came_from.insert(next, at);
                queue.push_back(next);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::sources::module;
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let read = |(path, text): &(&str, &str)| {
            let items = syn::parse_file(text).expect("it is Rust").items;
            (module(path.strip_suffix(".rs").expect("it is a source")), Module::read(path, &items))
        };
        circles(&files.iter().map(read).collect())
            .into_iter()
            .map(|finding| finding.place + " " + &finding.what)
            .collect()
    }

    #[test]
    fn a_circle_is_found_through_re_exports_and_paths() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use b::Thing;"),
            ("a.rs", "use crate::Thing; pub struct Own(Thing);"),
            ("b.rs", "pub struct Thing; fn make(_: super::a::Own) {}"),
        ];
        assert_eq!(found(&files), ["a.rs uses b.rs, which uses this file"]);
    }

    #[test]
    fn a_circle_is_found_through_an_imported_module() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "use crate::b; pub struct Own; fn make() { b::make() }"),
            ("b.rs", "pub fn make() { crate::a::Own; }"),
        ];
        assert_eq!(found(&files), ["a.rs uses b.rs, which uses this file"]);
    }

    #[test]
    fn a_ladder_is_none_and_neither_is_what_tests_use() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use a::Own;"),
            ("a.rs", "use super::b::Thing; pub struct Own(Thing);"),
            ("b.rs", "pub struct Thing; #[cfg(test)] mod tests { use crate::Own; }"),
        ];
        assert_eq!(found(&files), Vec::<String>::new());
    }
}
