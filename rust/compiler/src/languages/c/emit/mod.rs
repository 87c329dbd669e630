// SPDX-License-Identifier: Apache-2.0
//! From a plan to C: a file per reactor class, and the crate of Rust that runs them.

mod beside;
mod class;
mod class_file;
mod compilation;
mod counterparts;
mod cpp;
mod crates;
mod external;
mod header;
mod parameters;
mod program;
mod reactions;
mod sizes;
mod storage;
mod structs;
mod symbols;
mod text;
mod types;
mod words;

pub(in crate::languages) use beside::Beside;
pub(in crate::languages) use crates::{emit, workspace};
pub(in crate::languages) use sizes::Sizes;
