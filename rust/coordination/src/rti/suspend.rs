// SPDX-License-Identifier: Apache-2.0
//! An RTI between two inputs as plain data, which can be copied, compared and gone back to: what a search through all
//! that can happen needs. The memory that its owner gives is the greater part of it; this is the rest.

use lf_model::time::{Instant, Tag};

use super::barrier::Barrier;
use super::clock_sync::Rounds;
use super::config::SetupError;
use super::departure::Tallies;
use super::exchange::Exchanges;
use super::graph::Graph;
use super::idle::Idle;
use super::stop::Stop;
use super::strangers::Strangers;
use super::watch::Watch;
use super::{Cause, Config, Rti, RtiStorage};
use crate::FederateId;

/// What an RTI knows that does not lie in its storage; see [`Rti::suspend`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Suspended {
    start: Option<Instant>,
    stop: Stop,
    idle: Idle,
    loss: Option<(FederateId, Cause)>,
    barrier: Barrier,
    exchanges: Exchanges,
    rounds: Rounds,
    aborted: bool,
}

impl<'s> Rti<'s> {
    /// Gives the storage back to its owner, who can copy it: with it and what this returns, [`resume`](Self::resume)
    /// goes on.
    ///
    /// The storage is left in a form in which RTIs that know the same are equal, but for what their owners put into
    /// parts that are larger than needed. Costs a pass over the messages in transit.
    pub fn suspend(mut self) -> Suspended {
        for federate in 0..self.slots.len() {
            self.in_transit(federate).normalize();
            self.graph.normalize(federate);
            self.slots[federate].tallies = Tallies::NOTHING;
        }
        // All fields are named, so that whoever adds one is asked whether it belongs here.
        let Self {
            config: _,
            limits: _,
            slots: _,
            connections: _,
            graph: _,
            in_transit: _,
            start,
            stop,
            idle,
            patience: _,
            loss,
            barrier,
            exchanges,
            rounds,
            watch: _,
            strangers: _,
            aborted,
        } = self;
        Suspended { start, stop, idle, loss, barrier, exchanges, rounds, aborted }
    }

    /// Goes on where another RTI was suspended: `storage` is a copy of what that one left, or the same, and the
    /// configuration is the same.
    ///
    /// # Errors
    /// As [`new`](Self::new). Storage that no RTI has left is not noticed; what follows is then wrong.
    pub fn resume(config: Config<'s>, storage: RtiStorage<'s>, state: Suspended) -> Result<Self, SetupError> {
        config.check()?;
        storage.check()?;
        let RtiStorage { slots, nodes, connections, paths, upstream, in_transit } = storage;
        let count = slots.len();
        let graph = Graph::resume(&mut nodes[..count], upstream, paths, config.dnet);
        let Suspended { start, stop, idle, loss, barrier, exchanges, rounds, aborted } = state;
        let limits = config.limits(count);
        let patience = super::patience(connections);
        Ok(Self {
            config,
            limits,
            slots,
            connections,
            graph,
            in_transit,
            start,
            stop,
            idle,
            patience,
            loss,
            barrier,
            exchanges,
            rounds,
            watch: Watch::default(),
            strangers: Strangers::default(),
            aborted,
        })
    }
}

impl Graph<'_> {
    /// Forgets what only saves work.
    fn normalize(&mut self, federate: usize) {
        self.nodes[federate].hindrance = 0;
    }
}

impl super::in_transit::InTransit<'_> {
    /// Moves the tags to the front of the storage and forgets what lay behind them.
    fn normalize(&mut self) {
        self.storage.rotate_left(self.ring.head);
        self.ring.head = 0;
        if let Some(unused) = self.storage.get_mut(self.ring.len..) {
            unused.fill(Tag::NEVER);
        }
    }
}
