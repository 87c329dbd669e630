// SPDX-License-Identifier: Apache-2.0
//! Blocks and words of Rust.

mod code_block;
mod code_syntax;
mod nesting;
mod words;

pub(super) use code_block::skip;
pub(crate) use code_syntax::byte_of;
pub(super) use code_syntax::problem;
pub(super) use words::problem as name_problem;
pub(crate) use words::{NEVER, is_plain, raw};
