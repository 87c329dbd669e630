// SPDX-License-Identifier: Apache-2.0
//! Blocks and words of C.

mod code_block;
mod names;

pub(super) use code_block::{problem, skip};
pub(super) use names::problem as name_problem;
