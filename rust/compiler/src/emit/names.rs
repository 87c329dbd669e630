// SPDX-License-Identifier: Apache-2.0
//! Rust names for LF names: the same wherever Rust allows it, raw where it is a keyword, and never twice.

use std::collections::BTreeSet;

use proc_macro2::{Ident, Span};
use syn::ext::IdentExt;

/// The identifier for a name; raw for a keyword.
pub(super) fn ident(name: &str) -> Ident {
    let name = name.strip_prefix("r#").unwrap_or(name);
    if let Ok(ident) = syn::parse_str::<Ident>(name) {
        return ident;
    }
    // These are the keywords that Rust does not take as raw identifiers.
    if ["self", "Self", "super", "crate", "_"].contains(&name) {
        return Ident::new(&format!("{name}_"), Span::call_site());
    }
    syn::parse_str::<Ident>(&format!("r#{name}")).unwrap_or_else(|_| Ident::new(&plain(name), Span::call_site()))
}

/// The text with everything that cannot be in an identifier replaced.
fn plain(text: &str) -> String {
    let mut plain: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_digit()) || plain.is_empty() {
        plain.insert(0, '_');
    }
    plain
}

/// `RelayUnit` becomes `relay_unit`, `HTTPServer` becomes `http_server`.
pub(super) fn snake_case(name: &str) -> String {
    let characters: Vec<char> = plain(name).chars().collect();
    let mut snake = String::new();
    for (index, c) in characters.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| characters[before]);
        let starts_word = c.is_ascii_uppercase()
            && before.is_some_and(|before| {
                let next_is_lower = characters.get(index + 1).is_some_and(char::is_ascii_lowercase);
                before.is_ascii_lowercase() || before.is_ascii_digit() || (before.is_ascii_uppercase() && next_is_lower)
            });
        if starts_word {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
    }
    snake
}

/// `RelayUnit` becomes `relay-unit`: the name of a package or a program.
pub(super) fn kebab_case(name: &str) -> String {
    let kebab: Vec<String> = snake_case(name).split('_').filter(|word| !word.is_empty()).map(str::to_owned).collect();
    if kebab.is_empty() { "federate".to_owned() } else { kebab.join("-") }
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

/// Names that are given once each.
#[derive(Default)]
pub(super) struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// Names that must not be given.
    pub(super) fn reserving(names: &[&str]) -> Self {
        Self { taken: names.iter().map(|name| (*name).to_owned()).collect() }
    }

    /// The name itself, or with a number where it has been given before.
    pub(super) fn give(&mut self, name: &str) -> String {
        let mut given = name.to_owned();
        let mut number = 2;
        while !self.taken.insert(given.clone()) {
            given = format!("{name}_{number}");
            number += 1;
        }
        given
    }

    /// The same for an identifier.
    pub(super) fn give_ident(&mut self, wanted: &Ident) -> Ident {
        ident(&self.give(&wanted.unraw().to_string()))
    }
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
    }

    #[test]
    fn names_of_modules_packages_and_types() {
        assert_eq!(snake_case("RelayUnit"), "relay_unit");
        assert_eq!(snake_case("HTTPServer2Go"), "http_server2_go");
        assert_eq!(kebab_case("SmartGrid"), "smart-grid");
        assert_eq!(kebab_case("_"), "federate");
        assert_eq!(pascal_case("unit_a"), "UnitA");
        assert_eq!(pascal_case("3d"), "_3d");
    }

    #[test]
    fn a_name_is_never_given_twice() {
        let mut names = Names::reserving(&["federate"]);
        assert_eq!(names.give("federate"), "federate_2");
        assert_eq!(names.give("a"), "a");
        assert_eq!(names.give("a"), "a_2");
        assert_eq!(names.give_ident(&ident("type")).to_string(), "r#type");
    }
}
