// SPDX-License-Identifier: Apache-2.0
//! The RTI (run-time infrastructure): the centre of a federation.
//!
//! It lets the federates in, gives them one start time, forwards their messages, and grants tags such that no message
//! can still come for what has been granted. The owner accepts connections, reads and writes them, and calls:
//!
//! - [`Rti::handle_connect`] for every new connection; [`Rti::make_way`] when there is no place for one;
//! - [`Rti::handle_input`] for what has been read, as long as it consumes something: at most one message per call;
//! - [`Rti::handle_writable`] when something that was pending on a connection has been sent; after it, input that is
//!   [`Verdict::Blocked`] by that connection is offered again, as is, after input, what is [`Verdict::Held`] for it;
//! - [`Rti::handle_end`] when nothing more will come on a connection, though what has come may still wait; and
//!   [`Rti::handle_disconnect`] when all that is whole of it has been consumed, too;
//! - [`Rti::poll_exchange`] after each input, and when [`Rti::poll_exchange_timeout`] says so, until it gives nothing;
//! - [`Rti::poll_round`] and [`Rti::handle_datagram`] for clock synchronization over UDP;
//! - [`Rti::handle_timeout`] when [`Rti::poll_timeout`] says so.
//!
//! It answers through the [`Outlet`], within these calls. [`Rti::status`] says when it is over.
//!
//! Memory is what the owner gives as [`RtiStorage`], whatever the peers do. Grants and DNETs are never queued: they are
//! worked out when there is room to send them. What is sent to many at once is a flag for each. A message that asks for
//! a reply, or is to be forwarded, is not consumed before there is room for that.
//!
//! [`Rti::suspend`] and [`Rti::resume`] are for searches through all that can happen.
//!
//! A NET or LTC costs a step for each federate that is upstream or downstream of its sender, however indirectly (see
//! `earliest`), and nothing for the others; a message that is forwarded costs a look at its destination, unless it
//! changes a next event.
//!
//! # Parts
//!
//! [`Rti`] is made of parts, each with a state of its own: who is there and over which connection (`members`), their
//! tags (`tags`, with what can be granted in `grants`, the `graph` that they go through and what is `in_transit`),
//! stops (`stop`), the start (`barrier`), the exchanges and rounds of clock synchronization (`exchange`, `clock_sync`)
//! and who is waited for (`watch`). A step that concerns several is given those: `handshake` all that lets somebody in,
//! `sending` those that are there, their tags, and where grants and messages go. What concerns all of them is in
//! `machine`: how federates leave. Flow control (`window`) has no state but theirs.

mod barrier;
mod clock_sync;
mod config;
mod delay;
mod earliest;
mod exchange;
mod grants;
mod graph;
mod handshake;
mod idle;
mod in_transit;
mod input;
mod machine;
mod members;
mod notice;
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
mod waits;
mod watch;
mod window;

pub use clock_sync::Datagram;
pub use config::{
    AfterLoss, CLOCK_SYNC_TRIALS, CLOCK_TIME_OUT, CONNECTION_TIME_OUT, ClockSync, Config, FEDERATION_ID_DEFAULT,
    START_BARRIER_TIME_OUT, START_DELAY, STOP_REPLY_TIME_OUT, SetupError, WINDOW,
};
pub use graph::Node;
pub use machine::Rti;
pub use notice::{Cause, Notice, Violation};
pub use outcome::{Outcome, Status};
pub use outlet::{ConnectionId, Outlet, Verdict};
pub use path::PathWords;
pub use storage::{Connection, RtiStorage, Slot};
pub use suspected_violation::{CLOCK_MAX, CLOCK_MIN, SuspectedViolation};
pub use suspend::Suspended;
pub use waits::{Progress, Waits};
pub use watch::START_REPORT;
