// SPDX-License-Identifier: Apache-2.0
//! Bytes and messages of the Lingua Franca federation protocol.
//!
//! The protocol has no version field, so every dialect is a module of its own that keeps its numbers and layouts
//! together; [`june_2026`] is the one that the stock C runtime spoke in June 2026. What the dialects share is here:
//! raw tags, the owner's limits, errors, and the two stream buffers.
//!
//! This crate knows no time, no sockets and no order of messages: it says what bytes mean, not whether they may come now.
//! It never allocates, never panics on bytes from a peer, and never believes a length before it was checked.
#![no_std]
#![forbid(unsafe_code)]

mod buffer;
mod bytes;
mod error;
pub mod june_2026;
mod limits;
mod tag;

pub use buffer::{InBuffer, OutBuffer};
pub use error::{Beyond, DecodeError, EncodeError, NoRoom, PushError};
pub use limits::Limits;
pub use tag::Tag;
