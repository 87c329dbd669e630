// SPDX-License-Identifier: Apache-2.0
//! The global event queue: for each trigger the tag of its earliest pending event, under a tournament tree.
//!
//! A trigger keeps its own pending values in order of tag, so one tag per trigger is all there is to order, and this
//! queue cannot be full. Finding the earliest takes no time, changing one trigger's tag O(log triggers).
use crate::tables::TriggerId;
use crate::time::Tag;

#[derive(Debug)]
pub(crate) struct Events<'a> {
    /// By trigger; FOREVER when nothing is pending.
    pub(crate) next: &'a mut [Tag],
    /// Inner nodes 1..n of a binary tree whose leaves n..2n are the triggers: the trigger with the earliest tag below.
    pub(crate) winners: &'a mut [u16],
}

impl Events<'_> {
    pub(crate) fn reset(&mut self) {
        self.next.fill(Tag::FOREVER);
        for node in (1..self.next.len()).rev() {
            self.replay(node);
        }
    }

    /// The earliest pending event.
    pub(crate) fn earliest(&self) -> Option<(Tag, TriggerId)> {
        if self.next.is_empty() {
            return None;
        }
        let trigger = self.winner(1);
        let tag = self.next[usize::from(trigger)];
        (tag != Tag::FOREVER).then_some((tag, TriggerId(trigger)))
    }

    pub(crate) fn set(&mut self, trigger: TriggerId, tag: Option<Tag>) {
        let leaf = usize::from(trigger.0);
        self.next[leaf] = tag.unwrap_or(Tag::FOREVER);
        let mut node = usize::midpoint(self.next.len(), leaf);
        while node >= 1 {
            self.replay(node);
            node /= 2;
        }
    }

    fn replay(&mut self, node: usize) {
        let (left, right) = (self.winner(2 * node), self.winner(2 * node + 1));
        let left_first = self.next[usize::from(left)] <= self.next[usize::from(right)];
        self.winners[node] = if left_first { left } else { right };
    }

    fn winner(&self, node: usize) -> u16 {
        let leaves = self.next.len();
        if node < leaves {
            return self.winners[node];
        }
        // Leaves are triggers, which are numbered in 16 bits.
        #[allow(clippy::cast_possible_truncation)]
        let leaf = (node - leaves) as u16;
        leaf
    }
}
