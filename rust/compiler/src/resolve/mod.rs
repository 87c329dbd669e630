// SPDX-License-Identifier: Apache-2.0
//! From files to checked reactors: imports, target properties, names, types, connections and reactions.
//!
//! Every reactor is checked by itself here, with what its contained reactors declare; what depends on the tree of
//! instances comes later. Nothing here reads files: [`SourceProvider`] does.

mod attributes;
mod checker;
mod class;
mod connection;
mod load;
mod mains;
mod model;
mod names;
mod reaction;
mod reactors;
mod target;
mod time_value;
mod types;
mod unsupported;
mod value;

pub(crate) use attributes::CAPACITY_MAX;

pub use load::SourceProvider;
pub(crate) use load::{Program, load};
pub(crate) use mains::program_name;
pub(crate) use model::{Class, ClassId, PortRef, ReactionParameter, Variable, Wait};
pub(crate) use reaction::signature;
pub(crate) use reactors::check;
pub(crate) use target::check as check_target;

/// All parts of LF that are refused by name, each with what to do instead, in Markdown.
pub fn refused() -> Vec<(String, String)> {
    let list = |names: &mut dyn Iterator<Item = &str>| names.collect::<Vec<_>>().join("`, `");
    let features =
        unsupported::Feature::ALL.iter().map(|feature| (feature.name().to_owned(), feature.instead().to_owned()));
    let attributes = list(&mut attributes::UNSUPPORTED.iter().copied());
    let properties = list(&mut target::REFUSED.iter().map(|(name, _)| *name));
    let removed = [
        (format!("the attributes `@{}`", attributes.replace("`, `", "`, `@")), "remove them".to_owned()),
        (format!("the target properties `{properties}`"), "the error says what to do instead of each".to_owned()),
    ];
    features.chain(removed).collect()
}
