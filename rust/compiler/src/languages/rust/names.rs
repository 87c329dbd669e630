// SPDX-License-Identifier: Apache-2.0
//! Rust names for LF names: the same wherever Rust allows it, raw where it is a keyword.

use proc_macro2::{Ident, Span};
use syn::ext::IdentExt;

use crate::emit::names::{Names, plain};

/// Keywords that cannot be written as `r#word` either.
const NEVER: [&str; 5] = ["self", "Self", "super", "crate", "_"];

/// What no variable of a body can be called, because bodies have it in sight and patterns can name it.
const KNOWN: [&str; 6] = ["None", "Some", "Ok", "Err", "Asap", "After"];

/// The identifier for a name; raw for a keyword.
pub(super) fn ident(name: &str) -> Ident {
    let name = name.strip_prefix("r#").unwrap_or(name);
    if let Ok(ident) = syn::parse_str::<Ident>(name) {
        return ident;
    }
    // These are the keywords that Rust does not take as raw identifiers.
    if NEVER.contains(&name) {
        return Ident::new(&format!("{name}_"), Span::call_site());
    }
    syn::parse_str::<Ident>(&format!("r#{name}")).unwrap_or_else(|_| Ident::new(&plain(name), Span::call_site()))
}

/// `unit_a` becomes `UnitA`: the name of a type.
pub(super) fn pascal_case(name: &str) -> String {
    let words = plain(name);
    let mut pascal: String = words
        .split('_')
        .filter_map(|word| {
            let mut characters = word.chars();
            characters.next().map(|first| first.to_ascii_uppercase().to_string() + characters.as_str())
        })
        .collect();
    if pascal.is_empty() || pascal.starts_with(|c: char| c.is_ascii_digit()) {
        pascal.insert(0, '_');
    }
    pascal
}

/// A name as code of the program spells it: keywords become raw identifiers.
pub(super) fn raw(name: &str) -> String {
    if NEVER.contains(&name) || syn::parse_str::<Ident>(name).is_ok() { name.to_owned() } else { format!("r#{name}") }
}

/// Why no item, variable or field can be called so, not even by a raw identifier, or no variable of a body.
pub(super) fn problem(name: &str, in_bodies: bool) -> Option<&'static str> {
    if in_bodies && ["self", "ctx"].contains(&name) {
        return Some("reaction bodies have a variable of this name");
    }
    if in_bodies && KNOWN.contains(&name) {
        return Some("reaction bodies know something else by this name");
    }
    NEVER.contains(&name).then_some("Rust does not allow this name")
}

/// An identifier that is given once.
pub(super) fn give(names: &mut Names, wanted: &Ident) -> Ident {
    ident(&names.give(&wanted.unraw().to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_become_raw_and_everything_else_stays() {
        for (name, expected) in
            [("type", "r#type"), ("r#type", "r#type"), ("self", "self_"), ("x", "x"), ("sendCount", "sendCount")]
        {
            assert_eq!(ident(name).to_string(), expected);
        }
        assert_eq!(ident("a.sensor").to_string(), "a_sensor");
        assert_eq!([raw("in"), raw("inp"), raw("self")], ["r#in", "inp", "self"]);
        assert_eq!(give(&mut Names::default(), &ident("type")).to_string(), "r#type");
    }

    #[test]
    fn names_of_types() {
        assert_eq!(pascal_case("unit_a"), "UnitA");
        assert_eq!(pascal_case("3d"), "_3d");
    }
}
