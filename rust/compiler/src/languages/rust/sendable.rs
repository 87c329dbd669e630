// SPDX-License-Identifier: Apache-2.0
//! Types that cannot go to another federate, as far as their text and the preambles show. rustc decides all other
//! cases, so this module refuses no type that can be sent.

use syn::spanned::Spanned as _;
use syn::{GenericArgument, Generics, Item, PathArguments, Type, TypePath};

use super::declared::{Declarations, TypeDeclaration, derives, fields};
use crate::languages::facts::{PlaceInPreamble, Preambles, Unsendable};
use crate::lexical::byte_of;
use crate::plan::Serializer;

const NO_BOUND: &str = "has no bound, by which buffers could be sized";

/// The replacement for a port's own type without a known bound.
const BOUND: &str = "write `@max_length(1000)` before the declaration, or ";

/// Returns all known reasons why values of a type cannot be sent.
pub(super) fn unsendable(ty: &str, serializer: Option<&Serializer>, preambles: Preambles<'_>) -> Vec<Unsendable> {
    let Ok(parsed) = syn::parse_str::<Type>(ty) else { return Vec::new() };
    let max_length = serializer.and_then(|serializer| serializer.max_length);
    let by_serde = serializer.is_some_and(|serializer| serializer.name.is_some());
    let declarations = &Declarations::of(preambles);
    let mut look = SendableCheck {
        preambles,
        declarations,
        by_serde,
        inside: None,
        parameters: Vec::new(),
        open: Vec::new(),
        found: Vec::new(),
    };
    let mut whole = |reason: &str, hint: &str| look.refuse(&parsed, reason, hint);
    match growing(&parsed) {
        _ if by_serde => look.look(&parsed, max_length.is_some()),
        Some(Growing::List(element)) if max_length.is_some() => look.look(element, false),
        Some(Growing::Text) if max_length.is_some() => {}
        _ if max_length.is_some() => whole(
            "has a bound of its own, or none that a number could say",
            "remove `@max_length`, which is for `String`, `Vec<T>` and `@serializer(\"postcard\")`",
        ),
        Some(Growing::Text) => {
            whole(NO_BOUND, &format!("{BOUND}the type `heapless::String<N>`, which boards have, too"));
        }
        Some(Growing::List(element)) => {
            whole(NO_BOUND, &format!("{BOUND}the type `heapless::Vec<T, N>`, which boards have, too"));
            look.look(element, false);
        }
        None => look.look(&parsed, false),
    }
    let in_words = |part: UnsendablePart| {
        let UnsendablePart { ty: part, inside, reason, hint } = part;
        let (whole, which, place) = match inside {
            Some(Inside { owner, name, place }) => (owner, format!(": `{part}` of its {name}"), Some(place)),
            None if part == ty => (ty.to_owned(), ": it".to_owned(), None),
            None => (ty.to_owned(), format!(": `{part}` in it"), None),
        };
        Unsendable { message: format!("`{whole}` cannot be sent to another federate{which} {reason}"), hint, place }
    };
    look.found.into_iter().map(in_words).collect()
}

/// Returns the reason why a connection cannot copy values of a type, if it is known: the preambles declare it without
/// `Clone`.
pub(super) fn uncopyable(ty: &str, preambles: Preambles<'_>) -> Option<Unsendable> {
    let Type::Path(path) = syn::parse_str(ty).ok()? else { return None };
    let name = path.path.get_ident()?.to_string();
    let declarations = Declarations::of(preambles);
    let (attributes, keyword) = match declarations.find(&name)?.item {
        Item::Struct(item) => (&item.attrs, "struct"),
        Item::Enum(item) => (&item.attrs, "enum"),
        _ => return None,
    };
    let has_clone =
        derives(attributes)?.iter().any(|derive| derive == "Clone") || declarations.implements(&name, &["Clone"]);
    let message = format!("this connection has to copy values of `{ty}`, which is declared without `#[derive(Clone)]`");
    let hint = format!("write `#[derive(Clone)]` before `{keyword} {name}` in the preamble");
    (!has_clone).then_some(Unsendable { message, hint, place: None })
}

/// `String` or `Vec<T>`, which allocate as much memory as they need.
pub(crate) enum Growing<'t> {
    Text,
    List(&'t Type),
}

/// Returns the growing type behind a type, if it is one.
pub(crate) fn growing(ty: &Type) -> Option<Growing<'_>> {
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
    /// The field that it belongs to; `None` in the port's own type.
    inside: Option<Inside>,
    reason: String,
    hint: String,
}

/// A field of a type that the preambles declare.
#[derive(Clone)]
struct Inside {
    owner: String,
    /// ``field `x` `` or ``variant `A` ``.
    name: String,
    place: PlaceInPreamble,
}

struct SendableCheck<'a> {
    preambles: Preambles<'a>,
    declarations: &'a Declarations,
    by_serde: bool,
    /// The current field.
    inside: Option<Inside>,
    /// The type parameters of the current field's type, for which other types stand.
    parameters: Vec<String>,
    /// The declared types on the path to the current field, outermost first: a type may contain itself.
    open: Vec<String>,
    found: Vec<UnsendablePart>,
}

impl SendableCheck<'_> {
    fn refuse(&mut self, ty: &Type, reason: &str, hint: &str) {
        let (reason, hint) = (reason.to_owned(), hint.to_owned());
        self.found.push(UnsendablePart { ty: text(ty), inside: self.inside.clone(), reason, hint });
    }

    /// Checks a type and its parts. A given bound is sufficient for types of serde.
    fn look(&mut self, ty: &Type, bounded: bool) {
        let (reason, hint) = match ty {
            Type::Path(path) => return self.look_at_path(path, ty, bounded),
            Type::Array(array) => return self.look(&array.elem, bounded),
            Type::Group(group) => return self.look(&group.elem, bounded),
            Type::Paren(paren) => return self.look(&paren.elem, bounded),
            Type::Tuple(tuple) => {
                if tuple.elems.len() > 8 && !self.by_serde {
                    self.refuse(ty, "has more than eight parts", "write a struct with `#[derive(Payload)]`");
                }
                return tuple.elems.iter().for_each(|part| self.look(part, bounded));
            }
            Type::Reference(reference) => match &*reference.elem {
                Type::Path(path) if path.path.is_ident("str") => (
                    "only borrows its text, and a receiver has nothing to borrow it from",
                    "write `heapless::String<N>`, or on Linux `String` with `@max_length(1000)` before the declaration",
                ),
                _ => ("only borrows its value, and a receiver has nothing to borrow it from", "send the value"),
            },
            Type::Slice(_) => ("has no size of its own", "write `heapless::Vec<T, N>`"),
            Type::Ptr(_) => ("points to memory of this federate", "send the value that it points to"),
            Type::BareFn(_) | Type::TraitObject(_) | Type::ImplTrait(_) => {
                ("stands for code of this federate", "send a number or an enum that says what to do")
            }
            _ => return,
        };
        self.refuse(ty, reason, hint);
    }

    fn look_at_path(&mut self, path: &TypePath, ty: &Type, bounded: bool) {
        let Some(name) = path.path.segments.last().map(|last| last.ident.to_string()) else { return };
        if self.parameters.contains(&name) {
            return;
        }
        if path.qself.is_none()
            && path.path.segments.len() == 1
            && let Some(declared) = self.declarations.find(&name)
        {
            return self.look_at_declared(path, ty, &name, &declared, bounded);
        }
        let arguments = arguments(path);
        let has_number = arguments.iter().any(|argument| matches!(argument, GenericArgument::Const(_)));
        let is_heapless = path.path.segments.first().is_some_and(|first| first.ident == "heapless") || has_number;
        match name.as_str() {
            "usize" | "isize" if !self.by_serde => {
                let instead = if name == "usize" { "write `u32` or `u64`" } else { "write `i32` or `i64`" };
                self.refuse(ty, "has another size on a board than on a computer", instead);
            }
            "u128" | "i128" if !self.by_serde => {
                self.refuse(ty, "is no type that C has everywhere", "write `[u64; 2]`");
            }
            "Box" | "Rc" | "Arc" | "Cell" | "RefCell" | "Mutex" | "RwLock" | "Weak"
                if !self.by_serde && !arguments.is_empty() =>
            {
                self.refuse(ty, "is for memory of this federate", "send the value that is in it");
            }
            "String" if !arguments.is_empty() => {}
            "Vec" | "HashMap" | "BTreeMap" | "HashSet" | "BTreeSet" | "VecDeque" if arguments.is_empty() => {}
            "String" | "Vec" | "HashMap" | "BTreeMap" | "HashSet" | "BTreeSet" | "VecDeque" if !is_heapless => {
                if !self.by_serde || !bounded {
                    self.refuse_growing(ty, &name);
                }
                self.look_at_arguments(&arguments, true);
            }
            _ if is_heapless || name == "Option" || name == "Vec" => self.look_at_arguments(&arguments, bounded),
            _ => {}
        }
    }

    fn look_at_arguments(&mut self, arguments: &[&GenericArgument], bounded: bool) {
        for argument in arguments {
            if let GenericArgument::Type(ty) = argument {
                self.look(ty, bounded);
            }
        }
    }

    fn refuse_growing(&mut self, ty: &Type, name: &str) {
        if self.by_serde {
            let hint = "write `@max_length(200)` before the declaration, in bytes as postcard writes them";
            return self.refuse(ty, NO_BOUND, hint);
        }
        let instead = match name {
            "String" => "write `heapless::String<N>`",
            "Vec" | "VecDeque" => "write `heapless::Vec<T, N>`",
            _ => "send a list of its entries",
        };
        let hint = format!("{instead}, or `@serializer(\"postcard\") @max_length(200)` before the declaration");
        self.refuse(ty, NO_BOUND, &hint);
    }

    fn look_at_declared(
        &mut self,
        path: &TypePath,
        ty: &Type,
        name: &str,
        declared: &TypeDeclaration<'_>,
        bounded: bool,
    ) {
        let (attributes, generics, keyword) = match declared.item {
            Item::Struct(item) => (&item.attrs, &item.generics, "struct"),
            Item::Enum(item) => (&item.attrs, &item.generics, "enum"),
            Item::Type(item) if item.generics.params.is_empty() => {
                return self.within(name, |check| check.look(&item.ty, bounded));
            }
            _ => return,
        };
        // Another attribute may add unknown implementations.
        let Some(known) = derives(attributes) else { return };
        let declarations = self.declarations;
        let derived = |names: &[&str]| names.iter().any(|name| known.iter().any(|derive| derive == name));
        let own = |names: &[&str]| declarations.implements(name, names);
        if self.by_serde {
            let missing = ["Serialize", "Deserialize"].map(|one| (!derived(&[one]) && !own(&[one])).then_some(one));
            let missing: Vec<_> = missing.into_iter().flatten().collect();
            if !missing.is_empty() {
                let reason = format!("is declared without `#[derive({})]`", missing.join(", "));
                let hint = format!("write `#[derive(serde::Serialize, serde::Deserialize)]` before `{keyword} {name}`");
                self.refuse(ty, &reason, &hint);
            } else if !bounded && !derived(&["MaxSize"]) && !own(&["MaxSize"]) {
                let hint = format!(
                    "write `@max_length(200)` before the declaration, in bytes as postcard writes them, or \
                     `#[derive(postcard::experimental::max_size::MaxSize)]` before `{keyword} {name}`"
                );
                self.refuse(ty, NO_BOUND, &hint);
            }
            if own(&["Serialize", "Deserialize"]) {
                return;
            }
        } else {
            if !derived(&["Payload"]) && own(&["Payload", "FixedPayload"]) {
                return;
            }
            if !derived(&["Payload"]) {
                let hint = format!("write `#[derive(Payload)]` before `{keyword} {name}` in the preamble");
                self.refuse(ty, "is declared without `#[derive(Payload)]`", &hint);
            }
        }
        self.look_at_arguments(&arguments(path), true);
        self.within(name, |check| check.look_at_fields(name, generics, declared));
    }

    /// Checks the contents of a declared type, unless this check is running already.
    fn within(&mut self, name: &str, look: impl FnOnce(&mut Self)) {
        if self.open.iter().any(|open| open == name) {
            return;
        }
        self.open.push(name.to_owned());
        let outside = (self.inside.clone(), std::mem::take(&mut self.parameters));
        look(self);
        (self.inside, self.parameters) = outside;
        self.open.pop();
    }

    /// Checks the fields of a declared type. rustc decides about fields with an attribute of serde.
    fn look_at_fields(&mut self, owner: &str, generics: &Generics, declared: &TypeDeclaration<'_>) {
        self.parameters = generics.type_params().map(|parameter| parameter.ident.to_string()).collect();
        for (name, field) in fields(declared.item) {
            let is_special = field.attrs.iter().any(|attribute| attribute.path().is_ident("serde"));
            let Some(text) = self.preambles.visible.get(declared.preamble) else { continue };
            if self.by_serde && is_special {
                continue;
            }
            let span = field.ty.span();
            let range = byte_of(text, span.start())..byte_of(text, span.end());
            let place = PlaceInPreamble { preamble: declared.preamble, range };
            self.inside = Some(Inside { owner: owner.to_owned(), name, place });
            // The bound of the whole is sufficient for its parts.
            self.look(&field.ty, true);
        }
    }
}

/// Returns a type as users write it.
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
        let all = unsendable(ty, Some(&serializer), preambles);
        all.into_iter().map(|why| why.message).reduce(|all, one| format!("{all}\n{one}"))
    }

    #[test]
    fn sendable_types_are_not_refused() {
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
    fn types_that_cannot_be_sent_are_refused_with_the_reason() {
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
