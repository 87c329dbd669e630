// SPDX-License-Identifier: Apache-2.0
//! The event loop of a federate. It consists of parts that do not know each other's insides:
//!
//! - the [`session`] with the RTI: its connection, and the messages of the machine;
//! - the [`peers`]: direct connections with other federates, of which there are [`outbound`] and [`inbound`] ones, and
//!   an [`accept_queue`] for peers that have not sent their id;
//! - one [`receiver`] for messages of any of them, with a policy for those [`from_rti`], and one for those
//!   [`from_peer`]s, which [`direct`] uses;
//! - the [`execution`] of tags, which sends to an [`output`];
//! - [`waiting`], which logs what this federate waits for, and [`late`], which counts messages that have come too late.
//!
//! The [`event_loop`] calls them in order.

mod accept_queue;
mod clock_sync;
mod deadlock;
mod direct;
mod event_loop;
mod execution;
mod from_peer;
mod from_rti;
mod held;
mod inbound;
mod join;
mod late;
mod memory;
mod outbound;
mod output;
mod peers;
mod reason;
mod receiver;
mod session;
#[cfg(feature = "transients")]
mod transients;
mod waiting;

pub use event_loop::FederateLoop;
pub use inbound::Inbound;
pub use join::Join;
pub use memory::Buffers;
pub use outbound::Outbound;
pub use reason::Reason;
pub(crate) use reason::{Advice, ReasonText};
