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

mod barrier;
mod clock_sync;
mod config;
mod delay;
mod departure;
mod doubt;
mod downstream;
mod earliest;
mod exchange;
mod grants;
mod graph;
mod handshake;
mod idle;
mod in_transit;
mod outlet;
mod path;
mod running;
mod search;
mod sending;
mod start;
mod stop;
mod storage;
mod strangers;
mod suspend;
mod watch;
mod window;

use core::fmt;

use lf_model::time::Instant;
use lf_wire::{Limits, message_bytes_max};

pub use clock_sync::Datagram;
pub use config::{
    AfterLoss, CLOCK_SYNC_TRIALS, CLOCK_TIME_OUT, CONNECTION_TIME_OUT, ClockSync, Config, FEDERATION_ID_DEFAULT,
    START_BARRIER_TIME_OUT, START_DELAY, STOP_REPLY_TIME_OUT, SetupError, WINDOW,
};
pub use doubt::{CLOCK_MAX, Doubt};
pub use graph::Node;
pub use outlet::{Cause, ConnectionId, Notice, Outlet, Verdict, Violation};
pub use path::PathWords;
pub use storage::{Connection, RtiStorage, Slot};
pub use suspend::Suspended;
pub use watch::{Progress, START_REPORT, Waits};

use crate::{Deadline, FederateId};
use barrier::Barrier;
use clock_sync::Rounds;
use exchange::Exchanges;
use graph::Graph;
use idle::Idle;
use in_transit::InTransit;
use lf_model::time::Tag;
use stop::Stop;
use storage::{Membership, Phase};
use strangers::Strangers;
use watch::Watch;

/// How a federation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All federates have resigned.
    Complete,
    /// At least one federate left otherwise; this was the first.
    Lost {
        /// The federate.
        federate: FederateId,
        /// Why.
        cause: Cause,
    },
    /// A federate has left before the start and has not come back in time.
    NotStarted {
        /// The first federate that was missing.
        first: FederateId,
        /// How many were missing, this one included.
        missing: u16,
    },
    /// The owner ended it.
    Aborted,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => f.write_str("all federates have resigned"),
            Self::Lost { federate, cause } => {
                write!(f, "the federation has failed: federate {federate} is lost: {cause}")
            }
            Self::NotStarted { first, missing } => {
                write!(f, "the federation has not started: federate {first}")?;
                if *missing > 1 {
                    write!(f, " and {} more", missing - 1)?;
                }
                f.write_str(" did not come back in time after a loss")
            }
            Self::Aborted => f.write_str("the RTI was told to end before its federation was over"),
        }
    }
}

/// Whether there is still something to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Federates are to come, or are there.
    Running,
    /// All federates have left. Once everything pending is sent, the owner may end.
    Finished(Outcome),
}

/// The RTI of one federation.
pub struct Rti<'s> {
    config: Config<'s>,
    limits: Limits,
    slots: &'s mut [Slot],
    connections: &'s mut [Connection],
    graph: Graph<'s>,
    /// The same number of entries for each federate.
    in_transit: &'s mut [Tag],
    start: Option<Instant>,
    stop: Stop,
    idle: Idle,
    /// The earliest deadline of the connections.
    patience: Deadline,
    /// The first federate that was lost after the start.
    loss: Option<(FederateId, Cause)>,
    barrier: Barrier,
    exchanges: Exchanges,
    rounds: Rounds,
    watch: Watch,
    strangers: Strangers,
    aborted: bool,
}

impl<'s> Rti<'s> {
    /// An RTI for as many federates as the storage has slots.
    ///
    /// # Errors
    /// What is wrong with the configuration or with the storage, in a sentence.
    pub fn new(config: Config<'s>, storage: RtiStorage<'s>) -> Result<Self, SetupError> {
        config.check()?;
        storage.check()?;
        let RtiStorage { slots, nodes, connections, paths, upstream, in_transit } = storage;
        let count = slots.len();
        slots.fill(Slot::default());
        connections.fill(Connection::default());
        // Storage may be larger than needed; the graph relies on the number of nodes.
        let graph = Graph::new(&mut nodes[..count], upstream, paths, config.dnet);
        Ok(Self {
            limits: config.limits(count),
            config,
            slots,
            connections,
            graph,
            in_transit,
            start: None,
            stop: Stop::default(),
            idle: Idle::default(),
            patience: Deadline::Never,
            loss: None,
            barrier: Barrier::default(),
            exchanges: Exchanges::default(),
            rounds: Rounds::default(),
            watch: Watch::default(),
            strangers: Strangers::default(),
            aborted: false,
        })
    }

    /// Whether the federation is over, and how it ended.
    pub fn status(&self) -> Status {
        if self.aborted {
            return Status::Finished(self.outcome(Outcome::Aborted));
        }
        if self.slots.iter().all(|slot| slot.membership == Membership::Departed) {
            return Status::Finished(self.outcome(Outcome::Complete));
        }
        Status::Running
    }

    fn outcome(&self, otherwise: Outcome) -> Outcome {
        let lost = self.loss.map(|(federate, cause)| Outcome::Lost { federate, cause });
        lost.or(self.barrier.outcome()).unwrap_or(otherwise)
    }

    /// The start time, once all federates have joined and told their clocks.
    pub fn start_time(&self) -> Option<Instant> {
        self.start
    }

    /// The tag at which all stop, once they have agreed on it.
    pub fn stop_tag(&self) -> Option<Tag> {
        self.stop.granted()
    }

    /// Bytes of the longest message that is accepted: what the buffers of every connection have to hold at least, for
    /// input and for output.
    pub fn message_bytes_max(&self) -> usize {
        message_bytes_max(&self.limits)
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Deadline {
        let ends = self.patience.min(self.idle.deadline());
        let ends = ends.min(self.stop.deadline().into()).min(self.barrier.deadline().into());
        ends.min(self.watch_deadline())
    }

    /// When the first of the federates that are there will have an event, as far as they have said: then they are
    /// likely to say something. Looks at every federate once.
    pub fn next_event_after(&self, now: Instant) -> Deadline {
        let times = self.slots.iter().enumerate().filter_map(|(federate, slot)| {
            let is_there = matches!(slot.membership, Membership::Joined(_));
            is_there.then(|| self.graph.next_event(federate).time).filter(|time| *time > now)
        });
        times.min().filter(|time| *time < Instant::FOREVER).into()
    }

    /// Gives up on connections that have been silent for too long, on federates that do not answer a stop request, and
    /// on a start for which some have been missing for too long.
    /// Looks at every connection and every federate once.
    pub fn handle_timeout(&mut self, now: Instant, outlet: &mut impl Outlet) {
        if self.patience.is_due(now) {
            for index in 0..self.connections.len() {
                if self.connections[index].deadline.is_some_and(|deadline| deadline <= now) {
                    self.lose_patience(ConnectionId(index), outlet);
                }
            }
        }
        if self.stop.deadline().is_some_and(|deadline| deadline <= now) {
            self.give_up_stop_replies(outlet);
        }
        if self.barrier.deadline().is_some_and(|deadline| deadline <= now) {
            self.give_up_start(outlet);
        }
        self.limit_start(now);
        if self.watch_deadline().is_due(now) {
            self.look(now, outlet);
        }
        if self.idle.deadline().is_due(now) {
            self.tell_idleness(now, outlet);
        }
    }

    /// There is more room on a connection. Sends what was put off for its federate.
    pub fn handle_writable(&mut self, _now: Instant, connection: ConnectionId, outlet: &mut impl Outlet) {
        self.retry_exchange(connection);
        if let Some(federate) = self.joined_on(connection) {
            self.flush(federate, outlet);
        }
    }

    /// As [`federate_on`](Self::federate_on), as the place of its slot.
    fn joined_on(&self, connection: ConnectionId) -> Option<usize> {
        let known = self.connections.get(connection.0)?;
        known.federate.filter(|_| known.phase == Phase::Joined).map(usize::from)
    }

    /// The federate that has joined over this connection and is still there.
    pub fn federate_on(&self, connection: ConnectionId) -> Option<FederateId> {
        self.joined_on(connection).map(id)
    }

    /// The connection of a federate that is part of the federation.
    fn connection_of(&self, federate: usize) -> Option<ConnectionId> {
        match self.slots[federate].membership {
            Membership::Joined(connection) => Some(connection),
            _ => None,
        }
    }

    /// The messages on their way to a federate.
    fn in_transit(&mut self, federate: usize) -> InTransit<'_> {
        let share = self.in_transit.len() / self.slots.len();
        InTransit {
            ring: &mut self.slots[federate].in_transit,
            storage: &mut self.in_transit[federate * share..][..share],
        }
    }

    /// Until when the RTI has patience with a connection.
    fn set_deadline(&mut self, connection: ConnectionId, deadline: Option<Instant>) {
        let before = core::mem::replace(&mut self.connections[connection.0].deadline, deadline);
        if before.is_some() && self.patience == before.into() {
            self.patience = patience(self.connections);
        }
        self.patience = self.patience.min(deadline.into());
    }

    /// The connection is no more, and its id is free if it had not completed its handshake.
    fn release(&mut self, connection: ConnectionId) {
        if connection.0 >= self.connections.len() {
            return;
        }
        self.set_deadline(connection, None);
        self.leave_exchanges(connection);
        let federate = core::mem::take(&mut self.connections[connection.0]).federate;
        if let Some(federate) = federate
            && let Some(slot) = self.slots.get(usize::from(federate))
            && slot.membership == Membership::Joining(connection)
        {
            self.vacate(federate.into());
        }
    }
}

/// The earliest deadline of the connections.
fn patience(connections: &[Connection]) -> Deadline {
    connections.iter().filter_map(|connection| connection.deadline).min().into()
}

/// An index of a slot as the federate's id.
fn id(index: usize) -> FederateId {
    FederateId(u16::try_from(index).expect("there are no more slots than a federate id can name, which `new` checks"))
}
