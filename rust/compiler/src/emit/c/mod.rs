// SPDX-License-Identifier: Apache-2.0
//! Bodies in C: functions in a file per reactor class, with ports and state where C sees them.

mod bodies;
mod class;
mod class_file;
mod counterparts;
mod cpp;
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

pub(super) use bodies::CBodies;
