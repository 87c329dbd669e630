// SPDX-License-Identifier: Apache-2.0
//! Keywords of Rust, and names that a program cannot have.

use proc_macro2::Ident;

/// Keywords that cannot be written as `r#word` either.
pub(crate) const NEVER: [&str; 5] = ["self", "Self", "super", "crate", "_"];

/// Names that no variable of a body can have, because bodies see them and patterns can name them.
const KNOWN: [&str; 6] = ["None", "Some", "Ok", "Err", "Asap", "After"];

/// Returns whether a name is an identifier as it stands. The parser does not know the newest keyword of Rust.
pub(crate) fn is_plain(name: &str) -> bool {
    name != "gen" && syn::parse_str::<Ident>(name).is_ok()
}

/// Returns a name as code of the program spells it: keywords become raw identifiers.
pub(crate) fn raw(name: &str) -> String {
    if NEVER.contains(&name) || is_plain(name) { name.to_owned() } else { format!("r#{name}") }
}

/// Returns the reason why no item, variable or field can have this name, not even as a raw identifier, or no variable
/// of a body.
pub(crate) fn problem(name: &str, in_bodies: bool) -> Option<&'static str> {
    if in_bodies && ["self", "ctx"].contains(&name) {
        return Some("reaction bodies have a variable of this name");
    }
    if in_bodies && KNOWN.contains(&name) {
        return Some("reaction bodies know something else by this name");
    }
    NEVER.contains(&name).then_some("Rust does not allow this name")
}

#[cfg(test)]
mod tests {
    use super::raw;

    #[test]
    fn keywords_become_raw_and_everything_else_stays() {
        assert_eq!([raw("in"), raw("inp"), raw("self")], ["r#in", "inp", "self"]);
    }
}
