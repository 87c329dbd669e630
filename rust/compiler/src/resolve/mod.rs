// SPDX-License-Identifier: Apache-2.0
//! Checks the reactors in files: imports, target properties, names, types, connections and reactions.
//!
//! Every reactor is checked by itself, with the declarations of its contained reactors; checks that depend on the tree
//! of instances come later. This module reads no files: [`SourceProvider`] does.

mod attributes;
mod checker;
mod class;
mod code;
mod connection;
mod crates;
mod expand;
mod linking;
mod load;
mod macros;
mod mains;
mod model;
mod modes;
mod names;
mod native;
mod of_main;
mod options;
mod paths;
mod properties;
mod reaction;
mod reactors;
mod reader;
mod sending;
mod sources;
mod supported;
mod target;
mod time_value;
mod types;
mod unsupported;
mod value;

pub(crate) use attributes::CAPACITY_MAX;
pub(crate) use code::check as check_code;

pub(crate) use connection::type_mismatch;
pub(crate) use expand::expand;
pub(crate) use load::{Program, ReactorId, Unit, alone, load};
pub(crate) use mains::program_name;
pub(crate) use model::{
    CheckedConnection, CheckedMethod, CheckedPort, CheckedReaction, Class, ClassId, ConnectionEnd, Given, PortRef,
    ReactionVariable, Sending, Variable, Wait,
};
pub(crate) use properties::is_of_federations;
pub use properties::{PropertyScope, TargetProperty};
pub(crate) use reaction::signature;
pub(crate) use reactors::check;
pub use sources::SourceProvider;
pub use supported::{Supported, supported};
pub(crate) use target::check as check_target;
