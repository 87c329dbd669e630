// SPDX-License-Identifier: Apache-2.0
//! The start barrier: the federation starts when all federates have joined and told their clocks.

use lf_model::time::{Instant, Interval};
use lf_wire::MessageType;

use super::doubt::CLOCK_MAX;
use super::storage::Membership;
use super::watch::Watch;
use super::{Notice, Outlet, Rti, START_DELAY, Violation};

impl Rti<'_> {
    /// A federate tells its clock, which it does once.
    pub(super) fn on_timestamp(
        &mut self,
        federate: usize,
        clock: Instant,
        outlet: &mut impl Outlet,
    ) -> Result<(), Violation> {
        if self.start.is_some() || self.slots[federate].clock.is_some() {
            return Err(Violation::Unexpected(MessageType::Timestamp));
        }
        if clock >= CLOCK_MAX {
            return Err(Violation::Clock(clock));
        }
        self.slots[federate].clock = Some(clock);
        let mut latest = clock;
        for slot in self.slots.iter() {
            match (slot.membership, slot.clock) {
                (Membership::Joined(_), Some(clock)) => latest = latest.max(clock),
                _ => return Ok(()),
            }
        }
        let start = start_time(latest, self.config.start_time_multiple);
        self.start = Some(start);
        self.watch = Watch::default();
        self.graph.find_paths();
        outlet.notice(Notice::Started(start));
        self.doubt_clocks(outlet);
        self.broadcast(|_| true, |pending| pending.start = true, outlet);
        Ok(())
    }
}

/// A second after the latest clock, rounded up to a multiple if there is one.
fn start_time(latest_clock: Instant, multiple: Option<Interval>) -> Instant {
    let earliest = latest_clock + START_DELAY;
    let Some(multiple) = multiple else { return earliest };
    match earliest.as_nanos().checked_rem_euclid(multiple.as_nanos()) {
        None | Some(0) => earliest,
        Some(past) => earliest + Interval(multiple.as_nanos() - past),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_is_a_second_later_and_rounded_up() {
        assert_eq!(start_time(Instant(5), None), Instant(1_000_000_005));
        assert_eq!(start_time(Instant(5), Some(Interval(10))), Instant(1_000_000_010));
        assert_eq!(start_time(Instant(0), Some(Interval(10))), Instant(1_000_000_000));
        assert_eq!(start_time(Instant(-2_000_000_005), Some(Interval(10))), Instant(-1_000_000_000));
    }

    #[test]
    fn a_clock_at_the_end_of_time_is_no_overflow() {
        assert_eq!(start_time(Instant(i64::MAX - 1), Some(Interval(1000))), Instant(i64::MAX));
    }
}
