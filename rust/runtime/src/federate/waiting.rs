// SPDX-License-Identifier: Apache-2.0
//! What a federate waits for, said when that lasts.
//!
//! Before the start it is always said, after a while and then ever more rarely; while the federate runs, if the program
//! asks for it with `log-waits`.

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::federate::Phase;
use lf_model::time::{EventTag, Instant, Interval, Tag};

use super::execution::{Advance, Execution};
use crate::error::PeerFault;

/// After how long it is said what the start of a federate waits for, and the longest pause until it is said again.
const START_REPORT: Interval = Interval::from_secs(5);
const START_REPORT_PAUSE_MAX: Interval = Interval::from_secs(60);

/// What a federate waits for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Reason {
    /// An RTI that takes its connection.
    Rti,
    /// An answer of the RTI in the handshake.
    Answer(Phase),
    /// Another federate that takes its connection; what went wrong with the last attempt.
    Peer(u16, Option<PeerFault>),
    /// The start time, which the RTI tells when all federates are ready.
    Others,
    /// A grant of the RTI for this tag.
    Grant(Tag),
    /// What comes at this tag from the named connection.
    Input(Tag, &'static str),
    /// Others that have taken what this federate has sent at this tag: the RTI, or another federate.
    Room(Tag, Option<u16>),
}

impl Reason {
    /// Whether the federate has not started yet.
    fn is_before_start(self) -> bool {
        matches!(self, Self::Rti | Self::Answer(_) | Self::Peer(..) | Self::Others)
    }

    /// Whether this is the same wait as another one.
    fn is(self, other: Self) -> bool {
        match (self, other) {
            (Self::Peer(one, _), Self::Peer(other, _)) => one == other,
            _ => self == other,
        }
    }
}

/// A reason in words: what comes after "waiting for".
struct Words(Reason, Instant);

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(reason, start) = *self;
        let at = |tag| EventTag::relative(tag, start);
        match reason {
            Reason::Rti => f.write_str("an RTI that answers"),
            Reason::Answer(phase) => write!(f, "the RTI, {phase}"),
            Reason::Peer(federate, None) => write!(f, "federate {federate}, to which this one sends directly"),
            Reason::Peer(federate, Some(fault)) => write!(f, "federate {federate}: it {fault}"),
            Reason::Others => f.write_str("the other federates, of which the RTI says which are missing"),
            Reason::Grant(tag) => write!(f, "the RTI to grant {}: others may still send something", at(tag)),
            Reason::Input(tag, name) => write!(f, "what comes over {name} at {}", at(tag)),
            Reason::Room(tag, None) => write!(f, "the RTI to take what is sent at {}", at(tag)),
            Reason::Room(tag, Some(federate)) => {
                write!(f, "federate {federate} to take what is sent at {}", at(tag))
            }
        }
    }
}

/// The wait that is going on.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    now: Option<Wait>,
}

#[derive(Clone, Copy, Debug)]
struct Wait {
    reason: Reason,
    since: Instant,
    /// When to say it; NEVER once it is said for good.
    due: Instant,
    pause: Interval,
}

impl Waiting {
    /// Notes what is waited for, and says it if that has lasted, while the federate runs for as long as `log_waits`.
    /// Gives when to look again. `local` is the time of a tag on the platform's clock, `start` the federation's start.
    ///
    /// A wait counts from when it is noted, but before the time of its tag a federate waits for that only.
    pub(super) fn note(
        &mut self,
        now: Instant,
        reason: Option<Reason>,
        log_waits: Option<Interval>,
        local: impl Fn(Tag) -> Option<Instant>,
        start: Instant,
    ) -> Deadline {
        let limit = |reason: Reason| if reason.is_before_start() { Some(START_REPORT) } else { log_waits };
        let Some((reason, limit)) = reason.and_then(|reason| Some((reason, limit(reason)?))) else {
            self.now = None;
            return Deadline::Never;
        };
        let since = match reason {
            Reason::Grant(tag) | Reason::Input(tag, _) => local(tag).map_or(now, |time| time.max(now)),
            _ => now,
        };
        let begun = self.now.filter(|wait| wait.reason.is(reason));
        let mut wait = begun.unwrap_or(Wait { reason, since, due: since + limit, pause: limit });
        wait.reason = reason;
        if wait.due != Instant::NEVER && wait.due <= now {
            let lasts = now.since(wait.since).as_nanos() / 1_000_000;
            if reason.is_before_start() {
                log::info!("waiting for {}, for {lasts} ms", Words(reason, start));
                wait.pause = Interval(wait.pause.as_nanos().saturating_mul(2)).min(START_REPORT_PAUSE_MAX);
                wait.due = now + wait.pause;
            } else {
                log::warn!("waiting for {}, for {lasts} ms", Words(reason, start));
                wait.due = Instant::NEVER;
            }
        }
        self.now = Some(wait);
        if wait.due == Instant::NEVER { Deadline::Never } else { Deadline::At(wait.due) }
    }
}

/// What this federate waits for, if it is not just the time: after `advance`, with `peer`, the federate that is to take
/// what has no room.
pub(super) fn reason(execution: &Execution<'_, '_>, advance: Advance, peer: Option<u16>) -> Option<Reason> {
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

    const fn s(seconds: i64) -> Instant {
        Instant(seconds * 1_000_000_000)
    }

    fn note(waiting: &mut Waiting, now: i64, reason: Option<Reason>, log_waits: Option<i64>) -> Deadline {
        let log_waits = log_waits.map(Interval::from_secs);
        waiting.note(s(now), reason, log_waits, |tag| Some(tag.time), s(0))
    }

    #[test]
    fn before_the_start_a_wait_is_said_ever_more_rarely_and_another_one_counts_anew() {
        let mut waiting = Waiting::default();
        let mut now = 0;
        for expected in [5, 15, 35, 75, 135, 195] {
            assert_eq!(note(&mut waiting, now, Some(Reason::Rti), None), Deadline::At(s(expected)));
            now = expected;
        }
        assert_eq!(note(&mut waiting, 200, Some(Reason::Others), None), Deadline::At(s(205)));
        // What has gone wrong with a federate does not make another wait of it.
        assert_eq!(note(&mut waiting, 201, Some(Reason::Peer(1, None)), None), Deadline::At(s(206)));
        let again = Some(Reason::Peer(1, Some(PeerFault::Unanswered)));
        assert_eq!(note(&mut waiting, 202, again, None), Deadline::At(s(206)));
    }

    #[test]
    fn a_running_federate_says_a_wait_once_and_only_where_that_is_asked_for() {
        let mut waiting = Waiting::default();
        let grant = Some(Reason::Grant(Tag::at(s(10))));
        assert_eq!(note(&mut waiting, 1, grant, None), Deadline::Never);
        // Before the time of its tag it waits for that.
        assert_eq!(note(&mut waiting, 1, grant, Some(2)), Deadline::At(s(12)));
        assert_eq!(note(&mut waiting, 12, grant, Some(2)), Deadline::Never);
        assert_eq!(note(&mut waiting, 13, None, Some(2)), Deadline::Never);
        assert_eq!(note(&mut waiting, 14, grant, Some(2)), Deadline::At(s(16)));
    }
}
