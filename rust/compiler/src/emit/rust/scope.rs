// SPDX-License-Identifier: Apache-2.0
//! The meanings of names in the module of a reactor: first the declarations of the reactor, then those of its file,
//! then the names that bodies see without an import. Names in code from another file, which is inherited, or in a type
//! argument mean the declarations of that file.

use std::collections::BTreeSet;

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::quote;

use super::items::Items;
use super::layout::Layout;
use super::prelude::PRELUDE;
use crate::emit::host::ident;
use crate::emit::view::View;
use crate::languages::rust::DURATION;
use crate::plan::{ClassIndex, Location, Type};

/// A module whose names code may use.
struct Other {
    path: TokenStream,
    /// Its file.
    file: usize,
    /// Its declarations that mean something else in the reactor's module, or are ambiguous there.
    hidden: BTreeSet<String>,
}

/// The names of a reactor's module.
pub(super) struct ModuleNames {
    file: usize,
    imports: TokenStream,
    others: Vec<Other>,
}

impl ModuleNames {
    pub(super) fn new(view: &View<'_>, layout: &Layout<'_>, index: ClassIndex) -> Self {
        let class = view.class(index);
        let own_file = Items::of(view.preambles(class.at.file));
        let own = Items::of(&class.preambles);
        let users = class.users.iter().filter(|user| **user != index && layout.has(**user));
        let users = users.map(|user| {
            let of = view.class(*user);
            (layout.module_path(*user), of.at.file.0, Items::of(&of.preambles))
        });
        let files = class
            .files
            .iter()
            .filter_map(|file| Some((layout.file_path(*file)?, file.0, Items::of(view.preambles(*file)))));
        let known: Vec<_> = users.chain(files).collect();
        let mut imports = TokenStream::new();
        let mut from_file = BTreeSet::new();
        let mut others = Vec::new();
        for (position, (path, file, items)) in known.iter().enumerate() {
            let path: TokenStream = path.parse().unwrap_or_default();
            let elsewhere = |name: &&String| {
                known.iter().enumerate().any(|(at, (.., items))| at != position && items.declared.contains(*name))
            };
            let names = || items.declared.iter().filter(|name| !own.has(name));
            let hidden: BTreeSet<String> =
                names().filter(|name| own_file.has(name) || elsewhere(name)).cloned().collect();
            from_file.extend(names().filter(|name| own_file.has(name)).cloned());
            // Declared names take precedence over those that bodies see without an import.
            let preferred = names().filter(|name| !hidden.contains(*name) && PRELUDE.contains(&name.as_str()));
            let preferred: Vec<Ident> = preferred.map(|name| ident(name)).collect();
            let import = (!preferred.is_empty()).then(|| quote!(use #path::{#(#preferred),*};));
            imports.extend(quote! {
                #[allow(unused_imports)]
                use #path::*;
                #import
            });
            others.push(Other { path, file: *file, hidden });
        }
        if !from_file.is_empty() {
            let names = from_file.iter().map(|name| ident(name));
            imports.extend(quote!(use super::{#(#names),*};));
        }
        Self { file: class.at.file.0, imports, others }
    }

    /// Returns declarations for the names in the module's own code.
    pub(super) fn imports(&self) -> &TokenStream {
        &self.imports
    }

    /// Returns declarations by which code from a place refers to the declarations of that file, if the module's names
    /// mean something else; `variables` are those that it sees. The names in the code do not matter, because strings of
    /// macros can contain some, too.
    pub(super) fn uses(&self, at: Location, variables: &[Ident]) -> Option<TokenStream> {
        if at.file.0 == self.file || self.others.iter().all(|other| other.hidden.is_empty()) {
            return None;
        }
        let is_variable = |name: &String| variables.iter().any(|variable| variable == name);
        let mut uses = TokenStream::new();
        let mut done = BTreeSet::new();
        for Other { path, hidden, .. } in self.others.iter().filter(|other| other.file == at.file.0) {
            let meant = hidden.iter().filter(|name| !is_variable(name));
            let meant: Vec<Ident> = meant.filter(|name| done.insert((*name).clone())).map(|name| ident(name)).collect();
            if !meant.is_empty() {
                uses.extend(quote!(use #path::{#(#meant),*};));
            }
        }
        (!uses.is_empty()).then_some(uses)
    }

    /// Returns a type of the program with the paths of names that mean something else in the module.
    pub(super) fn qualified(&self, ty: &Type, parsed: &syn::Type) -> TokenStream {
        if ty.text == DURATION {
            return quote!(::#parsed);
        }
        let others = self.others.iter().filter(|other| ty.at.file.0 != self.file && other.file == ty.at.file.0);
        let others: Vec<_> = others.filter(|other| !other.hidden.is_empty()).collect();
        if others.is_empty() { quote!(#parsed) } else { with_paths(quote!(#parsed), &others) }
    }
}

fn with_paths(tokens: TokenStream, others: &[&Other]) -> TokenStream {
    let mut behind_colon = false;
    let mut result = TokenStream::new();
    for token in tokens {
        let is_first = !behind_colon;
        behind_colon = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == ':');
        match &token {
            TokenTree::Ident(name) if is_first => {
                let text = name.to_string();
                if let Some(Other { path, .. }) = others.iter().find(|other| other.hidden.contains(&text)) {
                    result.extend(quote!(#path::#name));
                    continue;
                }
            }
            TokenTree::Group(group) => {
                let inner = with_paths(group.stream(), others);
                result.extend([TokenTree::Group(proc_macro2::Group::new(group.delimiter(), inner))]);
                continue;
            }
            _ => {}
        }
        result.extend([token]);
    }
    result
}
