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

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::super::outlet::ConnectionId;
    use super::*;
    use crate::IpAddress;

    const PERIOD: Interval = Interval::from_nanos(90);
    const T3: u8 = lf_wire::MessageType::T3.byte();

    /// Counts what is logged.
    #[derive(Default)]
    struct Log(usize);

    impl Outlet for Log {
        fn room(&self, _: ConnectionId) -> usize {
            0
        }
        fn send(&mut self, _: ConnectionId, _: &Message<'_>) {}
        fn half_close(&mut self, _: ConnectionId) {}
        fn close(&mut self, _: ConnectionId) {}
        fn log(&mut self, _: RtiEvent<'_>) {
            self.0 += 1;
        }
    }

    fn at(nanos: i64) -> Instant {
        Instant::from_nanos(nanos)
    }

    fn endpoint(udp_port: u16) -> Endpoint {
        Endpoint::new(IpAddress::UNSPECIFIED, udp_port)
    }

    /// Returns the slots of federates that have joined, with these UDP ports.
    fn joined<const N: usize>(udp_ports: [u16; N]) -> [Slot; N] {
        let membership = Membership::Joined(ConnectionId(0));
        udp_ports.map(|udp_port| Slot { membership, udp_port, ..Slot::EMPTY })
    }

    /// Returns the ports that the rounds poll at these times, each of which is when the round before said.
    fn polls(rounds: &mut Rounds, slots: &mut [Slot], count: usize) -> Vec<(i64, Option<u16>)> {
        let mut polls = Vec::new();
        for _ in 0..count {
            let Deadline::At(now) = rounds.poll_timeout(at(0)) else { break };
            let sent = rounds.poll(now, PERIOD, slots);
            if let Some(datagram) = sent {
                assert_eq!(datagram.message, Message::T1(now.as_nanos()));
            }
            polls.push((now.as_nanos(), sent.map(|datagram| datagram.to.port)));
            for slot in &mut *slots {
                slot.poll.answer(now);
            }
        }
        polls
    }

    #[test]
    fn those_who_ask_for_rounds_take_turns_within_a_period() {
        let mut slots = joined([7, UDP_PORT_CLOCK_SYNC_OFF, 8, UDP_PORT_CLOCK_SYNC_INITIAL, 9, 10]);
        slots[5].membership = Membership::Departed;
        let expected = [(0, 7), (30, 8), (60, 9), (90, 7), (120, 8)].map(|(time, port)| (time, Some(port)));
        assert_eq!(polls(&mut Rounds::default(), &mut slots, 5), expected);
    }

    #[test]
    fn without_participants_rounds_are_over_until_one_joins() {
        let (mut rounds, mut slots) = (Rounds::default(), joined([UDP_PORT_CLOCK_SYNC_OFF, 8]));
        slots[1].membership = Membership::Free;
        assert_eq!(polls(&mut rounds, &mut slots, 5), [(0, None)]);
        slots[1].membership = Membership::Joined(ConnectionId(0));
        rounds.resume();
        assert_eq!(polls(&mut rounds, &mut slots, 2), [(90, Some(8)), (180, Some(8))]);
    }

    #[test]
    fn rounds_that_were_missed_are_not_repeated() {
        let (mut rounds, mut slots) = (Rounds::default(), joined([7]));
        polls(&mut rounds, &mut slots, 1);
        for (now, next) in [(95, 180), (270, 360), (1_000, 1_090)] {
            assert!(rounds.poll(at(now), PERIOD, &mut slots).is_some());
            slots[0].poll.answer(at(now));
            assert_eq!(rounds.poll_timeout(at(0)), Deadline::At(at(next)));
        }
    }

    #[test]
    fn strangers_are_not_answered_and_logged_once() {
        let (mut rounds, mut slots, mut log) = (Rounds::default(), joined([7, 8]), Log::default());
        polls(&mut rounds, &mut slots, 2);
        rounds.poll(at(200), PERIOD, &mut slots);
        let t3 = [T3, 0, 0];
        let longer = [T3, 0, 0, 0];
        for (from, datagram) in [(8, &t3[..]), (7, &longer), (7, &t3[..2])] {
            assert_eq!(rounds.handle_datagram(at(210), endpoint(from), datagram, &mut slots, &mut log), None);
        }
        assert_eq!(log.0, 1);
        let mut answer = || rounds.handle_datagram(at(220), endpoint(7), &t3, &mut slots, &mut log);
        assert_eq!(answer(), Some(Datagram { to: endpoint(7), message: Message::T4(220) }));
        assert_eq!(answer(), None, "one round has one answer");
    }
}
