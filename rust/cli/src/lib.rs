// SPDX-License-Identifier: Apache-2.0
//! The parts of the `lfz` program.
//!
//! `args` is the command line, `commands` implements each command, `compile` makes executables from an LF file,
//! `debug_info` leads debuggers from them to it, `federation` describes a run of them, and `supervisor` runs and ends
//! its processes together, as `control` asks; `trace` converts recordings of runs, `graph` draws programs, and `lsp`
//! serves editors.
#![forbid(unsafe_code)]

pub mod args;
mod codes;
mod commands;
mod compile;
mod control;
mod debug_info;
mod descendants;
mod edges;
mod failure;
mod federation;
mod graph;
mod guard;
mod home;
mod keys;
mod lsp;
mod pins;
mod private_files;
mod replace;
mod supervisor;
mod terminal;
mod time;
mod trace;
mod virtual_network;
mod watch;

pub use commands::execute;
