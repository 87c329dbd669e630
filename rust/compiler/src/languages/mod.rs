// SPDX-License-Identifier: Apache-2.0
//! The languages of reaction bodies, chosen by the target declaration.
//!
//! All that the compiler asks of one is in [`Language`]; a new one is a folder here and a place in [`ALL`].

mod c;
mod integer;
mod language;
mod lexical;
mod rust;

pub(crate) use language::{
    BlockEnd, CodeKind, CodeProblem, Language, LiteralKind, PlaceInPreamble, Preambles, Unsendable,
};

/// Those that there are. The first is the one that texts without a target are read in.
const ALL: [&dyn Language; 2] = [&rust::Rust, &c::C];

/// The language that a target declaration names.
pub(crate) fn named(name: &str) -> Option<&'static dyn Language> {
    let mut all = ALL.into_iter();
    all.find(|language| {
        [&[language.name()], language.aliases()].concat().iter().any(|it| it.eq_ignore_ascii_case(name))
    })
}

/// The language of what does not say its target.
pub(crate) fn default() -> &'static dyn Language {
    ALL[0]
}

/// The names of all, with the other ones that they have.
pub(crate) fn all_names() -> impl Iterator<Item = &'static str> {
    ALL.into_iter().flat_map(|language| [language.name()].into_iter().chain(language.aliases().iter().copied()))
}

/// The names of all, for people.
pub(crate) fn names() -> String {
    let names: Vec<String> = all_names().map(|name| format!("`{name}`")).collect();
    let (last, others) = names.split_last().unwrap_or_else(|| unreachable!("there are languages"));
    if others.is_empty() { last.clone() } else { format!("{} or {last}", others.join(", ")) }
}
