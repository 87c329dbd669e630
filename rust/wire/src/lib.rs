// SPDX-License-Identifier: Apache-2.0
//! Bytes and messages of the Lingua Franca federation protocol.
//!
//! A message is independent of its bytes. Its form on the wire belongs to a dialect, a module with all numbers and
//! layouts, because the protocol has no version field: `stock` is the dialect of LF's C runtime in the releases 0.12
//! and 0.13. A program uses one dialect, which is chosen here and named nowhere else.
//!
//! This crate knows no time, no sockets and no order of messages: it decodes bytes, and does not decide whether a
//! message may come now. It never allocates, never panics on bytes from a peer, and never uses a length before it has
//! checked it.
//!
//! ```
//! use lf_wire::{InBuffer, Limits, Message, OutBuffer, Tag};
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
#![allow(clippy::doc_markdown, reason = "messages are called by their names in the protocol, which are no code")]

mod buffer;
mod bytes;
mod decoded;
mod error;
mod limits;
mod message;
mod neighbors;
mod reject;
mod stock;
mod stream;
mod tag;
mod types;
mod values;

/// The dialect of this program.
use stock as dialect;

pub use buffer::{InBuffer, OutBuffer, Storage};
pub use decoded::{Decoded, Destination};
#[cfg(feature = "transients")]
pub use dialect::decode_to_transient;
pub use dialect::{
    IntroductionHeader, QueryEnd, decode, decode_expected, destination_in_header, message_bytes_max, tag_in_header,
};
pub use error::{DecodeError, EncodeError, LengthOverflow, NoRoom, PushError};
pub use limits::Limits;
pub use message::Message;
pub use neighbors::{DELAY_NONE, Downstream, NeighborStructure, Upstream};
pub use reject::RejectCode;
pub use tag::Tag;
pub use types::MessageType;
pub use values::*;
