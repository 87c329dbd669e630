// SPDX-License-Identifier: Apache-2.0
//! Bodies in Rust: methods of a struct per reactor, in a module per LF file.

mod bodies;
mod calls;
mod file_module;
mod instances;
mod items;
mod layout;
mod payloads;
mod prelude;
mod reactor;
mod scope;
mod sending;

pub(super) use bodies::RustBodies;
