// SPDX-License-Identifier: Apache-2.0
//! The exchanges of clock synchronization before the start: T1, T3 and T4, as often as was agreed, over TCP.
//!
//! A federate of the stock runtime throws all its exchanges away if one of them takes a third of a millisecond longer
//! than the others, and then begins with the whole offset of its clock. So one federate has its *turn* at a time, from
//! its first exchange to its last: those of others would hold it up, on this computer and on theirs. T1 is said apart
//! from everything else, when the owner is ready to write it. And where many come at once, the first exchange begins
//! when their handshakes have come to where they wait for it: when nothing of that has been heard for [`QUIET`].
//!
//! Who does not answer holds nobody up for long: after [`EXCHANGE_TIME_OUT`] the next one has its turn, too. Federates whose
//! answers always take that long are so far away that it is not each other that they wait for.

use lf_model::time::{Instant, Interval};
use lf_wire::{Message, MessageType};

use super::members::Members;
use super::outlet::{ConnectionId, Outlet};
use super::storage::Phase;
use crate::Deadline;

/// How long the next federate waits for the answer of the one before it.
const EXCHANGE_TIME_OUT: Interval = Interval::from_millis(10);
/// How long the RTI has heard nothing of handshakes when exchanges begin.
const QUIET: Interval = Interval::from_millis(1);
/// How long a federate waits for that.
const QUIET_WITHIN: Interval = Interval::from_millis(20);

/// Bytes of T1 and of T4.
pub(super) const TIME_MESSAGE_BYTES: usize = MessageType::T1.fixed_bytes();

/// Whose turn it is, and who waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Exchanges {
    /// The connection whose turn it is, and until when others wait for its answer.
    current: Option<(ConnectionId, Instant)>,
    /// How many connections wait for their turn.
    waiting: u16,
    /// How many connections are to be sent their next T1.
    asked: u16,
    /// From when on it is quiet, unless more is heard.
    quiet: Instant,
    /// Until when those that wait do so for that.
    begin: Instant,
}

impl Default for Exchanges {
    fn default() -> Self {
        Self { current: None, waiting: 0, asked: 0, quiet: Instant::NEVER, begin: Instant::NEVER }
    }
}

impl Exchanges {
    /// When [`Exchanges::poll`] has something to send.
    pub(super) fn poll_timeout(&self) -> Deadline {
        let Self { current, waiting, asked, quiet, begin } = *self;
        match current {
            _ if asked > 0 => Deadline::Now,
            _ if waiting == 0 => Deadline::Never,
            Some((_, until)) => Deadline::At(until),
            None => Deadline::At(quiet.min(begin)),
        }
    }

    /// Sends a T1 that tells `now`, if one is due and there is room for it, and gives its connection. Its answer may
    /// take as long as `time_out`.
    ///
    /// Looks at each connection at most once.
    pub(super) fn poll(
        &mut self,
        now: Instant,
        time_out: Interval,
        members: &mut Members<'_>,
        outlet: &mut impl Outlet,
    ) -> Option<ConnectionId> {
        if !self.poll_timeout().is_due(now) {
            return None;
        }
        let (connection, left) = self.next(members)?;
        let is_next = matches!(members.phase(connection), Phase::Turn { .. });
        let count = if is_next { &mut self.waiting } else { &mut self.asked };
        *count = count.saturating_sub(1);
        if is_next || self.current() == Some(connection) {
            self.current = Some((connection, now + EXCHANGE_TIME_OUT));
        }
        members.set_deadline(connection, Some(now + time_out));
        let known = &mut members.connections[connection.0];
        if outlet.room(connection) < TIME_MESSAGE_BYTES {
            known.phase = Phase::Full { left };
            return None;
        }
        known.phase = Phase::ClockSync { left };
        outlet.send(connection, &Message::T1(now.as_nanos()));
        Some(connection)
    }

    /// There is more room on a connection: perhaps for the T1 that it is to be sent.
    pub(super) fn retry(&mut self, members: &mut Members<'_>, connection: ConnectionId) {
        if let Phase::Full { left } = members.phase(connection) {
            self.ask_again(members, connection, left);
        }
    }

    /// The connection whose exchanges are under way.
    pub(super) fn current(&self) -> Option<ConnectionId> {
        self.current.map(|(connection, _)| connection)
    }

    /// The connection that is to be sent T1, and how many exchanges it has from there on.
    fn next(&self, members: &Members<'_>) -> Option<(ConnectionId, u32)> {
        let connections = || (0..).map(ConnectionId).zip(members.connections.iter());
        if self.asked > 0 {
            return connections().find_map(|(connection, known)| match known.phase {
                Phase::Asked { left } => Some((connection, left)),
                _ => None,
            });
        }
        let waiting = connections().filter_map(|(connection, known)| match known.phase {
            Phase::Turn { since, trials } => Some((since, connection, trials)),
            _ => None,
        });
        waiting.min().map(|(_, connection, trials)| (connection, trials))
    }

    /// There is a new connection, or something of its handshake has come: more may come at once.
    pub(super) fn note_handshake(&mut self, now: Instant) {
        self.quiet = now + QUIET;
    }

    /// A connection waits for its turn.
    pub(super) fn await_turn(
        &mut self,
        now: Instant,
        members: &mut Members<'_>,
        connection: ConnectionId,
        trials: u32,
    ) {
        members.connections[connection.0].phase = Phase::Turn { since: now, trials };
        if self.waiting == 0 {
            self.begin = now + QUIET_WITHIN;
        }
        self.waiting = self.waiting.saturating_add(1);
    }

    /// A connection is to be sent its next T1.
    pub(super) fn ask_again(&mut self, members: &mut Members<'_>, connection: ConnectionId, left: u32) {
        members.connections[connection.0].phase = Phase::Asked { left };
        self.asked = self.asked.saturating_add(1);
    }

    /// A connection has had its exchanges, or has no more.
    pub(super) fn leave(&mut self, members: &Members<'_>, connection: ConnectionId) {
        match members.phase(connection) {
            Phase::Turn { .. } => self.waiting = self.waiting.saturating_sub(1),
            Phase::Asked { .. } => self.asked = self.asked.saturating_sub(1),
            _ => {}
        }
        if self.current() == Some(connection) {
            self.current = None;
        }
    }
}
