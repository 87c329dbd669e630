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
enum Direction {
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
        self.play_at_other_ends(federate, Direction::Outgoing);
        if self.dnet {
            self.play_at_other_ends(federate, Direction::Incoming);
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
        let earliest = self.earliest(federate, Direction::Incoming);
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
        self.earliest(federate, Direction::Incoming)
    }

    /// Returns the federate from which that message may come: the one that keeps the RTI from granting more.
    pub(super) fn earliest_source(&self, federate: usize) -> Option<usize> {
        let row = self.nodes[federate].incoming;
        (row.len > 0).then(|| self.other_end(row, self.winner(row, 1)))
    }

    /// Returns the latest tag of a federate that can matter to any other federate downstream, by its next event. Up to
    /// date only if DNETs are sent.
    pub(super) fn earliest_needed(&self, federate: usize) -> Tag {
        self.earliest(federate, Direction::Outgoing)
    }

    /// Plays all tournaments again.
    pub(super) fn find_all_earliest(&mut self) {
        for federate in 0..self.nodes.len() {
            let directions: &[Direction] =
                if self.dnet { &[Direction::Incoming, Direction::Outgoing] } else { &[Direction::Incoming] };
            for direction in directions.iter().copied() {
                let row = self.row(federate, direction);
                for game in (1..row.len).rev() {
                    self.play(federate, direction, game);
                }
            }
        }
    }

    /// Plays the games of a federate again in the rows of those at the other ends of its own `direction`.
    fn play_at_other_ends(&mut self, federate: usize, direction: Direction) {
        let row = self.row(federate, direction);
        let theirs = match direction {
            Direction::Incoming => Direction::Outgoing,
            Direction::Outgoing => Direction::Incoming,
        };
        for index in 0..row.len {
            let Path { federate: other, reverse, .. } = Path::read(&self.paths[row.start + index]);
            let (other, reverse) = (usize::from(other), usize::from(reverse));
            let mut game = self.row(other, theirs).len.midpoint(reverse);
            while game > 0 {
                let before = self.play(other, theirs, game);
                // The same winner at the same tag changes nothing higher up.
                if before != reverse && self.winner(self.row(other, theirs), game) == before {
                    break;
                }
                game /= 2;
            }
        }
    }

    /// Plays one game. Returns its previous winner.
    fn play(&mut self, federate: usize, direction: Direction, game: usize) -> usize {
        let row = self.row(federate, direction);
        let (one, other) = (self.winner(row, 2 * game), self.winner(row, 2 * game + 1));
        let first = self.tag(federate, direction, one) <= self.tag(federate, direction, other);
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
            Some(index) => index,
            None => path::beside(&self.paths[row.start + game]).into(),
        }
    }

    /// Returns the tag of the winner of a row; FOREVER if the row is empty.
    fn earliest(&self, federate: usize, direction: Direction) -> Tag {
        let row = self.row(federate, direction);
        if row.len == 0 { Tag::FOREVER } else { self.tag(federate, direction, self.winner(row, 1)) }
    }

    /// Returns the meaning of the next event at the other end of an entry for the federate of the row.
    fn tag(&self, federate: usize, direction: Direction, index: usize) -> Tag {
        let Path { federate: other, delay, .. } = Path::read(&self.paths[self.row(federate, direction).start + index]);
        let other = usize::from(other);
        match direction {
            Direction::Incoming => delay.after(self.nodes[other].next_event),
            // It knows its own events.
            Direction::Outgoing if other == federate => Tag::FOREVER,
            Direction::Outgoing => delay.before(self.nodes[other].next_event),
        }
    }

    fn row(&self, federate: usize, direction: Direction) -> Row {
        match direction {
            Direction::Incoming => self.nodes[federate].incoming,
            Direction::Outgoing => self.nodes[federate].outgoing,
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

    fn plain(graph: &Graph<'_>, federate: usize, direction: Direction) -> Tag {
        (0..graph.row(federate, direction).len)
            .map(|index| graph.tag(federate, direction, index))
            .min()
            .unwrap_or(Tag::FOREVER)
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
                        for direction in [Direction::Incoming, Direction::Outgoing] {
                            prop_assert_eq!(graph.earliest(federate, direction), plain(graph, federate, direction));
                        }
                    }
                }
                Ok(())
            })?;
        }
    }
}
