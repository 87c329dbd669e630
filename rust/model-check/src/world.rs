// SPDX-License-Identifier: Apache-2.0
//! The constant part of a federation.

use lf_model::time::Tag;

use crate::bounds::Bounds;
use crate::graph::{Delay, FEDERATES_MAX, Graph};
use crate::small_tag::{START, SmallTag};

/// The world of a model: a federation without its state.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) graph: Graph,
    pub(crate) bounds: Bounds,
    pub(crate) awaited: [[bool; FEDERATES_MAX]; FEDERATES_MAX],
    pub(crate) ranks: [usize; FEDERATES_MAX],
}

impl World {
    /// Returns the number of instances: one of each federate, and if there are swaps, another one of the transient
    /// federate after all of them.
    pub(crate) fn instances(&self) -> usize {
        self.graph.federates() + usize::from(self.bounds.swaps)
    }

    /// Returns the federate of an instance.
    pub(crate) fn federate(&self, instance: usize) -> usize {
        let transient = self.bounds.transient.map_or(instance, usize::from);
        if instance < self.graph.federates() { instance } else { transient }
    }

    /// Returns whether this is an instance of the transient federate.
    pub(crate) fn is_transient(&self, instance: usize) -> bool {
        self.bounds.transient.map(usize::from) == Some(self.federate(instance))
    }

    pub(crate) fn has_upstream(&self, id: usize) -> bool {
        self.graph.upstream(id).next().is_some()
    }

    /// Returns the federates whose messages a federate may have to wait for within a tag.
    pub(crate) fn awaited(&self, to: usize) -> impl Iterator<Item = usize> {
        (0..self.graph.federates()).filter(move |from| self.awaited[*from][to])
    }

    pub(crate) fn is_awaited(&self, from: usize, to: usize) -> bool {
        self.awaited[from][to]
    }

    /// Returns the rank of a federate's reactions among those of its cycle.
    pub(crate) fn rank(&self, id: usize) -> usize {
        self.ranks[id]
    }

    /// Returns this tag as a small tag, if it is within the bounds.
    pub(crate) fn small_tag(&self, tag: Tag) -> Option<SmallTag> {
        let Bounds { time_max, microstep_max, .. } = self.bounds;
        let time = u8::try_from(tag.time.as_nanos().checked_sub(START.as_nanos())?).ok()?;
        let microstep = u8::try_from(tag.microstep.0).ok()?;
        (time <= time_max && microstep <= microstep_max).then(|| SmallTag::new(time, microstep))
    }

    /// Returns the last tag within the bounds before this one, if there is one.
    pub(crate) fn last_before(&self, tag: Tag) -> Option<SmallTag> {
        let times = (0..=self.bounds.time_max).rev();
        let microsteps = || (0..=self.bounds.microstep_max).rev();
        let mut all = times.flat_map(|time| microsteps().map(move |microstep| SmallTag::new(time, microstep)));
        all.find(|small| small.tag() < tag)
    }

    /// Returns the tag that stands for all tags beyond the bounds, which are equivalent.
    pub(crate) fn end(&self) -> Tag {
        SmallTag::new(self.bounds.time_max + 1, 0).tag()
    }

    /// Returns the tag at which a message sent at `at` arrives, if it is within the bounds.
    pub(crate) fn arrival(&self, delay: Delay, at: SmallTag) -> Option<SmallTag> {
        let within = match delay {
            Delay::Zero => true,
            Delay::Microstep => at.microstep() < self.bounds.microstep_max,
            Delay::Tick => at.time() < self.bounds.time_max,
        };
        within.then(|| delay.after(at))
    }
}
