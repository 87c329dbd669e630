// SPDX-License-Identifier: Apache-2.0
//! Bytes and messages of the Lingua Franca federation protocol.
//!
//! The protocol has no version field, so every dialect is a module of its own that keeps its numbers and layouts
//! together; [`june_2026`] is the one that the stock C runtime spoke in June 2026. What the dialects share is here:
//! raw tags, the owner's limits, errors, and the two stream buffers.
//!
//! This crate knows no time, no sockets and no order of messages: it says what bytes mean, not whether they may come
//! now. It never allocates, never panics on bytes from a peer, and never believes a length before it was checked.
//!
//! ```
//! use lf_wire::june_2026::Message;
//! use lf_wire::{InBuffer, Limits, OutBuffer, Tag};
//!
//! let mut out = OutBuffer::new([0; 64]);
//! out.push(&Message::NextEventTag(Tag::new(1_000, 0)))?;
//! let bytes = out.pending(); // To be written to the socket.
//!
//! let limits = Limits { payload_bytes_max: 32, federation_id_bytes_max: 32, neighbors_max: 2 };
//! let mut buffer = InBuffer::new([0; 64]);
//! for piece in bytes.chunks(5) {
//!     buffer.space()[..piece.len()].copy_from_slice(piece); // As read from a socket.
//!     buffer.filled(piece.len());
//!     while let Some((message, len)) = buffer.next(&limits)? {
//!         assert_eq!(message, Message::NextEventTag(Tag::new(1_000, 0)));
//!         buffer.consume(len);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod buffer;
mod bytes;
mod error;
pub mod june_2026;
mod limits;
mod tag;

pub use buffer::{InBuffer, OutBuffer, Storage};
pub use error::{Beyond, DecodeError, EncodeError, NoRoom, PushError};
pub use limits::Limits;
pub use tag::Tag;
