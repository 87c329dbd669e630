// SPDX-License-Identifier: Apache-2.0
//! Reports of waits: before the start after a while, and while the federation runs if the configuration asks for it.
//!
//! Nothing depends on it. It looks at all federates now and then, and costs nothing in between.

use lf_model::time::{EventTag, Instant, Interval, Tag};
use lf_wire::MessageType;

use super::log_event::RtiEvent;
use super::members::Members;
use super::outlet::Outlet;
use super::stop::Stop;
use super::storage::{Membership, Phase, Seen, id};
use super::tags::Tags;
use super::waits::{Progress, Waits};
use crate::Deadline;

/// The default time after which the RTI logs which federates the start waits for.
pub const START_REPORT: Interval = Interval::from_secs(5);
/// The longest pause until the next such report.
const START_REPORT_PAUSE_MAX: Interval = Interval::from_secs(60);
/// The number of federates that one report names.
const NAMED_MAX: usize = 8;
/// The number of checks within the time after which a wait is logged, while the federation runs.
const CHECKS: i64 = 4;

/// The time of the next check.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    due: Deadline,
    pause: Interval,
}

impl Default for Watch {
    fn default() -> Self {
        Self { due: Deadline::Now, pause: Interval::ZERO }
    }
}

impl Watch {
    /// Returns the time of the next check, while there is something to check.
    pub(super) fn deadline(&self) -> Deadline {
        self.due
    }

    /// Looks for the federates that the start waits for, and logs them once the wait has lasted. `interval` is that
    /// time for the first report.
    pub(super) fn check_start(
        &mut self,
        now: Instant,
        interval: Interval,
        members: &Members<'_>,
        outlet: &mut impl Outlet,
    ) {
        let begins = self.pause == Interval::ZERO;
        self.pause = if begins {
            interval
        } else {
            report_start(members, outlet);
            Interval::from_nanos(self.pause.as_nanos().saturating_mul(2)).min(START_REPORT_PAUSE_MAX)
        };
        self.due = Deadline::At(now + self.pause);
    }

    /// Does the same while the federation runs.
    pub(super) fn check(
        &mut self,
        now: Instant,
        interval: Interval,
        members: &mut Members<'_>,
        tags: &Tags<'_>,
        stop: &Stop,
        outlet: &mut impl Outlet,
    ) {
        report_waits(now, interval, members, tags, stop, outlet);
        self.pause = Interval::from_nanos((interval.as_nanos() / CHECKS).max(1));
        self.due = Deadline::At(now + self.pause);
    }
}

/// Logs the federates that the start waits for.
fn report_start(members: &Members<'_>, outlet: &mut impl Outlet) {
    let missing = || (0..members.slots.len()).filter_map(|federate| Some((federate, progress(members, federate)?)));
    let count = |number: usize| u16::try_from(number).unwrap_or(u16::MAX);
    outlet.log(RtiEvent::Waits(Waits::Start {
        missing: count(missing().count()),
        federates: count(members.slots.len()),
        strangers: count(members.strangers().count()),
    }));
    for (federate, progress) in missing().take(NAMED_MAX) {
        outlet.log(RtiEvent::Waits(Waits::StartFor { federate: id(federate), progress }));
    }
    let more = missing().count().saturating_sub(NAMED_MAX);
    if more > 0 {
        outlet.log(RtiEvent::Waits(Waits::StartForMore(count(more))));
    }
}

/// Returns the progress of a federate, unless it is ready.
fn progress(members: &Members<'_>, federate: usize) -> Option<Progress> {
    let slot = &members.slots[federate];
    match slot.membership {
        Membership::Free | Membership::Departed => Some(Progress::Absent),
        Membership::Joined(_) if slot.clock.is_some() => None,
        Membership::Joined(_) => Some(Progress::Joined),
        Membership::Joining(connection) => {
            let next = match members.phase(connection) {
                Phase::Neighbors => MessageType::NeighborStructure,
                Phase::UdpPort => MessageType::UdpPort,
                _ => MessageType::T3,
            };
            Some(Progress::Handshake(next))
        }
    }
}

/// Logs federates that have been waiting for too long: for a grant of an event whose time has come, or for those that
/// have not agreed to a stop.
fn report_waits(
    now: Instant,
    interval: Interval,
    members: &mut Members<'_>,
    tags: &Tags<'_>,
    stop: &Stop,
    outlet: &mut impl Outlet,
) {
    let Some(start) = tags.start else { return };
    let stops = stop.is_requested();
    for federate in 0..members.slots.len() {
        let is_there = members.running(federate).is_some();
        let waits_for_it = is_there && stop.awaits(&members.slots[federate]);
        let awaited = tags.awaited(federate).filter(|_| is_there && !stops);
        // The time of a stop is the one at which it was first seen.
        let (tag, begins) = match (waits_for_it, awaited) {
            (true, _) => (Tag::FOREVER, now),
            (false, Some(tag)) => (tag, now.max(tag.time)),
            (false, None) => (Tag::NEVER, now),
        };
        let seen = &mut members.slots[federate].seen;
        if seen.tag != tag {
            *seen = Seen { tag, since: begins, logged: false };
        }
        let lasts = now.since(seen.since);
        if tag == Tag::NEVER || seen.logged || lasts < interval {
            continue;
        }
        seen.logged = true;
        let federate_id = id(federate);
        outlet.log(RtiEvent::Waits(if waits_for_it {
            Waits::Stop(federate_id)
        } else {
            let (by, at) = tags.blocking_federate(federate).unwrap_or((federate_id, tag));
            let [tag, at] = [tag, at].map(|tag| EventTag::relative(tag, start));
            Waits::Grant { federate: federate_id, tag, lasts, by, at }
        }));
    }
}
