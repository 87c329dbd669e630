// SPDX-License-Identifier: Apache-2.0
//! The rounds of clock synchronization over UDP.
//!
//! From the start on, the RTI polls each federate that asks for it once per period, one after the other and evenly
//! spread, so that the answer of one does not wait behind those of others. The RTI only sends its time; the federates
//! compute the correction.

use lf_model::time::{Instant, Interval};
use lf_wire::{Decoded, Limits, Message, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF, decode};

use super::log_event::RtiEvent;
use super::outlet::Outlet;
use super::storage::{Membership, Slot};
use crate::{Deadline, Endpoint};

/// A datagram to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram {
    /// Its destination.
    pub to: Endpoint,
    /// Its content.
    pub message: Message<'static>,
}

/// The schedule of the rounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Rounds {
    next: Option<Instant>,
    /// Whether no participant is left.
    over: bool,
    cursor: usize,
    /// The number of participants when the last period began.
    count: u16,
    /// Whether strangers have been logged.
    logged: bool,
}

impl Rounds {
    /// Returns the time at which [`Rounds::poll`] has something to send, once the federation has a start.
    pub(super) fn poll_timeout(&self, start: Instant) -> Deadline {
        if self.over { Deadline::Never } else { Deadline::At(self.next.unwrap_or(start)) }
    }

    /// Handles that a federate has joined, perhaps when no participant was left.
    #[cfg(feature = "transients")]
    pub(super) fn resume(&mut self) {
        self.over = false;
    }

    /// Returns the T1 to send at `now`, if one is due. At most one; looks at every federate at most once.
    pub(super) fn poll(&mut self, now: Instant, period: Interval, slots: &mut [Slot]) -> Option<Datagram> {
        let federate = self.next_to_poll(slots);
        let step = Interval::from_nanos(period.as_nanos() / i64::from(self.count.max(1))).max(Interval::from_nanos(1));
        let due = self.next.unwrap_or(now) + step;
        // Missed rounds are not repeated: that would only make a burst.
        self.next = Some(if due > now { due } else { now + step });
        let Some((federate, to)) = federate else {
            self.over = true;
            return None;
        };
        let begins = slots[federate].poll.begin(now);
        begins.then_some(Datagram { to, message: Message::T1(now.as_nanos()) })
    }

    /// Handles a datagram; `now` is the time right after it was read. Returns T4 if it is an expected T3.
    pub(super) fn handle_datagram(
        &mut self,
        now: Instant,
        from: Endpoint,
        datagram: &[u8],
        slots: &mut [Slot],
        outlet: &mut impl Outlet,
    ) -> Option<Datagram> {
        let sender = match decode(datagram, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::T3 { federate }, len }) if len == datagram.len() => {
                slots.get_mut(usize::from(federate)).filter(|slot| takes_part(slot) == Some(from))
            }
            _ => None,
        };
        let Some(slot) = sender else {
            if !core::mem::replace(&mut self.logged, true) {
                outlet.log(RtiEvent::Stranger(from));
            }
            return None;
        };
        let awaited = slot.poll.answer(now);
        awaited.then_some(Datagram { to: from, message: Message::T4(now.as_nanos()) })
    }

    /// Returns the federate to poll next; `None` without participants.
    fn next_to_poll(&mut self, slots: &[Slot]) -> Option<(usize, Endpoint)> {
        for _ in 0..slots.len() {
            let federate = self.cursor;
            if federate == 0 {
                let count = slots.iter().filter(|slot| takes_part(slot).is_some()).count();
                self.count = u16::try_from(count).unwrap_or(u16::MAX);
            }
            self.cursor = (federate + 1) % slots.len();
            if let Some(address) = takes_part(&slots[federate]) {
                return Some((federate, address));
            }
        }
        None
    }
}

/// Returns the address of a federate, if it participates.
fn takes_part(slot: &Slot) -> Option<Endpoint> {
    let is_there = matches!(slot.membership, Membership::Joined(_));
    let asks = !matches!(slot.udp_port, UDP_PORT_CLOCK_SYNC_INITIAL | UDP_PORT_CLOCK_SYNC_OFF);
    let address = Endpoint::new(slot.address, slot.udp_port);
    (is_there && asks).then_some(address)
}

impl Datagram {
    /// Returns the coded probe that follows a T4; `now` is the time right before it is sent.
    #[must_use]
    pub fn coded_probe(self, now: Instant) -> Self {
        Self { message: Message::CodedProbe(now.as_nanos()), ..self }
    }
}
