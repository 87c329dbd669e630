// SPDX-License-Identifier: Apache-2.0
//! The global event queue: for each trigger the tag of its earliest pending event, under a tournament tree.
//!
//! A trigger keeps its own pending values in order of tag, so there is only one tag per trigger to order, and this
//! queue cannot be full. Finding the earliest takes constant time, changing one trigger's tag O(log triggers).
use crate::ids::TriggerId;
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
            self.winners[node] = self.earlier(2 * node, self.winner(2 * node), self.winner(2 * node + 1));
        }
    }

    /// Returns the earliest pending event.
    pub(crate) fn earliest(&self) -> Option<(Tag, TriggerId)> {
        if self.next.is_empty() {
            return None;
        }
        let trigger = self.winner(1);
        let tag = self.next[usize::from(trigger)];
        (tag != Tag::FOREVER).then_some((tag, TriggerId(trigger)))
    }

    /// Sets the earliest tag of a trigger. Without memory, nothing is kept.
    pub(crate) fn set(&mut self, trigger: TriggerId, tag: Option<Tag>) {
        let leaf = usize::from(trigger.0);
        let Some(next) = self.next.get_mut(leaf) else { return };
        let tag = tag.unwrap_or(Tag::FOREVER);
        if *next == tag {
            return;
        }
        *next = tag;
        // A leaf, and the earliest trigger below it.
        let (mut node, mut first) = (self.next.len() + leaf, trigger.0);
        while node > 1 {
            first = self.earlier(node, first, self.winner(node ^ 1));
            node /= 2;
            if self.winners[node] == first && first != trigger.0 {
                // The earliest below this node is the same, with the same tag, and so are those above.
                return;
            }
            self.winners[node] = first;
        }
    }

    /// Returns the earlier of the triggers of a node and of its neighbor; of two at one tag, that of the left node.
    fn earlier(&self, node: usize, trigger: u16, neighbor: u16) -> u16 {
        let order = self.next[usize::from(trigger)].cmp(&self.next[usize::from(neighbor)]);
        if order.is_lt() || (order.is_eq() && node.is_multiple_of(2)) { trigger } else { neighbor }
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

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::time::Instant;

    proptest! {
        /// Changes to triggers in any order leave the same earliest event as a look at all of them finds.
        #[test]
        fn the_earliest_is_the_least_of_all(
            triggers in 0..20usize,
            changes in prop::collection::vec((0..20usize, prop_oneof![Just(None), (0..50i64).prop_map(Some)]), 0..60),
        ) {
            let (mut next, mut winners) = (vec![Tag::NEVER; triggers], vec![9; triggers]);
            let mut events = Events { next: &mut next, winners: &mut winners };
            events.reset();
            let mut all = vec![None; triggers];
            for (trigger, time) in changes.into_iter().filter(|(trigger, _)| *trigger < triggers) {
                let tag = time.map(|time| Tag::at(Instant::from_nanos(time)));
                all[trigger] = tag;
                events.set(TriggerId(u16::try_from(trigger).unwrap()), tag);
                let earliest = all.iter().flatten().min().copied();
                prop_assert_eq!(events.earliest().map(|(tag, _)| tag), earliest);
                let holders: Vec<usize> = (0..triggers).filter(|index| all[*index] == earliest).collect();
                prop_assert!(events.earliest().is_none_or(|(_, id)| holders.contains(&usize::from(id.0))));
            }
        }
    }
}
