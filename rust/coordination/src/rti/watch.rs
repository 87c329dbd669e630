// SPDX-License-Identifier: Apache-2.0
//! Who is waited for: said of the start after a while, and while the federation runs, if somebody asks for it.
//!
//! Nothing depends on it. It looks at all federates now and then, and costs nothing in between.

use lf_model::time::{EventTag, Instant, Interval, Tag};
use lf_wire::june_2026::MessageType;

use super::storage::{Membership, Phase};
use super::{Notice, Outlet, Rti, id};
use crate::{Deadline, FederateId};

/// After how long it is said for whom the start waits, unless told otherwise.
pub const START_REPORT: Interval = Interval::from_secs(5);
/// The longest pause until that is said again.
const START_REPORT_PAUSE_MAX: Interval = Interval::from_secs(60);
/// How many federates are named in one report.
const NAMED_MAX: usize = 8;
/// While the federation runs, it is looked this often within the time after which a wait is told.
const LOOKS: i64 = 4;

/// When to look again.
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

/// What a federate is waiting for since when, as far as the RTI has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Seen {
    tag: Tag,
    since: Instant,
    told: bool,
}

impl Seen {
    pub(super) const NOTHING: Self = Self { tag: Tag::NEVER, since: Instant::NEVER, told: false };
}

/// How far a federate is on its way to the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It has not connected, or not said which federate it is.
    Absent,
    /// It has connected, and this message of it is to come next.
    Handshake(MessageType),
    /// It has joined, and its clock is to come.
    Joined,
}

impl core::fmt::Display for Progress {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Absent => f.write_str("has not connected"),
            Self::Handshake(next) => write!(f, "has connected; {next} of it is to come"),
            Self::Joined => f.write_str(
                "has joined, but is not ready: it says so (TIMESTAMP) when it has connected to the federates to which \
                 it sends directly",
            ),
        }
    }
}

impl Rti<'_> {
    pub(super) fn watch_deadline(&self) -> Deadline {
        if self.watch_interval().is_some() { self.watch.due } else { Deadline::Never }
    }

    fn watch_interval(&self) -> Option<Interval> {
        if self.aborted || self.stop.granted().is_some() {
            return None;
        }
        if self.start.is_none() { self.config.start_report } else { self.config.log_waits }
    }

    /// Looks who is waited for, and says it where that has lasted.
    pub(super) fn look(&mut self, now: Instant, outlet: &mut impl Outlet) {
        let Some(interval) = self.watch_interval() else { return };
        if self.start.is_some() {
            self.look_for_waits(now, interval, outlet);
            let pause = Interval((interval.as_nanos() / LOOKS).max(1));
            self.watch = Watch { due: Deadline::At(now + pause), pause };
            return;
        }
        let begins = self.watch.pause == Interval::ZERO;
        let pause = if begins {
            interval
        } else {
            self.report_start(outlet);
            Interval(self.watch.pause.as_nanos().saturating_mul(2)).min(START_REPORT_PAUSE_MAX)
        };
        self.watch = Watch { due: Deadline::At(now + pause), pause };
    }

    /// Says for whom the start waits.
    fn report_start(&self, outlet: &mut impl Outlet) {
        let missing = || (0..self.slots.len()).filter_map(|federate| Some((federate, self.progress(federate)?)));
        let count = |number: usize| u16::try_from(number).unwrap_or(u16::MAX);
        let strangers = self.connections.iter().filter(|connection| {
            matches!(connection.phase, Phase::Nonce { .. } | Phase::Proof { .. } | Phase::Ids { .. })
        });
        outlet.notice(Notice::StartWaits {
            missing: count(missing().count()),
            federates: count(self.slots.len()),
            strangers: count(strangers.count()),
        });
        for (federate, progress) in missing().take(NAMED_MAX) {
            outlet.notice(Notice::StartWaitsFor { federate: id(federate), progress });
        }
        let more = missing().count().saturating_sub(NAMED_MAX);
        if more > 0 {
            outlet.notice(Notice::StartWaitsForMore(count(more)));
        }
    }

    /// How far a federate is, unless it is ready.
    fn progress(&self, federate: usize) -> Option<Progress> {
        let slot = &self.slots[federate];
        match slot.membership {
            Membership::Free | Membership::Departed => Some(Progress::Absent),
            Membership::Joined(_) if slot.clock.is_some() => None,
            Membership::Joined(_) => Some(Progress::Joined),
            Membership::Joining(connection) => {
                let next = match self.connections.get(connection.0).map(|connection| connection.phase) {
                    Some(Phase::Neighbors) => MessageType::NeighborStructure,
                    Some(Phase::UdpPort) => MessageType::UdpPort,
                    _ => MessageType::T3,
                };
                Some(Progress::Handshake(next))
            }
        }
    }

    /// Says which federates have been waiting for too long: for a grant of an event whose time has come, or for those
    /// that have not agreed to a stop.
    fn look_for_waits(&mut self, now: Instant, interval: Interval, outlet: &mut impl Outlet) {
        let Some(start) = self.start else { return };
        let stops = self.stop.is_requested();
        for federate in 0..self.slots.len() {
            let slot = &self.slots[federate];
            let waits_for_it = stops && !slot.stop_agreed && self.connection_of(federate).is_some();
            let awaited = self.awaited_tag(federate).filter(|_| !stops);
            // The time of a stop is that at which it was first seen.
            let (tag, begins) = match (waits_for_it, awaited) {
                (true, _) => (Tag::FOREVER, now),
                (false, Some(tag)) => (tag, now.max(tag.time)),
                (false, None) => (Tag::NEVER, now),
            };
            let seen = &mut self.slots[federate].seen;
            if seen.tag != tag {
                *seen = Seen { tag, since: begins, told: false };
            }
            let lasts = now.since(seen.since);
            if tag == Tag::NEVER || seen.told || lasts < interval {
                continue;
            }
            seen.told = true;
            let federate_id = id(federate);
            outlet.notice(if waits_for_it {
                Notice::StopWaitsFor(federate_id)
            } else {
                let (by, at) = self.hindrance(federate).unwrap_or((federate_id, tag));
                let [tag, at] = [tag, at].map(|tag| EventTag::relative(tag, start));
                Notice::WaitsForGrant { federate: federate_id, tag, lasts, by, at }
            });
        }
    }

    /// The tag that a federate waits for a grant of.
    fn awaited_tag(&self, federate: usize) -> Option<Tag> {
        let slot = &self.slots[federate];
        let next = self.graph.next_event(federate);
        let waits = self.graph.upstreams(federate) > 0 && next > slot.granted.max(slot.provisional);
        let is_there = self.connection_of(federate).is_some();
        (is_there && waits && next != Tag::NEVER && next != Tag::FOREVER).then_some(next)
    }

    /// The federate because of which another one is not granted more, and its next event.
    fn hindrance(&self, federate: usize) -> Option<(FederateId, Tag)> {
        let by = self.graph.earliest_source(federate)?;
        Some((id(by), self.graph.next_event(by)))
    }
}
