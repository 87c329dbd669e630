// SPDX-License-Identifier: Apache-2.0
//! Compiles Lingua Franca sources to a plan, and the plan to Rust crates, Kconfig fragments and overlays.
//!
//! Four functions answer questions about a program:
//!
//! - [`parse`] returns the tree of one file with all its errors. It never fails: unreadable code becomes a diagnostic,
//!   and the tree has the rest.
//! - [`names`] returns the meaning of each name in a program: its declaration, with kind, type and comment. The program
//!   may have any errors.
//! - [`format`] returns the text of a file as others are written.
//! - [`compile`] returns the [`plan`] of a correct program, and all diagnostics of an incorrect one.
//!
//! The stages of a program: `syntax` parses, `resolve` follows imports and checks every reactor by itself, `instances`
//! builds the tree of instances, `federates` partitions it, `analysis` computes orders and capacities, and the result
//! is a [`plan`]. The crate neither reads nor writes files: texts come from a [`SourceProvider`].
#![forbid(unsafe_code)]

mod analysis;
mod arena;
mod boards;
pub mod characters;
mod compilation;
pub mod deployment;
pub mod diagnostics;
mod elaborated;
pub mod emit;
mod federates;
mod format;
mod instances;
mod languages;
mod lexical;
pub mod maxwait;
mod names;
pub mod plan;
mod resolve;
mod stack;
pub mod syntax;
pub mod tables;
pub mod trace_names;
mod yaml;
mod zephyr;

pub use analysis::NETWORK_CAPACITY;
pub use compilation::{Compilation, SyntaxTree, compile, parse};
pub use diagnostics::{Code, Diagnostic, Diagnostics, Severity, Style};
pub use format::format;
pub use names::{Declaration, NameKind, ResolvedNames, names};
pub use resolve::{PropertyScope, SourceProvider, Supported, TargetProperty, supported};
pub use yaml::FileError;
pub use zephyr::KEYS_HEADER;
