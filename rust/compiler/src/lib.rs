// SPDX-License-Identifier: Apache-2.0
//! Lingua Franca source to plan to Rust crates, Kconfig fragments and overlays.
//!
//! Three functions answer what others ask of a program:
//!
//! - [`parse`] returns the tree of one file with all that is wrong in it. It never fails: what it cannot read becomes a
//!   diagnostic, and the tree has the rest.
//! - [`names`] returns what each name of a program means: where it is declared, as what, with which type and comment.
//!   The program may be wrong in any way.
//! - [`compile`] returns the [`plan`] of a program that is right, and all diagnostics of one that is not.
//!
//! The way of a program: `syntax` parses, `resolve` follows imports and checks every reactor by itself, `instances`
//! builds the tree of instances, `federates` cuts it, `analysis` works out orders and capacities, and the result is
//! a [`plan`]. Nothing in here reads or writes files: texts come from a [`SourceProvider`].
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
pub use names::{Declaration, NameKind, ResolvedNames, names};
pub use resolve::{PropertyScope, SourceProvider, Supported, TargetProperty, supported};
pub use yaml::FileError;
