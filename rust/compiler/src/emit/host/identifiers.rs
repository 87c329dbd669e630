// SPDX-License-Identifier: Apache-2.0
//! Identifiers of Rust for LF names: the same wherever Rust allows it, raw where it is a keyword.

use proc_macro2::{Ident, Span};
use syn::ext::IdentExt;

use crate::emit::names::{Names, plain};
use crate::lexical::{NEVER, is_plain};

/// Returns the identifier for a name; raw for a keyword.
pub(in crate::emit) fn ident(name: &str) -> Ident {
    let name = name.strip_prefix("r#").unwrap_or(name);
    if is_plain(name) {
        return Ident::new(name, Span::call_site());
    }
    // Rust does not accept these keywords as raw identifiers.
    if NEVER.contains(&name) {
        return Ident::new(&format!("{name}_"), Span::call_site());
    }
    syn::parse_str::<Ident>(&format!("r#{name}")).unwrap_or_else(|_| Ident::new(&plain(name), Span::call_site()))
}

/// Converts a name to that of a type: `unit_a` becomes `UnitA`.
pub(in crate::emit) fn pascal_case(name: &str) -> String {
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

/// Returns a unique identifier.
pub(super) fn give(names: &mut Names, wanted: &Ident) -> Ident {
    ident(&names.give(&wanted.unraw().to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_become_raw_and_everything_else_stays() {
        for (name, expected) in [
            ("type", "r#type"),
            ("r#type", "r#type"),
            ("self", "self_"),
            ("gen", "r#gen"),
            ("x", "x"),
            ("sendCount", "sendCount"),
        ] {
            assert_eq!(ident(name).to_string(), expected);
        }
        assert_eq!(ident("a.sensor").to_string(), "a_sensor");
        assert_eq!(give(&mut Names::default(), &ident("type")).to_string(), "r#type");
    }

    #[test]
    fn names_of_types() {
        assert_eq!(pascal_case("unit_a"), "UnitA");
        assert_eq!(pascal_case("3d"), "_3d");
    }
}
