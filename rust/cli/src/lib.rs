// SPDX-License-Identifier: Apache-2.0
//! The parts of the `lfz` program.
#![forbid(unsafe_code)]

pub mod supervisor;
