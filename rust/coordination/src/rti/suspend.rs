// SPDX-License-Identifier: Apache-2.0
//! An RTI between two inputs as plain data, which can be copied, compared and restored, for searches through all
//! reachable states. The owner's memory is the greater part of it; this is the rest.

use lf_model::time::Instant;

use super::barrier::Barrier;
use super::clock_sync::Rounds;
use super::config::{Config, SetupError};
use super::exchange::Exchanges;
use super::graph::Graph;
#[cfg(feature = "transients")]
use super::horizon::Horizon;
use super::idle::Idle;
use super::machine::Rti;
use super::members::Members;
use super::outcome::End;
use super::stop::Stop;
use super::storage::{RtiStorage, Tallies};
use super::strangers::Strangers;
use super::tags::Tags;
use super::watch::Watch;

/// The state of an RTI outside of its storage; see [`Rti::suspend`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Suspended {
    start: Option<Instant>,
    idle: Idle,
    #[cfg(feature = "transients")]
    horizon: Horizon,
    stop: Stop,
    barrier: Barrier,
    exchanges: Exchanges,
    rounds: Rounds,
    end: End,
}

impl<'s> Rti<'s> {
    /// Returns the state outside of the storage and releases the storage, which its owner can copy.
    /// [`resume`](Self::resume) continues from both.
    ///
    /// Normalizes the storage: RTIs with the same knowledge are equal then, except for unused parts of it. Costs a pass
    /// over the messages in transit.
    pub fn suspend(mut self) -> Suspended {
        self.tags.normalize();
        for slot in self.members.slots.iter_mut() {
            slot.tallies = Tallies::NOTHING;
        }
        // All fields are named, so that a new field raises the question whether it belongs here.
        let Self {
            config: _,
            limits: _,
            members: _,
            tags:
                Tags {
                    graph: _,
                    in_transit: _,
                    start,
                    idle,
                    #[cfg(feature = "transients")]
                    horizon,
                },
            stop,
            barrier,
            exchanges,
            rounds,
            strangers: _,
            watch: _,
            end,
            // What the slots say.
            window: _,
        } = self;
        Suspended {
            start,
            idle,
            #[cfg(feature = "transients")]
            horizon,
            stop,
            barrier,
            exchanges,
            rounds,
            end,
        }
    }

    /// Continues a suspended RTI: `storage` is what that one left, or a copy, and the configuration is the same.
    ///
    /// # Errors
    /// As [`new`](Self::new). Storage of another origin is not detected; the results are then wrong.
    pub fn resume(config: Config<'s>, storage: RtiStorage<'s>, state: Suspended) -> Result<Self, SetupError> {
        config.check()?;
        storage.check()?;
        let RtiStorage { slots, nodes, connections, paths, upstream, in_transit, .. } = storage;
        let count = slots.len();
        let members = Members::new(slots, connections);
        #[cfg(feature = "transients")]
        let members = match config.transients() {
            0 => members,
            _ => members.with_registrations(storage.registrations),
        };
        let graph = Graph::resume(&mut nodes[..count], upstream, paths, config.dnet);
        let Suspended { start, idle, stop, barrier, exchanges, rounds, end, .. } = state;
        let mut resumed = Self {
            limits: config.limits(count),
            window: config.window,
            config,
            members,
            tags: Tags {
                graph,
                in_transit,
                start,
                idle,
                #[cfg(feature = "transients")]
                horizon: state.horizon,
            },
            stop,
            barrier,
            exchanges,
            rounds,
            strangers: Strangers::default(),
            watch: Watch::default(),
            end,
        };
        resumed.agree_on_window();
        Ok(resumed)
    }
}
