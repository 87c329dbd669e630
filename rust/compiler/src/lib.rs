// SPDX-License-Identifier: Apache-2.0
//! Lingua Franca source to plan to Rust crates, Kconfig fragments and overlays.
//!
//! The way of a program: `syntax` parses, `resolve` follows imports and checks every reactor by itself, `instances`
//! builds the tree of instances, `federates` cuts it, `analysis` works out orders and capacities, and the result is
//! a [`plan`]. Nothing in here reads or writes files: texts come from a [`SourceProvider`].
#![forbid(unsafe_code)]

mod analysis;
pub mod characters;
mod compilation;
pub mod deployment;
pub mod diagnostics;
pub mod emit;
mod federates;
mod instances;
mod languages;
pub mod maxwait;
pub mod names;
pub mod plan;
mod resolve;
mod stack;
mod syntax;
pub mod tables;
mod yaml;
mod zephyr;

pub use analysis::NETWORK_CAPACITY;
pub use compilation::{Compilation, compile};
pub use diagnostics::{Code, Diagnostic, Diagnostics, Severity, Style};
pub use resolve::{SourceProvider, Supported, TargetProperty, supported};
pub use yaml::FileError;
