// SPDX-License-Identifier: Apache-2.0
//! The exchanges of clock synchronization before the start: T1, T3 and T4, as often as was agreed, over TCP.
//!
//! A federate of the stock runtime discards all its exchanges if one of them takes a third of a millisecond longer than
//! the others, and then begins with the whole offset of its clock. So the RTI makes the exchanges of one connection at
//! a time, from the first to the last: those of others would delay it, on this computer and on theirs. It sends T1
//! separately from everything else, when the owner is ready to write it. And when many federates come at once, the
//! first exchange begins when their handshakes are complete up to this point: when none of them has sent anything for
//! [`QUIET`].
//!
//! A federate that does not answer holds the others up only for [`EXCHANGE_TIME_OUT`]; then the next one begins, too.
//! Federates whose answers always take longer are so distant that they do not wait because of each other.

use lf_model::time::{Instant, Interval};
use lf_wire::{Message, MessageType};

use super::members::Members;
use super::outlet::{ConnectionId, Outlet};
use super::storage::Phase;
use crate::Deadline;

/// The time that the next federate waits for the answer of the one before it.
const EXCHANGE_TIME_OUT: Interval = Interval::from_millis(10);
/// The silence of all handshakes after which exchanges begin.
const QUIET: Interval = Interval::from_millis(1);
/// The longest time that a federate waits for that silence.
const QUIET_WITHIN: Interval = Interval::from_millis(20);

/// Bytes of T1 and of T4.
pub(super) const TIME_MESSAGE_BYTES: usize = MessageType::T1.fixed_bytes();

/// The connections whose exchanges are open or waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Exchanges {
    /// The current connection, and the time until which others wait for its answer.
    current: Option<(ConnectionId, Instant)>,
    /// The number of waiting connections.
    waiting: u16,
    /// The number of connections whose next T1 is due.
    asked: u16,
    /// The time from which on it is quiet, unless more arrives.
    quiet: Instant,
    /// The time at which waiting connections stop waiting for quiet.
    begin: Instant,
}

impl Default for Exchanges {
    fn default() -> Self {
        Self { current: None, waiting: 0, asked: 0, quiet: Instant::NEVER, begin: Instant::NEVER }
    }
}

impl Exchanges {
    /// Returns the time at which [`Exchanges::poll`] has something to send.
    pub(super) fn poll_timeout(&self) -> Deadline {
        let Self { current, waiting, asked, quiet, begin } = *self;
        match current {
            _ if asked > 0 => Deadline::Now,
            _ if waiting == 0 => Deadline::Never,
            Some((_, until)) => Deadline::At(until),
            None => Deadline::At(quiet.min(begin)),
        }
    }

    /// Sends a T1 with `now`, if one is due and there is room for it, and returns its connection. Its answer may take
    /// as long as `time_out`.
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
        let is_next = matches!(members.phase(connection), Phase::AwaitsExchange { .. });
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

    /// Handles that there is more room on a connection: perhaps for its due T1.
    pub(super) fn retry(&mut self, members: &mut Members<'_>, connection: ConnectionId) {
        if let Phase::Full { left } = members.phase(connection) {
            self.ask_again(members, connection, left);
        }
    }

    /// Returns the connection whose exchanges are open.
    pub(super) fn current(&self) -> Option<ConnectionId> {
        self.current.map(|(connection, _)| connection)
    }

    /// Returns the connection to send T1 on, and the number of its remaining exchanges.
    fn next(&self, members: &Members<'_>) -> Option<(ConnectionId, u32)> {
        let connections = || (0..).map(ConnectionId).zip(members.connections.iter());
        if self.asked > 0 {
            return connections().find_map(|(connection, known)| match known.phase {
                Phase::Asked { left } => Some((connection, left)),
                _ => None,
            });
        }
        let waiting = connections().filter_map(|(connection, known)| match known.phase {
            Phase::AwaitsExchange { since, trials } => Some((since, connection, trials)),
            _ => None,
        });
        waiting.min().map(|(_, connection, trials)| (connection, trials))
    }

    /// Records a new connection, or a message of its handshake: more may follow at once.
    pub(super) fn record_handshake(&mut self, now: Instant) {
        self.quiet = now + QUIET;
    }

    /// Makes a connection wait for its exchanges.
    pub(super) fn await_exchange(
        &mut self,
        now: Instant,
        members: &mut Members<'_>,
        connection: ConnectionId,
        trials: u32,
    ) {
        members.connections[connection.0].phase = Phase::AwaitsExchange { since: now, trials };
        if self.waiting == 0 {
            self.begin = now + QUIET_WITHIN;
        }
        self.waiting = self.waiting.saturating_add(1);
    }

    /// Makes the next T1 of a connection due.
    pub(super) fn ask_again(&mut self, members: &mut Members<'_>, connection: ConnectionId, left: u32) {
        members.connections[connection.0].phase = Phase::Asked { left };
        self.asked = self.asked.saturating_add(1);
    }

    /// Records that a connection has completed or lost its exchanges.
    pub(super) fn leave(&mut self, members: &Members<'_>, connection: ConnectionId) {
        match members.phase(connection) {
            Phase::AwaitsExchange { .. } => self.waiting = self.waiting.saturating_sub(1),
            Phase::Asked { .. } => self.asked = self.asked.saturating_sub(1),
            _ => {}
        }
        if self.current() == Some(connection) {
            self.current = None;
        }
    }
}
