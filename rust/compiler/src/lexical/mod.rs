// SPDX-License-Identifier: Apache-2.0
//! The lexical properties of code in a target language, which need no parser of LF: the end of a block, its problems,
//! its words, and invalid names. The parser depends on this module; the module does not depend on LF's syntax.

mod blocks;
mod c;
mod code;
mod rust;

use core::fmt;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use code::CodeKind;
pub(crate) use code::{BlockEnd, CodeProblem};
pub(crate) use rust::{NEVER, byte_of, is_plain, raw};

/// A language of reaction bodies. The name in a target declaration chooses it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Language {
    /// `target Rust`. Texts without a target declaration have this language.
    #[default]
    Rust,
    /// `target C`, `target CCpp`, whose bodies are compiled as C++, and `target uC`, whose bodies use micro LF's API.
    C,
}

/// The name in a target declaration by which bodies are compiled as C++.
const CPP: &str = "CCpp";

/// The name in a target declaration by which bodies in C use the API of micro LF.
pub(crate) const MICRO: &str = "uC";

/// Returns whether bodies are compiled as C++ if the target declaration has this name.
pub(crate) fn is_cpp(target: &str) -> bool {
    target.eq_ignore_ascii_case(CPP)
}

/// Returns whether bodies use the API of micro LF if the target declaration has this name.
pub(crate) fn is_micro(target: &str) -> bool {
    target.eq_ignore_ascii_case(MICRO)
}

/// Returns whether a path is that of a file of micro LF.
pub(crate) fn is_micro_path(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ulf"))
}

impl Language {
    /// All languages.
    pub const ALL: [Self; 2] = [Self::Rust, Self::C];

    /// Returns the name in the target declaration.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rust => "Rust",
            Self::C => "C",
        }
    }

    /// Returns other names of the language in the target declaration.
    fn aliases(self) -> &'static [&'static str] {
        match self {
            Self::Rust => &[],
            Self::C => &[CPP, MICRO],
        }
    }

    /// Returns the language that a target declaration names.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|language| language.all_names().any(|own| own.eq_ignore_ascii_case(name)))
    }

    fn all_names(self) -> impl Iterator<Item = &'static str> {
        [self.name()].into_iter().chain(self.aliases().iter().copied())
    }

    /// Returns the names of all languages, including their aliases.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        Self::ALL.into_iter().flat_map(Self::all_names)
    }

    /// Returns the end of a code block in the text after its `{=`, ignoring strings and comments.
    pub(crate) fn block_end(self, text: &str) -> BlockEnd {
        blocks::block_end(text, self.skip())
    }

    /// Returns the problem with the syntax of a code block, as far as it is visible without the language's compiler.
    pub(crate) fn code_problem(self, text: &str, kind: CodeKind) -> Option<CodeProblem> {
        match self {
            Self::Rust => rust::problem(text, kind),
            Self::C => c::problem(text, kind),
        }
    }

    /// Returns the reason why a name of the program is invalid in generated code, or for the variables of bodies;
    /// `target` is the language's name in the target declaration.
    pub(crate) fn name_problem(self, name: &str, in_bodies: bool, target: &str) -> Option<&'static str> {
        match self {
            Self::Rust => rust::name_problem(name, in_bodies),
            Self::C => c::name_problem(name, in_bodies, is_cpp(target)),
        }
    }

    /// Returns the tokens of code: words, literals, comments, and single characters.
    pub(crate) fn pieces(self, code: &str) -> impl Iterator<Item = &str> {
        let (skip, mut at) = (self.skip(), 0);
        std::iter::from_fn(move || {
            let start = at;
            at = if start < code.len() { skip(code, start) } else { return None };
            Some(&code[start..at])
        })
    }

    /// Returns the words of code, outside of its strings and comments.
    pub(crate) fn words(self, code: &str) -> impl Iterator<Item = &str> {
        let is_word = |piece: &&str| piece.chars().all(|c| c.is_alphanumeric() || c == '_');
        let (mut pieces, mut at) = (self.pieces(code).peekable(), 0);
        std::iter::from_fn(move || {
            loop {
                let (start, first) = (at, pieces.next()?);
                at += first.len();
                if is_word(&first) {
                    // Letters outside of ASCII are tokens of their own.
                    while let Some(next) = pieces.next_if(is_word) {
                        at += next.len();
                    }
                    return Some(&code[start..at]);
                }
            }
        })
    }

    fn skip(self) -> blocks::Skip {
        match self {
            Self::Rust => rust::skip,
            Self::C => c::skip,
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Language;

    #[test]
    fn words_in_strings_and_comments_do_not_count() {
        for (language, code, found) in [
            (Language::Rust, "lf::devices::all()", true),
            (Language::Rust, "my_devices()", false),
            (Language::Rust, "\"devices\" // devices", false),
            (Language::Rust, "r#\"devices\"# /* devices */ 'd'", false),
            (Language::Rust, "devices\u{e9} \u{e9}devices", false),
            (Language::C, "devices[0]", true),
            (Language::C, "\"devices\" /* devices */", false),
        ] {
            assert_eq!(language.words(code).any(|word| word == "devices"), found, "{code}");
        }
    }

    #[test]
    fn a_target_declaration_names_a_language_in_any_case() {
        assert_eq!(
            ["rust", "C", "ccpp", "Python"].map(Language::named),
            [Some(Language::Rust), Some(Language::C), Some(Language::C), None]
        );
    }
}
