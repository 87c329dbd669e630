// SPDX-License-Identifier: Apache-2.0
//! The tests of the program `lfz`. One program is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod add;
mod advice;
mod bodies;
mod c_code;
mod c_library;
mod c_mistakes;
mod c_workers;
mod check;
mod cmake;
mod crates;
mod debugging;
mod descendants;
mod doctor;
mod fmt;
mod graph;
mod keys;
mod lfc_rust;
mod lsp;
mod lsp_bodies;
mod lsp_features;
mod micro;
mod new;
mod output;
mod package;
mod paths;
mod protobufs;
mod side_by_side;
mod streams;
mod supervise;
mod support;
mod test_command;
mod trace_memory;
mod watch;
