// SPDX-License-Identifier: Apache-2.0
//! Bodies in Rust: methods of a struct per reactor, in a module per LF file.

mod bodies;
mod file_module;
mod items;
mod layout;
mod payloads;
mod prelude;
mod program;
mod reactor;
mod scope;
mod sending;

pub(super) use bodies::RustBodies;
