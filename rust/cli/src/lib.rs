// SPDX-License-Identifier: Apache-2.0
//! The parts of the `lfz` program.
#![forbid(unsafe_code)]

pub mod args;
pub mod compile;
pub mod guard;
pub mod supervisor;
pub mod time;
