// SPDX-License-Identifier: Apache-2.0
//! The event loop of a federate, made of parts that do not know each other's insides:
//!
//! - the [`session`] with the RTI: its connection, and what the machine has to say;
//! - the [`peers`]: connections with other federates past the RTI, of which there are [`outbound`] and [`inbound`]
//!   ones, and [`visitors`] that have not said who they are;
//! - one [`receiver`] for what comes on any of them, with a policy for what comes [`from_rti`], and one for what comes
//!   [`from_peer`]s, which [`direct`] does;
//! - the [`execution`] of tags, which sends to an [`output`];
//! - [`waiting`], which says what this federate waits for, and [`late`], which counts what has come too late.
//!
//! The [`event_loop`] calls them in order.

mod clock_sync;
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
mod visitors;
mod waiting;

pub use event_loop::FederateLoop;
pub use inbound::Inbound;
pub use join::Join;
pub use memory::Buffers;
pub use outbound::Outbound;
pub use reason::Reason;
pub(crate) use reason::{Advice, Words};
