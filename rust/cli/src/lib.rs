// SPDX-License-Identifier: Apache-2.0
//! The parts of the `lfz` program.
//!
//! `args` is the command line, `commands` what each command does, `compile` the way from an LF file to executables,
//! `federation` what of them is to be run, and `supervisor` what runs all of that together and ends it together;
//! `trace` is what is made of what the parts of a run have recorded.
#![forbid(unsafe_code)]

pub mod args;
mod codes;
mod commands;
mod compile;
mod descendants;
mod edges;
mod failure;
mod federation;
mod guard;
mod pins;
mod supervisor;
mod terminal;
mod time;
mod trace;

pub use commands::execute;
