// SPDX-License-Identifier: Apache-2.0
//! Rust names for LF names: the same wherever Rust allows it, raw where it is a keyword.

use proc_macro2::{Ident, Span};
use syn::ext::IdentExt;

use crate::emit::names::{Names, plain};

/// Keywords that cannot be written as `r#word` either.
const NEVER: [&str; 5] = ["self", "Self", "super", "crate", "_"];

/// What no variable of a body can be called, because bodies have it in sight and patterns can name it.
const KNOWN: [&str; 6] = ["None", "Some", "Ok", "Err", "Asap", "After"];

/// Rust's types that have no path.
pub(super) const PRIMITIVES: [&str; 17] = [
    "bool", "char", "f32", "f64", "i128", "i16", "i32", "i64", "i8", "isize", "str", "u128", "u16", "u32", "u64", "u8",
    "usize",
];

/// What Rust code sees of its standard library without asking for it.
pub(super) const KNOWN_TYPES: [&str; 38] = [
    "AsMut",
    "AsRef",
    "AsyncFn",
    "AsyncFnMut",
    "AsyncFnOnce",
    "Box",
    "Clone",
    "Copy",
    "Debug",
    "Default",
    "DoubleEndedIterator",
    "Drop",
    "Eq",
    "Err",
    "ExactSizeIterator",
    "Extend",
    "Fn",
    "FnMut",
    "FnOnce",
    "From",
    "FromIterator",
    "Hash",
    "Into",
    "IntoIterator",
    "Iterator",
    "None",
    "Ok",
    "Option",
    "Ord",
    "PartialEq",
    "PartialOrd",
    "Result",
    "Send",
    "Some",
    "String",
    "Sync",
    "ToString",
    "Vec",
];

/// What bodies see of this project without asking for it, on any platform.
pub(super) const PRELUDE: [&str; 33] = [
    "After",
    "Asap",
    "Duration",
    "EventTag",
    "FixedPayload",
    "Instant",
    "LogicalAction",
    "Multiport",
    "MultiportMut",
    "Offset",
    "Payload",
    "PhysicalAction",
    "PhysicalActionRef",
    "PhysicalLink",
    "Port",
    "ReactionContext",
    "SpawnPhysicalThread",
    "Timer",
    "Watchdog",
    "after",
    "assert_tag_is",
    "debug",
    "delay",
    "device",
    "error",
    "heapless",
    "info",
    "log",
    "payload",
    "println",
    "tag",
    "trace",
    "warn",
];

/// Whether a name is an identifier as it stands. The parser does not know the newest word of Rust.
pub(super) fn is_plain(name: &str) -> bool {
    name != "gen" && syn::parse_str::<Ident>(name).is_ok()
}

/// The identifier for a name; raw for a keyword.
pub(super) fn ident(name: &str) -> Ident {
    let name = name.strip_prefix("r#").unwrap_or(name);
    if is_plain(name) {
        return Ident::new(name, Span::call_site());
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
    if NEVER.contains(&name) || is_plain(name) { name.to_owned() } else { format!("r#{name}") }
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
        assert_eq!([raw("in"), raw("inp"), raw("self")], ["r#in", "inp", "self"]);
        assert_eq!(give(&mut Names::default(), &ident("type")).to_string(), "r#type");
    }

    #[test]
    fn all_that_bodies_see_is_known() {
        let texts = [
            include_str!("../../../../model/src/lib.rs"),
            include_str!("../../../../linux/src/lib.rs"),
            include_str!("../../../../zephyr/src/lib.rs"),
        ];
        for text in texts {
            let items = &text[text.find("pub mod prelude {").expect("each has a prelude")..];
            let items = &items[..items.find("\n}").expect("it ends")];
            let uses = items.split(';').filter_map(|item| item.rsplit_once("pub use ").map(|(_, item)| item));
            let names = uses.flat_map(|item| {
                let listed = item.split_once('{').map(|(_, list)| list.trim_end_matches('}'));
                listed.unwrap_or_else(|| item.rsplit("::").next().unwrap_or(item)).split(',').map(str::trim)
            });
            for name in names.filter(|name| !["", "*", "self", "eprint", "eprintln", "print"].contains(name)) {
                assert!(PRELUDE.contains(&name), "{name}");
            }
        }
    }

    #[test]
    fn names_of_types() {
        assert_eq!(pascal_case("unit_a"), "UnitA");
        assert_eq!(pascal_case("3d"), "_3d");
    }
}
