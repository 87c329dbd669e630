// SPDX-License-Identifier: Apache-2.0
//! The declarations of types in preambles: their fields, and their implementations.

use proc_macro2::{TokenStream, TokenTree};
use syn::{Attribute, Field, Fields, File, Item, Type};

use crate::languages::facts::Preambles;

/// The preambles of a program, parsed.
pub(super) struct Declarations {
    /// Those whose declarations a type can name without a path; none if one of them cannot be parsed, because it may
    /// declare any names.
    visible: Vec<File>,
    /// All that can be parsed.
    all: Vec<File>,
}

/// The declaration of a type.
pub(super) struct TypeDeclaration<'a> {
    pub(super) item: &'a Item,
    /// The position of its preamble among the visible ones.
    pub(super) preamble: usize,
}

impl Declarations {
    pub(super) fn of(preambles: Preambles<'_>) -> Self {
        let parse = |text: &String| syn::parse_str::<File>(text).ok();
        let visible = preambles.visible.iter().map(parse).collect::<Option<_>>().unwrap_or_default();
        Self { visible, all: preambles.all.iter().filter_map(parse).collect() }
    }

    /// Returns the declaration of a name; of several, the last one.
    pub(super) fn find(&self, name: &str) -> Option<TypeDeclaration<'_>> {
        let items = self
            .visible
            .iter()
            .enumerate()
            .flat_map(|(preamble, file)| file.items.iter().map(move |item| TypeDeclaration { item, preamble }));
        let declares = |declared: &TypeDeclaration<'_>| match declared.item {
            Item::Struct(item) => item.ident == name,
            Item::Enum(item) => item.ident == name,
            Item::Type(item) => item.ident == name,
            _ => false,
        };
        items.rev().find(declares)
    }

    /// Returns whether a preamble implements one of these traits for a type, or may do so by a macro.
    pub(super) fn implements(&self, name: &str, traits: &[&str]) -> bool {
        let in_item = |item: &Item| match item {
            Item::Impl(item) => {
                let of = item.trait_.as_ref().and_then(|(_, path, _)| path.segments.last());
                let target = match &*item.self_ty {
                    Type::Path(path) => path.path.segments.last(),
                    _ => None,
                };
                of.is_some_and(|of| traits.iter().any(|name| of.ident == name))
                    && target.is_some_and(|target| target.ident == name)
            }
            Item::Macro(item) => mentions(item.mac.tokens.clone(), name),
            _ => false,
        };
        self.all.iter().flat_map(|file| &file.items).any(in_item)
    }
}

/// Returns all fields of a struct, and of the variants of an enum, with names for messages.
pub(super) fn fields(item: &Item) -> Vec<(String, &Field)> {
    let named = |fields: &'_ Fields| -> Vec<String> {
        let names = fields.members().map(|member| match member {
            syn::Member::Named(name) => format!("field `{name}`"),
            syn::Member::Unnamed(index) => format!("field `{}`", index.index),
        });
        names.collect()
    };
    match item {
        Item::Struct(item) => named(&item.fields).into_iter().zip(&item.fields).collect(),
        Item::Enum(item) => {
            let of_variant = |variant: &'_ syn::Variant| -> Vec<String> {
                let several = variant.fields.len() > 1 || matches!(variant.fields, Fields::Named(_));
                let of = format!("variant `{}`", variant.ident);
                let whole = |field: String| if several { format!("{field} of {of}") } else { of.clone() };
                named(&variant.fields).into_iter().map(whole).collect()
            };
            item.variants.iter().flat_map(|variant| of_variant(variant).into_iter().zip(&variant.fields)).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns the last names in `#[derive(…)]`; `None` if an attribute may add some.
pub(super) fn derives(attributes: &[Attribute]) -> Option<Vec<String>> {
    let mut names = Vec::new();
    for attribute in attributes {
        if attribute.path().is_ident("derive") {
            let listed = attribute.parse_nested_meta(|meta| {
                names.extend(meta.path.segments.last().map(|last| last.ident.to_string()));
                Ok(())
            });
            listed.ok()?;
        } else if !["doc", "repr", "allow", "expect", "serde", "payload", "non_exhaustive"]
            .iter()
            .any(|known| attribute.path().is_ident(known))
        {
            return None;
        }
    }
    Some(names)
}

fn mentions(tokens: TokenStream, name: &str) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(found) => found == name,
        TokenTree::Group(group) => mentions(group.stream(), name),
        TokenTree::Punct(_) | TokenTree::Literal(_) => false,
    })
}
