// SPDX-License-Identifier: Apache-2.0
//! The RTI (run-time infrastructure): the centre of a federation.
//!
//! It lets the federates in, chooses one start time for them, forwards their messages, and grants tags such that no
//! message can still come for a granted tag. The owner accepts connections, reads and writes them, and calls:
//!
//! - [`Rti::handle_connect`] for every new connection; [`Rti::evict`] when all connections are in use;
//! - [`Rti::handle_input`] for the bytes that have been read, as long as it consumes something: at most one message per
//!   call;
//! - [`Rti::handle_writable`] when something that was pending on a connection has been sent; after it, offer again the
//!   input that is [`Verdict::Blocked`] by that connection, and after input, what is [`Verdict::Held`] for it;
//! - [`Rti::handle_end`] when nothing more will come on a connection, though bytes that have come may still wait; and
//!   [`Rti::handle_disconnect`] when all complete messages have been consumed, too;
//! - [`Rti::poll_exchange`] after each input, and at [`Rti::poll_exchange_timeout`], until it returns `None`;
//! - [`Rti::poll_round`] and [`Rti::handle_datagram`] for clock synchronization over UDP;
//! - [`Rti::handle_timeout`] at [`Rti::poll_timeout`].
//!
//! It answers through the [`Outlet`], within these calls. [`Rti::status`] returns when it is over.
//!
//! The owner provides all memory as [`RtiStorage`], whatever the peers do. Grants and DNETs are never queued: the RTI
//! computes them when there is room to send them. A message to many federates is a flag for each. A message that needs
//! a reply, or has to be forwarded, is not consumed before there is room for that.
//!
//! [`Rti::suspend`] and [`Rti::resume`] serve searches through all reachable states.
//!
//! A NET or LTC costs a step for each federate that is directly or indirectly upstream or downstream of its sender (see
//! `earliest`), and nothing for the others; a forwarded message costs a look at its destination, unless it changes a
//! next event.
//!
//! # Parts
//!
//! [`Rti`] consists of parts, each with a state of its own: the federates and their connections (`members`), their tags
//! (`tags`, with the grants in `grants`, the `graph` between them and the messages `in_transit`), stops (`stop`), the
//! start (`barrier`), the exchanges and rounds of clock synchronization (`exchange`, `clock_sync`) and reports of waits
//! (`watch`). A step that concerns several parts borrows them: `handshake` those that admit a federate, `sending` the
//! members, their tags and the outlet. `machine` handles what concerns all of them: how federates leave. Flow control
//! (`window`) has the window of all. `transients` handles federates that come and go; `admission` decides which ids
//! may join, `limits` has effective starts and the limits of grants, and `notifications` informs the neighbors.

#![cfg_attr(
    not(feature = "transients"),
    expect(clippy::unused_self, reason = "some answers depend on transient federates alone")
)]

#[cfg(feature = "transients")]
mod admission;
mod barrier;
mod clock_sync;
mod config;
mod delay;
mod earliest;
mod exchange;
mod grants;
mod graph;
mod handshake;
#[cfg(feature = "transients")]
mod horizon;
mod idle;
mod in_transit;
#[cfg(feature = "transients")]
mod incarnation;
mod input;
#[cfg(feature = "transients")]
mod limits;
mod log_event;
mod machine;
mod members;
#[cfg(feature = "transients")]
mod notifications;
mod outcome;
mod outlet;
mod path;
#[cfg(test)]
mod samples;
mod search;
mod sending;
mod stop;
mod storage;
mod strangers;
mod suspected_violation;
mod suspend;
mod tag_state;
mod tags;
mod timing;
#[cfg(feature = "transients")]
mod transients;
mod waits;
mod watch;
mod window;

pub use clock_sync::Datagram;
pub use config::{
    AfterLoss, CLOCK_SYNC_TRIALS, CLOCK_TIME_OUT, CONNECTION_TIME_OUT, ClockSync, Config, FEDERATION_ID_DEFAULT,
    START_BARRIER_TIME_OUT, START_DELAY, STOP_REPLY_TIME_OUT, SetupError,
};
pub use graph::Node;
pub use log_event::{Cause, RtiEvent, Violation};
pub use machine::Rti;
pub use outcome::{Outcome, Status};
pub use outlet::{ConnectionId, Outlet, Verdict};
pub use path::PathWords;
pub use storage::{Connection, RtiStorage, Slot};
pub use suspected_violation::{CLOCK_MAX, CLOCK_MIN, SuspectedViolation};
pub use suspend::Suspended;
pub use waits::{Progress, Waits};
pub use watch::START_REPORT;
