// SPDX-License-Identifier: Apache-2.0
//! Types that cannot go to another federate, as far as their text and the preambles tell. What is not known here is
//! left to rustc, so nothing that can be sent is refused.

use proc_macro2::{TokenStream, TokenTree};
use syn::{Attribute, GenericArgument, Item, PathArguments, Type, TypePath};

use crate::languages::{Preambles, Unsendable};
use crate::plan::Serializer;

/// What is written in place of a type with a bound that is not known, where it is a port's own type.
const BOUND: &str = "write `@max_length(1000)` before the port, or ";

/// Why values of a type cannot be sent, if that is known.
pub(super) fn unsendable(ty: &str, serializer: Option<&Serializer>, preambles: Preambles<'_>) -> Option<Unsendable> {
    let parsed: Type = syn::parse_str(ty).ok()?;
    let max_length = serializer.and_then(|serializer| serializer.max_length);
    let look = SendableCheck { preambles, by_serde: serializer.is_some_and(|serializer| serializer.name.is_some()) };
    let found = match growing(&parsed) {
        _ if look.by_serde => look.look(&parsed, max_length.is_some()),
        Some(Growing::List(element)) if max_length.is_some() => look.look(element, false),
        Some(Growing::Text) if max_length.is_some() => None,
        _ if max_length.is_some() => {
            let hint = "remove `@max_length`, which is for `String`, `Vec<T>` and `@serializer(\"postcard\")`";
            Some(UnsendablePart::new(ty, "has a bound of its own, or none that a number could say", hint))
        }
        Some(Growing::Text) => {
            let instead = format!("{BOUND}the type `heapless::String<N>`, which boards have, too");
            Some(UnsendablePart::new(ty, "has no bound, by which buffers could be sized", &instead))
        }
        Some(Growing::List(_)) => {
            let instead = format!("{BOUND}the type `heapless::Vec<T, N>`, which boards have, too");
            Some(UnsendablePart::new(ty, "has no bound, by which buffers could be sized", &instead))
        }
        None => look.look(&parsed, false),
    }?;
    let part = if found.ty == ty { String::new() } else { format!(": `{}` in it", found.ty) };
    let colon = if part.is_empty() { ": it" } else { "" };
    let message = format!("`{ty}` cannot be sent to another federate{part}{colon} {}", found.reason);
    Some(Unsendable { message, hint: found.hint })
}

/// Why a connection cannot copy values of a type, if that is known: the preambles declare it without `Clone`.
pub(super) fn uncopyable(ty: &str, preambles: Preambles<'_>) -> Option<Unsendable> {
    let Type::Path(path) = syn::parse_str(ty).ok()? else { return None };
    let name = path.path.get_ident()?.to_string();
    let look = SendableCheck { preambles, by_serde: false };
    let (attributes, keyword) = match look.declared(&name)? {
        Item::Struct(item) => (item.attrs, "struct"),
        Item::Enum(item) => (item.attrs, "enum"),
        _ => return None,
    };
    let has_clone = derives(&attributes)?.iter().any(|derive| derive == "Clone") || look.implements(&name, &["Clone"]);
    let message = format!("this connection has to copy values of `{ty}`, which is declared without `#[derive(Clone)]`");
    let hint = format!("write `#[derive(Clone)]` before `{keyword} {name}` in the preamble");
    (!has_clone).then_some(Unsendable { message, hint })
}

/// `String` or `Vec<T>`, which take as much memory as they need.
pub(super) enum Growing<'t> {
    Text,
    List(&'t Type),
}

/// Whether a type is one of those.
pub(super) fn growing(ty: &Type) -> Option<Growing<'_>> {
    let Type::Path(path) = ty else { return None };
    if path.path.segments.first()?.ident == "heapless" {
        return None;
    }
    let name = path.path.segments.last()?.ident.to_string();
    match (name.as_str(), &arguments(path)[..]) {
        ("String", []) => Some(Growing::Text),
        ("Vec", [GenericArgument::Type(element)]) => Some(Growing::List(element)),
        _ => None,
    }
}

pub(super) fn arguments(path: &TypePath) -> Vec<&GenericArgument> {
    match path.path.segments.last().map(|last| &last.arguments) {
        Some(PathArguments::AngleBracketed(list)) => list.args.iter().collect(),
        _ => Vec::new(),
    }
}

/// A part of a type that cannot be sent.
struct UnsendablePart {
    ty: String,
    reason: String,
    hint: String,
}

impl UnsendablePart {
    fn new(ty: &str, reason: &str, hint: &str) -> Self {
        Self { ty: ty.to_owned(), reason: reason.to_owned(), hint: hint.to_owned() }
    }
}

struct SendableCheck<'a> {
    preambles: Preambles<'a>,
    by_serde: bool,
}

impl SendableCheck<'_> {
    /// Looks at a type and what it is made of. A bound that is given is enough for types of serde.
    fn look(&self, ty: &Type, bounded: bool) -> Option<UnsendablePart> {
        let why = |reason: &str, hint: &str| Some(UnsendablePart::new(&text(ty), reason, hint));
        match ty {
            Type::Path(path) => self.look_at_path(path, ty, bounded),
            Type::Array(array) => self.look(&array.elem, bounded),
            Type::Group(group) => self.look(&group.elem, bounded),
            Type::Paren(paren) => self.look(&paren.elem, bounded),
            Type::Tuple(tuple) if tuple.elems.len() > 8 && !self.by_serde => {
                why("has more than eight parts", "write a struct with `#[derive(Payload)]`")
            }
            Type::Tuple(tuple) => tuple.elems.iter().find_map(|part| self.look(part, bounded)),
            Type::Reference(reference) => match &*reference.elem {
                Type::Path(path) if path.path.is_ident("str") => why(
                    "only borrows its text, and a receiver has nothing to borrow it from",
                    "write `heapless::String<N>`, or on Linux `String` with `@max_length(1000)` before the port",
                ),
                _ => why("only borrows its value, and a receiver has nothing to borrow it from", "send the value"),
            },
            Type::Slice(_) => why("has no size of its own", "write `heapless::Vec<T, N>`"),
            Type::Ptr(_) => why("points to memory of this federate", "send the value that it points to"),
            Type::BareFn(_) | Type::TraitObject(_) | Type::ImplTrait(_) => {
                why("stands for code of this federate", "send a number or an enum that says what to do")
            }
            _ => None,
        }
    }

    fn look_at_path(&self, path: &TypePath, ty: &Type, bounded: bool) -> Option<UnsendablePart> {
        let why = |reason: &str, hint: &str| Some(UnsendablePart::new(&text(ty), reason, hint));
        let name = path.path.segments.last()?.ident.to_string();
        if path.path.get_ident().is_some()
            && let Some(declared) = self.declared(&name)
        {
            return self.look_at_declared(ty, &name, &declared, bounded);
        }
        let arguments = arguments(path);
        let mut inner = arguments.iter().filter_map(|argument| match argument {
            GenericArgument::Type(ty) => Some(ty),
            _ => None,
        });
        let has_number = arguments.iter().any(|argument| matches!(argument, GenericArgument::Const(_)));
        let is_heapless = path.path.segments.first()?.ident == "heapless" || has_number;
        let no_bound = "has no bound, by which buffers could be sized";
        match name.as_str() {
            "usize" | "isize" if !self.by_serde => {
                let instead = if name == "usize" { "`u32` or `u64`" } else { "`i32` or `i64`" };
                why("has another size on a board than on a computer", &format!("write {instead}"))
            }
            "u128" | "i128" if !self.by_serde => why("is no type that C has everywhere", "write `[u64; 2]`"),
            "Box" | "Rc" | "Arc" | "Cell" | "RefCell" | "Mutex" | "RwLock" | "Weak" if !self.by_serde => {
                why("is for memory of this federate", "send the value that is in it")
            }
            "String" if !arguments.is_empty() => None,
            "String" | "Vec" | "HashMap" | "BTreeMap" | "HashSet" | "BTreeSet" | "VecDeque" if !is_heapless => {
                if self.by_serde {
                    let hint = "write `@max_length(200)` before the port, in bytes as postcard writes them";
                    return if bounded { None } else { why(no_bound, hint) };
                }
                let list = "write `heapless::Vec<T, N>`";
                let instead = match name.as_str() {
                    "String" => "write `heapless::String<N>`",
                    "Vec" | "VecDeque" => list,
                    _ => "send a list of its entries",
                };
                why(no_bound, &format!("{instead}, or `@serializer(\"postcard\") @max_length(200)` before the port"))
            }
            _ if is_heapless || name == "Option" || name == "Vec" => inner.find_map(|ty| self.look(ty, bounded)),
            _ => None,
        }
    }

    fn look_at_declared(&self, ty: &Type, name: &str, declared: &Item, bounded: bool) -> Option<UnsendablePart> {
        let why = |reason: &str, hint: &str| Some(UnsendablePart::new(&text(ty), reason, hint));
        let (attributes, keyword) = match declared {
            Item::Struct(item) => (&item.attrs, "struct"),
            Item::Enum(item) => (&item.attrs, "enum"),
            Item::Type(item) if item.generics.params.is_empty() => return self.look(&item.ty, bounded),
            _ => return None,
        };
        let derives = derives(attributes)?;
        let has = |names: &[&str]| names.iter().any(|name| derives.iter().any(|derive| derive == name));
        if !self.by_serde {
            let known = has(&["Payload"]) || self.implements(name, &["Payload", "FixedPayload"]);
            let hint = format!("write `#[derive(Payload)]` before `{keyword} {name}` in the preamble");
            return if known { None } else { why("is declared without `#[derive(Payload)]`", &hint) };
        }
        for direction in ["Serialize", "Deserialize"] {
            if !has(&[direction]) && !self.implements(name, &[direction]) {
                let reason = format!("is declared without `#[derive({direction})]`");
                let hint = format!("write `#[derive(serde::Serialize, serde::Deserialize)]` before `{keyword} {name}`");
                return why(&reason, &hint);
            }
        }
        if bounded || has(&["MaxSize"]) || self.implements(name, &["MaxSize"]) {
            return None;
        }
        let hint = format!(
            "write `@max_length(200)` before the port, in bytes as postcard writes them, or \
             `#[derive(postcard::experimental::max_size::MaxSize)]` before `{keyword} {name}`"
        );
        why("has no bound, by which buffers could be sized", &hint)
    }

    fn declared(&self, name: &str) -> Option<Item> {
        declaration(self.preambles, name)
    }

    /// Whether a preamble implements one of these traits for a type, or may do it by a macro.
    fn implements(&self, name: &str, traits: &[&str]) -> bool {
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
        let parsed = |preamble: &String| syn::parse_str::<syn::File>(preamble);
        self.preambles.all.iter().any(|preamble| parsed(preamble).is_ok_and(|file| file.items.iter().any(in_item)))
    }
}

/// The declaration of a name, if it is certain which one it is.
pub(super) fn declaration(preambles: Preambles<'_>, name: &str) -> Option<Item> {
    let mut found = None;
    for preamble in preambles.visible {
        for item in syn::parse_str::<syn::File>(preamble).ok()?.items {
            let declared = match &item {
                Item::Struct(item) => Some(&item.ident),
                Item::Enum(item) => Some(&item.ident),
                Item::Type(item) => Some(&item.ident),
                _ => None,
            };
            if declared.is_some_and(|declared| declared == name) {
                found = Some(item);
            }
        }
    }
    found
}

/// The last names in `#[derive(…)]`; nothing where an attribute may add some.
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

/// A type as people write it.
pub(super) fn text(ty: &Type) -> String {
    let wrapped: syn::File = syn::parse_quote!(type T = #ty;);
    let text = prettyplease::unparse(&wrapped);
    text.trim().trim_start_matches("type T = ").trim_end_matches(';').to_owned()
}

#[cfg(test)]
mod tests {
    use super::{Preambles, unsendable};
    use crate::plan::Serializer;

    const PREAMBLE: &str = "
        #[derive(Clone, Payload)] pub struct Sent { a: u8 }
        #[derive(Clone)] pub struct Own(u8);
        impl lf::model::Payload for Own { }
        payload! { pub struct Declared { a: u8 } }
        pub struct Plain;
        #[some_macro] pub struct Unknown;
        wrap!(Wrapped); struct Wrapped;
        type Alias = [Plain; 2];
        #[derive(serde::Serialize, serde::Deserialize)] enum Serde { A }
        #[derive(Serialize, Deserialize, MaxSize)] enum Bounded { A }
    ";

    fn said(ty: &str, name: Option<&str>, max_length: Option<usize>) -> Option<String> {
        let preambles = [PREAMBLE.to_owned()];
        let preambles = Preambles { visible: &preambles, all: &preambles };
        let serializer = Serializer { name: name.map(str::to_owned), max_length };
        unsendable(ty, Some(&serializer), preambles).map(|why| why.message)
    }

    #[test]
    fn what_may_be_sent_is_not_refused() {
        for ty in [
            "u8",
            "()",
            "Sent",
            "Own",
            "Declared",
            "Unknown",
            "Wrapped",
            "Elsewhere",
            "other::Plain",
            "Option<(char, [Sent; 3])>",
            "heapless::Vec<heapless::String<3>, 4>",
            "Vec<u8, 4>",
            "core::time::Duration",
        ] {
            assert_eq!(said(ty, None, None), None, "{ty}");
        }
        for ty in ["String", "Vec<Sent>", "std::vec::Vec<(u8, u16)>"] {
            assert_eq!(said(ty, None, Some(9)), None, "{ty}");
        }
        for ty in ["Bounded", "u128", "usize", "Option<Box<Bounded>>"] {
            assert_eq!(said(ty, Some("postcard"), None), None, "{ty}");
        }
        for ty in ["Serde", "HashMap<String, Vec<usize>>", "(Serde, Elsewhere)"] {
            assert_eq!(said(ty, Some("postcard"), Some(9)), None, "{ty}");
        }
    }

    #[test]
    fn what_cannot_be_sent_is_refused_with_the_reason() {
        let all = [
            ("usize", None, None),
            ("[isize; 3]", None, None),
            ("u128", None, None),
            ("String", None, None),
            ("(u8, String)", None, None),
            ("Vec<u8>", None, None),
            ("Vec<String>", None, Some(3)),
            ("u32", None, Some(3)),
            ("&'static str", None, None),
            ("*const u8", None, None),
            ("fn(u8) -> u8", None, None),
            ("Option<Box<u8>>", None, None),
            ("std::collections::HashMap<u8, u8>", None, None),
            ("(u8, u8, u8, u8, u8, u8, u8, u8, u8)", None, None),
            ("heapless::Vec<Plain, 3>", None, None),
            ("Alias", None, None),
            ("Serde", Some("postcard"), None),
            ("Plain", Some("postcard"), Some(3)),
            ("String", Some("postcard"), None),
            ("&'static str", Some("postcard"), Some(3)),
        ];
        let said = all.map(|(ty, name, max)| said(ty, name, max).unwrap_or_else(|| panic!("`{ty}` is not refused")));
        insta::assert_snapshot!(said.join("\n"));
    }
}
