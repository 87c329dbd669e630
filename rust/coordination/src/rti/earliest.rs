// SPDX-License-Identifier: Apache-2.0
//! The minimum over the federates at the other ends of a row, kept up to date by a tournament tree.
//!
//! A federate asks two questions about the next events of others: when the first message can come from those upstream,
//! and up to which tag those downstream need to know of its own events. Both answers are minimums over a row, and both
//! are asked far more often than they change. So the entries of each row form a tournament tree: when a next event
//! changes, only the games of that federate are played again, in the rows of those that it can matter to. That costs at
//! most the logarithm of the length of each such row, and mostly one game, because a federate that loses it as before
//! changes nothing higher up.
//!
//! The tournament of a row of k entries has k - 1 games, numbered from 1, whose winners are kept beside the entries.
//! The players of game i are the winners of the games 2i and 2i + 1; the number k + p stands for entry p itself.

use lf_model::time::{Instant, Tag};

use super::graph::{Graph, Row};
use super::path::{self, Path};

/// The row of a federate.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The paths that lead to it: when can a message come?
    Incoming,
    /// The paths that lead from it: which of its events matter?
    Outgoing,
}

impl Graph<'_> {
    /// Returns the next event of a federate; NEVER while it is unknown.
    pub(super) fn next_event(&self, federate: usize) -> Tag {
        self.nodes[federate].next_event
    }

    /// Sets the next event of a federate.
    pub(super) fn set_next_event(&mut self, federate: usize, tag: Tag) {
        if core::mem::replace(&mut self.nodes[federate].next_event, tag) == tag {
            return;
        }
        self.play_at_other_ends(federate, Side::Outgoing);
        if self.dnet {
            self.play_at_other_ends(federate, Side::Incoming);
        }
    }

    /// Limits the next events of all federates that are there to `tag`.
    pub(super) fn limit_next_events(&mut self, tag: Tag) {
        for node in self.nodes.iter_mut().filter(|node| !node.tags.departed) {
            node.next_event = node.next_event.min(tag);
        }
        self.find_all_earliest();
    }

    /// Returns the earliest tag with which a message may still come from any federate upstream, directly or indirectly.
    ///
    /// A federate that has not announced anything counts as having its next event at the start, from now on.
    pub(super) fn earliest_incoming(&mut self, federate: usize, start: Instant) -> Tag {
        let earliest = self.earliest(federate, Side::Incoming);
        if earliest != Tag::NEVER {
            return earliest;
        }
        let row = self.nodes[federate].incoming;
        for index in 0..row.len {
            let upstream = self.other_end(row, index);
            if self.next_event(upstream) == Tag::NEVER {
                self.set_next_event(upstream, Tag::at(start));
            }
        }
        self.earliest(federate, Side::Incoming)
    }

    /// Returns the federate from which that message may come: the one that keeps the RTI from granting more.
    pub(super) fn earliest_source(&self, federate: usize) -> Option<usize> {
        let row = self.nodes[federate].incoming;
        (row.len > 0).then(|| self.other_end(row, self.winner(row, 1)))
    }

    /// Returns the latest tag of a federate that can matter to any other federate downstream, by its next event. Up to
    /// date only if DNETs are sent.
    pub(super) fn earliest_needed(&self, federate: usize) -> Tag {
        self.earliest(federate, Side::Outgoing)
    }

    /// Plays all tournaments again.
    pub(super) fn find_all_earliest(&mut self) {
        for federate in 0..self.nodes.len() {
            let sides: &[Side] = if self.dnet { &[Side::Incoming, Side::Outgoing] } else { &[Side::Incoming] };
            for side in sides.iter().copied() {
                let row = self.row(federate, side);
                for game in (1..row.len).rev() {
                    self.play(federate, side, game);
                }
            }
        }
    }

    /// Plays the games of a federate again in the rows of those at the other ends of its own `side`.
    fn play_at_other_ends(&mut self, federate: usize, side: Side) {
        let row = self.row(federate, side);
        let theirs = match side {
            Side::Incoming => Side::Outgoing,
            Side::Outgoing => Side::Incoming,
        };
        for index in 0..row.len {
            let Path { federate: other, place, .. } = Path::read(&self.paths[row.start + index]);
            let (other, place) = (usize::from(other), usize::from(place));
            let mut game = self.row(other, theirs).len.midpoint(place);
            while game > 0 {
                let before = self.play(other, theirs, game);
                // The same winner at the same tag changes nothing higher up.
                if before != place && self.winner(self.row(other, theirs), game) == before {
                    break;
                }
                game /= 2;
            }
        }
    }

    /// Plays one game. Returns its previous winner.
    fn play(&mut self, federate: usize, side: Side, game: usize) -> usize {
        let row = self.row(federate, side);
        let (one, other) = (self.winner(row, 2 * game), self.winner(row, 2 * game + 1));
        let first = self.tag(federate, side, one) <= self.tag(federate, side, other);
        let words = &mut self.paths[row.start + game];
        let before = path::beside(words).into();
        let winner = if first { one } else { other };
        let Ok(winner) = u16::try_from(winner) else { panic!("a row is no longer than there are federates") };
        path::set_beside(words, winner);
        before
    }

    /// Returns the winner of a game, as an index into the row.
    fn winner(&self, row: Row, game: usize) -> usize {
        match game.checked_sub(row.len) {
            Some(place) => place,
            None => path::beside(&self.paths[row.start + game]).into(),
        }
    }

    /// Returns the tag of the winner of a row; FOREVER if the row is empty.
    fn earliest(&self, federate: usize, side: Side) -> Tag {
        let row = self.row(federate, side);
        if row.len == 0 { Tag::FOREVER } else { self.tag(federate, side, self.winner(row, 1)) }
    }

    /// Returns the meaning of the next event at the other end of an entry for the federate of the row.
    fn tag(&self, federate: usize, side: Side, place: usize) -> Tag {
        let Path { federate: other, delay, .. } = Path::read(&self.paths[self.row(federate, side).start + place]);
        let other = usize::from(other);
        match side {
            Side::Incoming => delay.after(self.nodes[other].next_event),
            // It knows its own events.
            Side::Outgoing if other == federate => Tag::FOREVER,
            Side::Outgoing => delay.before(self.nodes[other].next_event),
        }
    }

    fn row(&self, federate: usize, side: Side) -> Row {
        match side {
            Side::Incoming => self.nodes[federate].incoming,
            Side::Outgoing => self.nodes[federate].outgoing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rti::samples::{FEDERATES, edges, with_graph};
    use lf_model::time::Microstep;
    use proptest::prelude::*;

    fn tag() -> impl Strategy<Value = Tag> {
        prop_oneof![
            1 => Just(Tag::NEVER),
            1 => Just(Tag::FOREVER),
            6 => (0..40i64, 0..4u32)
                .prop_map(|(time, microstep)| Tag::new(Instant::from_nanos(time), Microstep(microstep))),
        ]
    }

    fn plain(graph: &Graph<'_>, federate: usize, side: Side) -> Tag {
        (0..graph.row(federate, side).len).map(|place| graph.tag(federate, side, place)).min().unwrap_or(Tag::FOREVER)
    }

    proptest! {
        /// After any changes, one at a time or all at once, the winner has the earliest tag of its row.
        #[test]
        fn the_winner_is_the_least_of_the_row(
            edges in edges(),
            steps in proptest::collection::vec((0..FEDERATES, tag(), any::<bool>()), 0..40),
        ) {
            with_graph(&edges, |graph| {
                for (federate, tag, all) in &steps {
                    if *all {
                        graph.limit_next_events(*tag);
                    } else {
                        graph.set_next_event(usize::from(*federate), *tag);
                    }
                    for federate in 0..usize::from(FEDERATES) {
                        for side in [Side::Incoming, Side::Outgoing] {
                            prop_assert_eq!(graph.earliest(federate, side), plain(graph, federate, side));
                        }
                    }
                }
                Ok(())
            })?;
        }
    }
}
