// SPDX-License-Identifier: Apache-2.0
//! Unique names of generated files, packages and other elements.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

/// Returns the text with all characters replaced that cannot be in an identifier.
pub(crate) fn plain(text: &str) -> String {
    let mut plain: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_digit()) || plain.is_empty() {
        plain.insert(0, '_');
    }
    plain
}

/// Converts a name to snake case: `RelayUnit` becomes `relay_unit`, `HTTPServer` becomes `http_server`.
pub(crate) fn snake_case(name: &str) -> String {
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

/// Converts a name to kebab case: `RelayUnit` becomes `relay-unit`.
fn kebab_case(name: &str) -> String {
    let kebab: Vec<String> = snake_case(name).split('_').filter(|word| !word.is_empty()).map(str::to_owned).collect();
    if kebab.is_empty() { "federate".to_owned() } else { kebab.join("-") }
}

/// Names that no package can have, because cargo has folders, Rust has keywords or crates, or some system has devices
/// of these names.
const NO_PACKAGES: [&str; 36] = [
    "alloc",
    "as",
    "async",
    "aux",
    "await",
    "build",
    "con",
    "core",
    "crate",
    "deps",
    "dyn",
    "enum",
    "examples",
    "fn",
    "impl",
    "incremental",
    "let",
    "lf",
    "loop",
    "match",
    "mod",
    "move",
    "nul",
    "postcard",
    "prn",
    "proc-macro",
    "pub",
    "rustapp",
    "serde",
    "std",
    "test",
    "trait",
    "type",
    "unsafe",
    "use",
    "where",
];

/// Returns the name of the package and of the program of a participant, whose own name may be missing:
/// `smart-grid-unit-a`. It differs from all `crates`, on which the package depends.
pub(crate) fn package_name<'c>(
    program: &str,
    participant: Option<&str>,
    crates: impl Iterator<Item = &'c str>,
) -> String {
    let mut name = kebab_case(program);
    if let Some(participant) = participant {
        name = name + "-" + &kebab_case(participant);
    }
    let is_crate = |name: &str| crates.map(|one| one.replace('_', "-")).any(|one| one == name);
    let is_taken = NO_PACKAGES.contains(&name.as_str()) || name.starts_with("lf-") || is_crate(&name);
    if is_taken || name.starts_with(|first: char| first.is_ascii_digit()) {
        name.insert_str(0, "program-");
    }
    shortened(&name, '-')
}

/// Returns a name that is short enough for files and build tools: a number replaces the rest of a long one.
pub(crate) fn shortened(name: &str, separator: char) -> String {
    const LENGTH_MAX: usize = 60;
    const KEPT: usize = 40;
    if name.len() <= LENGTH_MAX {
        return name.to_owned();
    }
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    let kept: String = name.chars().take(KEPT).collect();
    format!("{}{separator}{:016x}", kept.trim_end_matches(separator), hasher.finish())
}

/// A set of unique names.
#[derive(Default)]
pub(crate) struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// Returns a set that excludes these names.
    pub(crate) fn reserving(names: &[&str]) -> Self {
        Self { taken: names.iter().map(|name| (*name).to_owned()).collect() }
    }

    /// Returns the name itself, or with a number if it is taken.
    pub(crate) fn give(&mut self, name: &str) -> String {
        let mut given = name.to_owned();
        let mut number = 2;
        while !self.taken.insert(given.clone()) {
            given = format!("{name}_{number}");
            number += 1;
        }
        given
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_modules_and_packages() {
        assert_eq!(snake_case("RelayUnit"), "relay_unit");
        assert_eq!(snake_case("HTTPServer2Go"), "http_server2_go");
        assert_eq!(kebab_case("SmartGrid"), "smart-grid");
        assert_eq!(kebab_case("_"), "federate");
    }

    #[test]
    fn packages_have_names_that_cargo_takes() {
        let name = |program: &str| package_name(program, None, ["serde", "my_crate"].into_iter());
        for (program, expected) in [
            ("SmartGrid", "smart-grid"),
            ("2Motors", "program-2-motors"),
            ("Build", "program-build"),
            ("-dash", "dash"),
            ("Serde", "program-serde"),
            ("MyCrate", "program-my-crate"),
            ("lf_linux", "program-lf-linux"),
            ("Über.max", "ber-max"),
        ] {
            assert_eq!(name(program), expected);
        }
        let (one, other) = (name(&"a".repeat(90)), name(&"a".repeat(91)));
        assert!(one.len() <= 60 && one != other, "{one} {other}");
        assert_eq!(package_name("Std", Some("a"), [].into_iter()), "std-a");
    }

    #[test]
    fn a_name_is_never_given_twice() {
        let mut names = Names::reserving(&["federate"]);
        assert_eq!(names.give("federate"), "federate_2");
        assert_eq!(names.give("a"), "a");
        assert_eq!(names.give("a"), "a_2");
    }
}
