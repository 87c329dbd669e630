// SPDX-License-Identifier: Apache-2.0
//! The crate of a participant without its bodies: tables, queues, `Program`, RTI, entry point and manifest.
//!
//! No code in this module depends on a language; [`Bodies`] provides the parts that differ between languages.

mod arms;
mod beside;
mod bodies;
mod class;
mod compilation;
mod compiler_words;
mod crates;
mod description;
mod federate;
mod identifiers;
mod levels;
mod manifest;
mod module;
mod owner;
mod places;
mod print;
mod program;
mod rti;
mod sending;
mod splice;
mod symbols;
mod tables;

pub(super) use arms::merge_cases;
pub(super) use beside::Beside;
pub(super) use bodies::{Bodies, Member, Members, NativeParts, Output, ReactionPart, tokens};
pub(super) use class::GivenValue;
pub(super) use compilation::CompilerArguments;
pub(super) use crates::emit;
pub(super) use identifiers::ident;
pub(super) use manifest::of_workspace;
pub(super) use print::interval;
pub(super) use program::push_methods;
pub(super) use sending::{SentPort, copied_ports, sent_ports, serializer_type};
pub(super) use splice::Splices;
pub(super) use symbols::{Owner, numbers};
pub(super) use tables::ids;
