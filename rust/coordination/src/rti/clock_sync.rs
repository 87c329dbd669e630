// SPDX-License-Identifier: Apache-2.0
//! The rounds of clock synchronization over UDP.
//!
//! From the start on, each federate that asks for it is polled once per period, one after the other and evenly spread,
//! so that the answer of one does not wait behind those of others. The RTI only tells its time; what to make of it is
//! the federates' business.

use core::net::{Ipv4Addr, SocketAddrV4};

use lf_model::time::{Instant, Interval};
use lf_wire::{Decoded, Limits, Message, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF, decode};

use super::storage::Membership;
use super::{ClockSync, Notice, Outlet, Rti};
use crate::Deadline;

/// A datagram to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram {
    /// To where.
    pub to: SocketAddrV4,
    /// What it says.
    pub message: Message<'static>,
}

/// Whose turn is next, and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Rounds {
    next: Option<Instant>,
    /// Nobody is left who takes part.
    over: bool,
    cursor: usize,
    /// How many took part when the last period began.
    count: u16,
    /// Strangers have been told of.
    told: bool,
}

impl Rti<'_> {
    /// When [`poll_round`](Self::poll_round) has something to send.
    pub fn poll_round_timeout(&self) -> Deadline {
        match (self.config.clock_sync, self.start) {
            (ClockSync::On { .. }, Some(start)) if !self.rounds.over => Deadline::At(self.rounds.next.unwrap_or(start)),
            _ => Deadline::Never,
        }
    }

    /// The T1 that is to be sent at `now`, which is the time that it tells: send it at once. At most one; looks at
    /// every federate at most once.
    pub fn poll_round(&mut self, now: Instant) -> Option<Datagram> {
        let ClockSync::On { period, .. } = self.config.clock_sync else { return None };
        if !self.poll_round_timeout().is_due(now) {
            return None;
        }
        let federate = self.next_to_poll();
        let step = Interval(period.as_nanos() / i64::from(self.rounds.count.max(1))).max(Interval(1));
        let due = self.rounds.next.unwrap_or(now) + step;
        // Rounds that were missed are not made up for: that would only be a burst.
        self.rounds.next = Some(if due > now { due } else { now + step });
        let Some((federate, to)) = federate else {
            self.rounds.over = true;
            return None;
        };
        let begins = self.slots[federate].poll.begin(now);
        begins.then_some(Datagram { to, message: Message::T1(now.as_nanos()) })
    }

    /// A datagram has come; `now` is the time right after it was read. If it is a T3 that is awaited, gives T4, which
    /// is to be sent at once, and behind it [`Datagram::coded_probe`] with the time right before that is sent.
    pub fn handle_datagram(
        &mut self,
        now: Instant,
        from: SocketAddrV4,
        datagram: &[u8],
        outlet: &mut impl Outlet,
    ) -> Option<Datagram> {
        let sender = match decode(datagram, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::T3 { federate }, len }) if len == datagram.len() => {
                Some(usize::from(federate)).filter(|federate| self.takes_part(*federate) == Some(from))
            }
            _ => None,
        };
        let Some(federate) = sender else {
            if !core::mem::replace(&mut self.rounds.told, true) {
                outlet.notice(Notice::Stranger(from));
            }
            return None;
        };
        let awaited = self.slots[federate].poll.answer(now);
        awaited.then_some(Datagram { to: from, message: Message::T4(now.as_nanos()) })
    }

    /// Where a federate is to be reached, if it takes part.
    fn takes_part(&self, federate: usize) -> Option<SocketAddrV4> {
        let slot = self.slots.get(federate)?;
        let is_there = matches!(slot.membership, Membership::Joined(_));
        let asks = !matches!(slot.udp_port, UDP_PORT_CLOCK_SYNC_INITIAL | UDP_PORT_CLOCK_SYNC_OFF);
        let address = SocketAddrV4::new(Ipv4Addr::from(slot.address), slot.udp_port);
        (is_there && asks).then_some(address)
    }

    /// The federate whose turn is next; `None` when nobody takes part.
    fn next_to_poll(&mut self) -> Option<(usize, SocketAddrV4)> {
        for _ in 0..self.slots.len() {
            let federate = self.rounds.cursor;
            if federate == 0 {
                let count = (0..self.slots.len()).filter(|federate| self.takes_part(*federate).is_some()).count();
                self.rounds.count = u16::try_from(count).unwrap_or(u16::MAX);
            }
            self.rounds.cursor = (federate + 1) % self.slots.len();
            if let Some(address) = self.takes_part(federate) {
                return Some((federate, address));
            }
        }
        None
    }
}

impl Datagram {
    /// The coded probe that follows a T4; `now` is the time right before it is sent.
    #[must_use]
    pub fn coded_probe(self, now: Instant) -> Self {
        Self { message: Message::CodedProbe(now.as_nanos()), ..self }
    }
}
