// SPDX-License-Identifier: Apache-2.0
//! The recording of a participant's events: tags, reactions, messages, grants and waits, in records of one size.
//!
//! An event loop with a [`Recording`] passes each [`Event`] to its [`Recorder`] as it happens. A recorder keeps
//! [`Record`]s: in a file, or in a ring in memory. Records have numbers instead of names; the compiler's table has the
//! names. An event loop without a recording reads no clock for it, and calls nothing; without the feature `traces` no
//! code of this module is linked.

mod event;
mod header;
mod record;
mod recording;
mod ring;

pub use event::{CHUNK_BYTES, Chunk, Event, RTI, TracedMessage, WaitLimit, Waits};
pub use header::{Damage, FORMAT, Header, MAGIC, RECORD_BYTES, Role};
pub use lf_wire::MessageType;
pub use record::Record;
#[cfg(feature = "traces")]
pub(crate) use recording::step_event;
pub(crate) use recording::waits;
pub use recording::{Recorder, Recording};
pub use ring::Ring;
