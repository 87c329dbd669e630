// SPDX-License-Identifier: Apache-2.0
//! An RTI between two inputs as plain data, which can be copied, compared and gone back to: what a search through all
//! that can happen needs. The memory that its owner gives is the greater part of it; this is the rest.

use lf_model::time::Instant;

use super::barrier::Barrier;
use super::clock_sync::Rounds;
use super::config::{Config, SetupError};
use super::exchange::Exchanges;
use super::graph::Graph;
use super::idle::Idle;
use super::machine::Rti;
use super::members::Members;
use super::outcome::End;
use super::stop::Stop;
use super::storage::{RtiStorage, Tallies};
use super::strangers::Strangers;
use super::tags::Tags;
use super::watch::Watch;

/// What an RTI knows that does not lie in its storage; see [`Rti::suspend`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Suspended {
    start: Option<Instant>,
    idle: Idle,
    stop: Stop,
    barrier: Barrier,
    exchanges: Exchanges,
    rounds: Rounds,
    end: End,
}

impl<'s> Rti<'s> {
    /// Gives the storage back to its owner, who can copy it: with it and what this returns, [`resume`](Self::resume)
    /// goes on.
    ///
    /// The storage is left in a form in which RTIs that know the same are equal, but for what their owners put into
    /// parts that are larger than needed. Costs a pass over the messages in transit.
    pub fn suspend(mut self) -> Suspended {
        self.tags.normalize();
        for slot in self.members.slots.iter_mut() {
            slot.tallies = Tallies::NOTHING;
        }
        // All fields are named, so that whoever adds one is asked whether it belongs here.
        let Self {
            config: _,
            limits: _,
            members: _,
            tags: Tags { graph: _, in_transit: _, start, idle },
            stop,
            barrier,
            exchanges,
            rounds,
            strangers: _,
            watch: _,
            end,
        } = self;
        Suspended { start, idle, stop, barrier, exchanges, rounds, end }
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
        let Suspended { start, idle, stop, barrier, exchanges, rounds, end } = state;
        Ok(Self {
            limits: config.limits(count),
            config,
            members: Members::new(slots, connections),
            tags: Tags { graph, in_transit, start, idle },
            stop,
            barrier,
            exchanges,
            rounds,
            strangers: Strangers::default(),
            watch: Watch::default(),
            end,
        })
    }
}
