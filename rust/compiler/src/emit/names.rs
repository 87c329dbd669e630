// SPDX-License-Identifier: Apache-2.0
//! Names of generated files, packages and other things, which are never given twice.

use std::collections::BTreeSet;

/// The text with everything that cannot be in an identifier replaced.
pub(crate) fn plain(text: &str) -> String {
    let mut plain: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_digit()) || plain.is_empty() {
        plain.insert(0, '_');
    }
    plain
}

/// `RelayUnit` becomes `relay_unit`, `HTTPServer` becomes `http_server`.
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

/// `RelayUnit` becomes `relay-unit`: the name of a package or a program.
pub(crate) fn kebab_case(name: &str) -> String {
    let kebab: Vec<String> = snake_case(name).split('_').filter(|word| !word.is_empty()).map(str::to_owned).collect();
    if kebab.is_empty() { "federate".to_owned() } else { kebab.join("-") }
}

/// Names that are given once each.
#[derive(Default)]
pub(crate) struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// Names that must not be given.
    pub(crate) fn reserving(names: &[&str]) -> Self {
        Self { taken: names.iter().map(|name| (*name).to_owned()).collect() }
    }

    /// The name itself, or with a number where it has been given before.
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
    fn a_name_is_never_given_twice() {
        let mut names = Names::reserving(&["federate"]);
        assert_eq!(names.give("federate"), "federate_2");
        assert_eq!(names.give("a"), "a");
        assert_eq!(names.give("a"), "a_2");
    }
}
