// SPDX-License-Identifier: Apache-2.0
//! The reactor model of one federate: tags and time, event queue, reactions by level, ports, actions, timers,
//! deadlines.
//!
//! The compiler generates a [`Program`] with constant [`Tables`]; an event loop drives it through an [`Engine`], which
//! uses an [`Env`] to read a clock, send and wake. This crate knows neither federations nor sockets nor threads, and
//! does not allocate. `tests/bench` has a program that is made by hand, and an event loop that drives it.
//!
//! # Capacities that the generator chooses
//!
//! | capacity | type | required size |
//! |---|---|---|
//! | events of a logical action | [`LogicalActionQueue<T, N>`] | those scheduled and not yet happened; `@capacity(n)` |
//! | events of a physical action | [`PhysicalActionQueue<T, N>`], [`PhysicalInbox<T, N>`] | the same, in either |
//! | values on a delayed connection | [`QueuedPort<T, N>`] | those sent within one delay |
//! | messages of a network input | [`QueuedPort<T, N>`] | those ahead of this federate; when full, the sender waits |
//! | triggers, reactions, ports | [`storage_for!`] | computed from the tables |
//!
//! The engine's event queue holds one tag per trigger, so it has no capacity to choose and cannot be full.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod action;
mod bits;
mod cell;
mod context;
mod engine;
mod env;
mod error;
mod events;
mod ids;
mod macros;
mod modes;
mod multiport;
mod outside;
mod part;
mod payload;
mod physical;
mod port;
mod program;
mod queue;
mod shared_tag;
mod state;
mod storage;
mod tables;
mod tardy;
pub mod time;
pub mod units;
mod watchdog;
#[cfg(feature = "workers")]
mod workers;

pub use action::{LogicalAction, LogicalActionQueue, Timer};
pub use cell::{Bounds, Placed, Readable, Schedulable, ScheduleContext, TriggerCell, Undelivered};
pub use context::ReactionContext;
#[cfg(feature = "traces")]
pub use engine::EncodeEvent;
pub use engine::{Delivery, Engine, Progress};
pub use env::{Env, Outgoing, ReactionStep, SendError};
pub use error::{DeliverError, ModelError, ScheduleError};
pub use ids::{InputId, ModeId, OutputId, PortId, ReactionId, TriggerId};
pub use lf_derive::Payload;
#[doc(hidden)]
pub use macros::__private;
pub use modes::{ModeCell, ModeCells, ModeEvents, ModeInfo, ModeTrigger, Modes, Transition};
pub use multiport::{Multiport, MultiportMut};
pub use outside::{Mailbox, Outside};
pub use part::Part;
#[cfg(feature = "postcard")]
pub use payload::{Bounded, Postcard};
pub use payload::{FixedPayload, Native, Payload, PayloadError, Serializer, layout};
#[doc(hidden)]
pub use payload::{copied_by_connection, list_from, list_to, sendable, sendable_by, text_from, text_to};
pub use physical::{
    Encode, Inbox, PhysicalAction, PhysicalActionQueue, PhysicalActionRef, PhysicalInbox, PhysicalLink, Posted, Poster,
};
#[doc(hidden)]
pub use physical::{Encoder, Opaque};
pub use port::{Port, QueuedPort, QueuedPortInner};
pub use program::Program;
pub use queue::{Event, Full, Owned, View};
pub use shared_tag::SharedTag;
pub use state::Settings;
pub use storage::{EngineStorage, Storage, StorageParts};
pub use tables::{
    ActionTiming, HandedOver, NetworkInput, NetworkOutput, Policy, PortInfo, ReactionInfo, ReactionKind, Tables,
    TriggerInfo, TriggerKind, words,
};
pub use tardy::{Intended, TardyInput, TardyInputInner};
pub use time::{EventTag, Instant, Interval, Microstep, Offset, Tag};
pub use watchdog::Watchdog;
#[cfg(feature = "workers")]
pub use workers::{Job, Level, Worker, WorkerPool};
#[cfg(feature = "workers")]
#[doc(hidden)]
pub use workers::{moves_between_threads, seen_by_threads};

/// The names that reaction bodies, preambles and state see without a path.
pub mod prelude {
    pub use core::time::Duration;

    // Its `Vec` and `String` are the values of variable length that can be sent.
    pub use ::heapless;

    pub use crate::Offset::{After, Asap};
    pub use crate::{
        EventTag, FixedPayload, Instant, LogicalAction, Multiport, MultiportMut, Offset, Payload, PhysicalAction,
        PhysicalActionRef, PhysicalLink, Port, ReactionContext, Timer, Watchdog,
    };
    pub use crate::{after, assert_tag_is, delay, payload, tag};

    // Programs for LF's own runtime name that crate.
    pub use crate::prelude as reactor_rt;
}
