// SPDX-License-Identifier: Apache-2.0
//! Who is waited for: said of the start after a while, and while the federation runs, if somebody asks for it.
//!
//! Nothing depends on it. It looks at all federates now and then, and costs nothing in between.

use core::fmt;

use lf_model::time::{EventTag, Instant, Interval, Tag};
use lf_wire::MessageType;

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

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

/// A wait that has lasted for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waits {
    /// The start has been waiting for some federates for a while; each of the first is named in a notice of its own.
    Start {
        /// How many are not ready.
        missing: u16,
        /// How many the federation has.
        federates: u16,
        /// How many connections there are that have not said which federates they are.
        strangers: u16,
    },
    /// One of them.
    StartFor {
        /// The federate.
        federate: FederateId,
        /// How far it is.
        progress: Progress,
    },
    /// So many more are missing.
    StartForMore(u16),
    /// A federate has been waiting for a grant for too long.
    Grant {
        /// The federate.
        federate: FederateId,
        /// The tag that it wants to begin.
        tag: EventTag,
        /// For how long.
        lasts: Interval,
        /// The federate that may still send something for that tag or an earlier one, however indirectly.
        by: FederateId,
        /// That one's next event, as far as it has said.
        at: EventTag,
    },
    /// A stop has been waiting for the agreement of this federate for too long.
    Stop(FederateId),
    /// The messages of a federate have been waiting for another one for too long.
    Sender {
        /// Whose messages wait.
        from: FederateId,
        /// For whom.
        to: FederateId,
        /// For room on its connection; otherwise until it has completed some tags.
        room: bool,
        /// For how long.
        lasts: Interval,
    },
}

impl fmt::Display for Waits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Start { missing, federates, strangers } => {
                write!(f, "the start waits for {missing} of {federates} federates")?;
                match strangers {
                    0 => Ok(()),
                    _ => write!(f, "; {strangers} connections have not said which federates they are"),
                }
            }
            Self::StartFor { federate, progress } => write!(f, "federate {federate} {progress}"),
            Self::StartForMore(more) => write!(f, "and {more} more"),
            Self::Grant { federate, tag, lasts, by, at } => write!(
                f,
                "federate {federate} has been waiting for {} ms for a grant of {tag}, because federate {by} may still \
                 send something: it has not got beyond {at}",
                millis(lasts)
            ),
            Self::Stop(federate) => {
                write!(f, "the stop waits for federate {federate}, which has not answered the request")
            }
            Self::Sender { from, to, room, lasts } => {
                write!(f, "messages of federate {from} have been waiting for {} ms, because ", millis(lasts))?;
                write!(f, "federate {to} ")?;
                f.write_str(if room { "does not take what it is sent" } else { "is too many tags behind" })
            }
        }
    }
}

fn millis(interval: Interval) -> i64 {
    interval.as_nanos() / 1_000_000
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
        outlet.notice(Notice::Waits(Waits::Start {
            missing: count(missing().count()),
            federates: count(self.slots.len()),
            strangers: count(strangers.count()),
        }));
        for (federate, progress) in missing().take(NAMED_MAX) {
            outlet.notice(Notice::Waits(Waits::StartFor { federate: id(federate), progress }));
        }
        let more = missing().count().saturating_sub(NAMED_MAX);
        if more > 0 {
            outlet.notice(Notice::Waits(Waits::StartForMore(count(more))));
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
            outlet.notice(Notice::Waits(if waits_for_it {
                Waits::Stop(federate_id)
            } else {
                let (by, at) = self.hindrance(federate).unwrap_or((federate_id, tag));
                let [tag, at] = [tag, at].map(|tag| EventTag::relative(tag, start));
                Waits::Grant { federate: federate_id, tag, lasts, by, at }
            }));
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
