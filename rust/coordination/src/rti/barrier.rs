// SPDX-License-Identifier: Apache-2.0
//! The start barrier: the federation starts when all federates have joined and sent their clocks.
//!
//! A federate that has not come yet may be started by hand, at any time. A federate that has come and gone before the
//! start has most likely failed, and the others would wait for it without end. So they wait for a limited time from the
//! first such loss on; then the RTI names the missing federates and ends the federation. When all that have left have
//! come back, there is no limit any more.

use lf_model::time::{Instant, Interval};
use lf_wire::MessageType;

use super::config::START_DELAY;
use super::log_event::{RtiEvent, Violation};
use super::outcome::Outcome;
use super::outlet::Outlet;
use super::storage::{Membership, Slot, id};
use super::suspected_violation::{CLOCK_MAX, CLOCK_MIN, SuspectedViolation};
use crate::FederateId;

/// The distance of two federates' clocks at the start above which the RTI logs it. A federate reads its clock some time
/// before the RTI receives it, and on a busy computer that can be a while.
const CLOCKS_APART_MAX: Interval = Interval::from_secs(2);

/// The federates that have left before the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Barrier {
    /// Whether a federate has left since the clocks were last checked.
    left: bool,
    deadline: Option<Instant>,
    /// After the time is over: the first missing federate, and the number of missing ones.
    missing: Option<(FederateId, u16)>,
}

impl Barrier {
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    pub(super) fn outcome(&self) -> Option<Outcome> {
        self.missing.map(|(first, missing)| Outcome::NotStarted { first, missing })
    }

    /// Frees the slot of a federate that leaves before the start, which does not wait for a transient one.
    pub(super) fn vacate(&mut self, slot: &mut Slot) {
        let vacated = !slot.is_transient();
        *slot = Slot { vacated, ..Slot::default() };
        self.left |= vacated;
    }

    /// Records that a federate has taken its slot.
    pub(super) fn occupy(&mut self, slots: &mut [Slot], federate: usize) {
        slots[federate].vacated = false;
        if !slots.iter().any(|slot| slot.vacated) {
            *self = Self::default();
        }
    }

    /// Sets the time within which those that have left before the start may come back. Call it after everything that
    /// can make a federate leave; `until` is `None` if there is no limit, or nothing to start any more.
    pub(super) fn limit(&mut self, until: Option<Instant>) {
        if core::mem::take(&mut self.left) {
            self.deadline = self.deadline.or(until);
        }
    }

    /// Ends the time to come back: names the missing federates.
    pub(super) fn give_up(&mut self, slots: &[Slot], outlet: &mut impl Outlet) {
        let mut missing = None;
        for (index, slot) in slots.iter().enumerate() {
            if !matches!(slot.membership, Membership::Joined(_)) {
                outlet.log(RtiEvent::Missing(id(index)));
                let (first, count) = missing.unwrap_or((id(index), 0_u16));
                missing = Some((first, count.saturating_add(1)));
            }
        }
        *self = Self { missing, ..Self::default() };
    }
}

/// Records a federate's clock, which it sends once; `now` is the RTI's.
pub(super) fn take_clock(slot: &mut Slot, now: Instant, clock: Instant) -> Result<(), Violation> {
    if slot.clock.is_some() {
        return Err(Violation::Unexpected(MessageType::Timestamp));
    }
    if clock >= CLOCK_MAX || clock < CLOCK_MIN {
        return Err(Violation::Clock(clock));
    }
    slot.clock = Some(clock);
    slot.ahead = clock.since(now);
    Ok(())
}

/// Returns the latest clock when all federates have sent theirs, but for as many transient ones as are `optional`.
pub(super) fn latest_clock(slots: &[Slot], optional: usize) -> Option<Instant> {
    let is_there = |slot: &&Slot| matches!(slot.membership, Membership::Joined(_)) && slot.clock.is_some();
    let persistent = slots.iter().filter(is_there).filter(|slot| !slot.is_transient());
    let complete = persistent.count() + optional >= slots.len();
    slots.iter().filter(is_there).filter_map(|slot| slot.clock).max().filter(|_| complete)
}

/// Returns the federate whose clock is far ahead of another one's, when all have sent theirs. They were sent at
/// different times, so each is compared with the RTI's clock at that time.
pub(super) fn check_clocks(slots: &[Slot]) -> Option<(usize, SuspectedViolation)> {
    let there = || (0..).zip(slots).filter(|(_, slot)| slot.clock.is_some());
    let clocks = || there().map(|(federate, slot)| (slot.ahead, federate));
    let ((earliest, of), (latest, ahead)) = (clocks().min()?, clocks().max()?);
    let by = Interval::from_nanos(latest.as_nanos().saturating_sub(earliest.as_nanos()));
    (by > CLOCKS_APART_MAX).then_some((ahead, SuspectedViolation::Ahead { of: id(of), by }))
}

/// Returns the start time: a second after the latest clock, rounded up to a multiple if there is one.
pub(super) fn start_time(latest_clock: Instant, multiple: Option<Interval>) -> Instant {
    let earliest = latest_clock + START_DELAY;
    let Some(multiple) = multiple else { return earliest };
    match earliest.as_nanos().checked_rem_euclid(multiple.as_nanos()) {
        None | Some(0) => earliest,
        Some(past) => earliest + Interval::from_nanos(multiple.as_nanos() - past),
    }
}

#[cfg(test)]
mod tests {
    use super::super::outlet::ConnectionId;
    use super::*;

    #[test]
    fn the_start_is_a_second_later_and_rounded_up() {
        assert_eq!(start_time(Instant::from_nanos(5), None), Instant::from_nanos(1_000_000_005));
        assert_eq!(
            start_time(Instant::from_nanos(5), Some(Interval::from_nanos(10))),
            Instant::from_nanos(1_000_000_010)
        );
        assert_eq!(
            start_time(Instant::from_nanos(0), Some(Interval::from_nanos(10))),
            Instant::from_nanos(1_000_000_000)
        );
        assert_eq!(
            start_time(Instant::from_nanos(-2_000_000_005), Some(Interval::from_nanos(10))),
            Instant::from_nanos(-1_000_000_000)
        );
    }

    #[test]
    fn the_start_is_known_when_all_are_there_and_have_told_their_clocks() {
        let there = Slot { membership: Membership::Joined(ConnectionId(0)), ..Slot::EMPTY };
        let mut slots = [there, there, Slot::EMPTY];
        let take_clock = |slots: &mut [Slot], federate: usize, clock| {
            take_clock(&mut slots[federate], Instant::from_nanos(3), clock)?;
            Ok::<_, Violation>(latest_clock(slots, 0))
        };
        let before_all = Instant::from_nanos(CLOCK_MIN.as_nanos() - 1);
        for clock in [CLOCK_MAX, before_all, Instant::from_nanos(i64::MIN)] {
            assert_eq!(take_clock(&mut slots, 0, clock), Err(Violation::Clock(clock)));
        }
        assert_eq!(
            [(0, 9), (1, 5)].map(|(index, clock)| take_clock(&mut slots, index, Instant::from_nanos(clock))),
            [Ok(None); 2]
        );
        assert_eq!(take_clock(&mut [there], 0, CLOCK_MIN), Ok(Some(CLOCK_MIN)));
        let again = take_clock(&mut slots, 1, Instant::from_nanos(6));
        assert_eq!(again, Err(Violation::Unexpected(MessageType::Timestamp)));
        slots[2] = there;
        assert_eq!(take_clock(&mut slots, 2, Instant::from_nanos(7)), Ok(Some(Instant::from_nanos(9))));
    }

    #[test]
    fn federates_that_have_left_may_come_back_within_a_time_from_the_first_loss_on() {
        let (mut barrier, mut slots) = (Barrier::default(), [Slot::EMPTY; 2]);
        barrier.limit(Some(Instant::from_nanos(1)));
        assert_eq!(barrier.deadline(), None);
        for (index, now) in [(0, 2), (1, 3)] {
            barrier.vacate(&mut slots[index]);
            barrier.limit(Some(Instant::from_nanos(now)));
            assert_eq!(barrier.deadline(), Some(Instant::from_nanos(2)));
        }
        for (index, left) in [(0, Some(Instant::from_nanos(2))), (1, None)] {
            barrier.occupy(&mut slots, index);
            assert_eq!(barrier.deadline(), left);
        }
    }

    #[test]
    fn a_clock_at_the_end_of_time_is_no_overflow() {
        assert_eq!(
            start_time(Instant::from_nanos(i64::MAX - 1), Some(Interval::from_nanos(1000))),
            Instant::from_nanos(i64::MAX)
        );
    }
}
