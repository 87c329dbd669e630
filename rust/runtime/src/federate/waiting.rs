// SPDX-License-Identifier: Apache-2.0
//! Logs what a federate waits for, when that lasts.
//!
//! Before the start it always logs it, after a while and then ever more rarely; while the federate runs, if the program
//! asks for it with `log-waits`.

use lf_coordination::Deadline;
use lf_coordination::federate::Needs;
use lf_model::time::{Instant, Interval, Tag};
use log::Level;

use super::execution::{Advance, Execution};
use super::reason::{Key, Reason};
use crate::log_event::{FederateEvent, report};

/// The time after which a federate logs what its start waits for, and the longest pause until it logs that again.
const START_REPORT: Interval = Interval::from_secs(5);
const START_REPORT_PAUSE_MAX: Interval = Interval::from_secs(60);

/// The current wait.
#[derive(Debug)]
pub(super) struct Waiting {
    /// Its identity, if there is a wait; otherwise the other fields have no meaning.
    key: Option<Key>,
    since: Instant,
    /// The time at which to log it; NEVER once it was logged for good.
    due: Instant,
    pause: Interval,
}

impl Waiting {
    /// Nothing is waited for.
    pub(super) const NONE: Self = Self { key: None, since: Instant::NEVER, due: Instant::NEVER, pause: Interval::ZERO };

    /// Records the current wait, and logs it if it has lasted, while the federate runs for as long as `log_waits`.
    /// Returns when to call again. `local` is the time of a tag on the platform's clock, `start` the federation's
    /// start.
    ///
    /// A wait counts from its first record, but before the time of its tag a federate waits for that only.
    pub(super) fn note(
        &mut self,
        now: Instant,
        reason: Option<Reason>,
        log_waits: Option<Interval>,
        local: impl Fn(Tag) -> Option<Instant>,
        start: Instant,
    ) -> Deadline {
        let limit = |reason: &Reason| if reason.is_before_start() { Some(START_REPORT) } else { log_waits };
        let Some((reason, limit)) = reason.as_ref().and_then(|reason| Some((reason, limit(reason)?))) else {
            self.key = None;
            return Deadline::Never;
        };
        let key = reason.key();
        if self.key != Some(key) {
            self.since = match reason {
                Reason::Grant(tag) | Reason::Input(tag, _) => local(*tag).map_or(now, |time| time.max(now)),
                _ => now,
            };
            (self.key, self.due, self.pause) = (Some(key), self.since + limit, limit);
        }
        if self.due != Instant::NEVER && self.due <= now {
            let (lasts, is_before_start) = (now.since(self.since), reason.is_before_start());
            let level = if is_before_start { Level::Info } else { Level::Warn };
            report(level, &FederateEvent::Waits { reason: *reason, start, lasts });
            self.pause = self.pause.saturating_add(self.pause).min(START_REPORT_PAUSE_MAX);
            self.due = if is_before_start { now + self.pause } else { Instant::NEVER };
        }
        if self.due == Instant::NEVER { Deadline::Never } else { Deadline::At(self.due) }
    }
}

/// Returns what this federate waits for, if it is not just the time: after `advance`, with `peer`, the federate that
/// has to accept what has no room.
pub(super) fn reason(execution: &Execution<'_, '_, impl Needs>, advance: Advance, peer: Option<u16>) -> Option<Reason> {
    let tag = execution.tag_in_question()?;
    let unknown = || execution.unknown_input(tag).map(|input| Reason::Input(tag, execution.name_of(input)));
    match advance {
        Advance::OutputFull => Some(Reason::Room(tag, peer)),
        Advance::NotGranted if execution.is_decentralized() => unknown(),
        Advance::NotGranted => {
            unknown().or_else(|| (!execution.machine.may_advance(tag)).then_some(Reason::Grant(tag)))
        }
        // With decentralized coordination a wait has an end.
        Advance::Until(_) => unknown(),
        Advance::Done => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::PeerFault;
    use lf_coordination::{Endpoint, IpAddress};

    const AT: Endpoint = Endpoint { ip: IpAddress::UNSPECIFIED, port: 15045 };

    const fn s(seconds: i64) -> Instant {
        Instant::from_nanos(seconds * 1_000_000_000)
    }

    fn note(waiting: &mut Waiting, now: i64, reason: Option<Reason>, log_waits: Option<i64>) -> Deadline {
        let log_waits = log_waits.map(Interval::from_secs);
        waiting.note(s(now), reason, log_waits, |tag| Some(tag.time), s(0))
    }

    #[test]
    fn before_the_start_a_wait_is_said_ever_more_rarely_and_another_one_counts_anew() {
        let mut waiting = Waiting::NONE;
        let mut now = 0;
        for expected in [5, 15, 35, 75, 135, 195] {
            assert_eq!(note(&mut waiting, now, Some(Reason::Rti(AT, None)), None), Deadline::At(s(expected)));
            now = expected;
        }
        assert_eq!(note(&mut waiting, 200, Some(Reason::Others), None), Deadline::At(s(205)));
        // A fault of a federate does not make another wait of it.
        assert_eq!(note(&mut waiting, 201, Some(Reason::Peer(1, None)), None), Deadline::At(s(206)));
        let again = Some(Reason::Peer(1, Some(PeerFault::Unanswered)));
        assert_eq!(note(&mut waiting, 202, again, None), Deadline::At(s(206)));
    }

    #[test]
    fn a_running_federate_says_a_wait_once_and_only_where_that_is_asked_for() {
        let mut waiting = Waiting::NONE;
        let grant = Some(Reason::Grant(Tag::at(s(10))));
        assert_eq!(note(&mut waiting, 1, grant, None), Deadline::Never);
        // Before the time of its tag it waits for that.
        assert_eq!(note(&mut waiting, 1, grant, Some(2)), Deadline::At(s(12)));
        assert_eq!(note(&mut waiting, 12, grant, Some(2)), Deadline::Never);
        assert_eq!(note(&mut waiting, 13, None, Some(2)), Deadline::Never);
        assert_eq!(note(&mut waiting, 14, grant, Some(2)), Deadline::At(s(16)));
    }
}
