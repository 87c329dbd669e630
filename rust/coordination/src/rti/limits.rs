// SPDX-License-Identifier: Apache-2.0
//! The limits of grants while transient federates may join, and the first tag of one that does.

use lf_model::time::{Instant, Tag};

use super::delay::earliest_after;
use super::grants::Grant;
use super::horizon::Horizon;
use super::tag_state::TagState;
use super::tags::Tags;

impl Tags<'_> {
    /// Returns whether a transient federate is absent that may still join.
    pub(super) fn expects_transients(&self) -> bool {
        self.horizon.is_open && (0..self.federates()).any(|federate| self.graph.is_absent(federate))
    }

    /// Makes a federate absent from the start on.
    pub(super) fn be_absent(&mut self, federate: usize) {
        self.state_mut(federate).departed = true;
        self.graph.nodes[federate].next_event = Tag::FOREVER;
    }

    /// Returns the first tag of a federate whose clock shows this time, or FOREVER if there is none.
    pub(super) fn effective_start(&self, federate: usize, clock: Instant, past: Tag) -> Tag {
        let earliest = Tag::at(clock.max(self.start.unwrap_or(clock)));
        let row = self.graph.nodes[federate].outgoing;
        let downstream = (0..row.len).map(|index| self.graph.other_end(row, index));
        // What it would cause at the tags of one that has left, too, would come too late.
        let granted = downstream.filter(|other| *other != federate && !self.graph.is_absent(*other));
        let granted = granted.filter(|other| !self.state(*other).departed || self.state(*other).reach().is_finite());
        let granted = granted.map(|other| self.state(other).reach());
        let before = granted.chain([past]);
        before.filter(|tag| *tag != Tag::NEVER).map(earliest_after).fold(earliest, Tag::max)
    }

    /// Begins the incarnation of a federate at its effective start.
    pub(super) fn begin_incarnation(&mut self, federate: usize, begin: Tag) {
        let node = &mut self.graph.nodes[federate];
        node.tags = TagState::EMPTY;
        (node.next_event, node.begin) = (begin, begin);
        self.graph.find_paths();
    }

    /// Limits a grant while transient federates upstream may join: see the module.
    pub(super) fn limited_grant(&mut self, federate: usize, grant: Grant) -> Option<Grant> {
        if !self.horizon.is_open {
            return Some(grant);
        }
        let row = self.graph.nodes[federate].incoming;
        let upstream = (0..row.len).map(|index| self.graph.other_end(row, index)).filter(|other| *other != federate);
        let (mut may_join, mut is_absent) = (false, false);
        for other in upstream {
            may_join |= self.graph.nodes[other].is_transient;
            is_absent |= self.graph.is_absent(other);
        }
        let waits = |horizon: &Horizon, tag: Tag| is_absent && !horizon.has_reached(tag);
        match grant {
            _ if !may_join => Some(grant),
            Grant::Provisional(tag) if waits(&self.horizon, tag) => {
                self.horizon.wait_for(tag);
                None
            }
            Grant::Provisional(_) => Some(grant),
            Grant::Final(tag) if tag != Tag::FOREVER && !waits(&self.horizon, tag) => Some(grant),
            Grant::Final(tag) => {
                let demanded = self.demand(federate).unwrap_or(Tag::NEVER);
                let TagState { granted, provisional, .. } = *self.state(federate);
                let mut best = None;
                for needed in [self.graph.next_event(federate), demanded, provisional] {
                    if needed > tag || needed <= granted || needed < provisional || !needed.is_finite() {
                        continue;
                    }
                    if waits(&self.horizon, needed) {
                        self.horizon.wait_for(needed);
                    } else {
                        best = best.max(Some(needed));
                    }
                }
                best.map(Grant::Final)
            }
        }
    }
}
