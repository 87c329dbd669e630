// SPDX-License-Identifier: Apache-2.0
//! What a participant records of itself: tags, reactions, messages, grants and waits, in records of one size.
//!
//! The event loops tell [`Platform::trace`](crate::platform::Platform::trace), which keeps [`Record`]s or nothing.
//! Records have numbers in place of names; the compiler's table has the names. Without the feature `traces` no event
//! loop tells anything, and nothing of this is linked.

mod event;
mod record;
mod ring;

pub use event::{Event, Patience, RTI, Subject, TRACES, Waits, Word};
pub use record::{Damage, FORMAT, Header, MAGIC, RECORD_BYTES, Record, Role};
pub use ring::Ring;
