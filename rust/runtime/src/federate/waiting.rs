// SPDX-License-Identifier: Apache-2.0
//! What a federate waits for, said when that lasts.
//!
//! Before the start it is always said, after a while and then ever more rarely; while the federate runs, if the program
//! asks for it with `log-waits`.

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::federate::Phase;
use lf_model::time::{EventTag, Instant, Interval, Tag};

use super::FederateLoop;
use super::tags::Advance;
use crate::error::PeerFault;
use crate::platform::Platform;

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
    /// Notes what is waited for, and from when on, and says it if that has lasted. Gives when to look again.
    fn note(
        &mut self,
        now: Instant,
        reason: Option<(Reason, Instant)>,
        limit: impl FnOnce(Reason) -> Option<Interval>,
        start: Instant,
    ) -> Deadline {
        let Some((reason, since, limit)) = reason.and_then(|(reason, since)| Some((reason, since, limit(reason)?)))
        else {
            self.now = None;
            return Deadline::Never;
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

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Says what this federate waits for, if that has lasted. Gives when to look again.
    pub(super) fn report_wait(&mut self, advance: Advance) -> Deadline {
        let now = self.platform.now();
        let reason = self.reason(advance).map(|reason| (reason, self.begins(now, reason)));
        let log_waits = self.federation.log_waits;
        let limit = |reason: Reason| if reason.is_before_start() { Some(START_REPORT) } else { log_waits };
        self.waiting.note(now, reason, limit, self.engine.start_time())
    }

    /// What this federate waits for, if it is not just the time.
    fn reason(&mut self, advance: Advance) -> Option<Reason> {
        match self.machine.phase() {
            Phase::Running => {}
            Phase::Disconnected => return Some(Reason::Rti),
            Phase::Meeting => {
                let index = self.meeting.or(self.machine.next_peer_index())?;
                let federate = *self.federation.peers_out.get(index)?;
                return Some(Reason::Peer(federate, self.peers.trouble(index)));
            }
            Phase::Starting => return Some(Reason::Others),
            Phase::Resigning | Phase::Ended => return None,
            phase => return Some(Reason::Answer(phase)),
        }
        self.federation.log_waits?;
        let tag = if self.engine.is_in_tag() { self.engine.current_tag() } else { self.engine.next_tag()? };
        match advance {
            Advance::OutputFull => {
                let peer = self.peers.stuck().and_then(|(index, _)| self.federation.peers_out.get(index).copied());
                Some(Reason::Room(tag, peer))
            }
            Advance::NotGranted => match self.unknown_input(tag) {
                Some(name) => Some(Reason::Input(tag, name)),
                None if self.is_decentralized() => None,
                None => (!self.machine.may_advance(tag)).then_some(Reason::Grant(tag)),
            },
            // With decentralized coordination a wait has an end.
            Advance::Until(_) => self.unknown_input(tag).map(|name| Reason::Input(tag, name)),
            Advance::Done => None,
        }
    }

    /// From when on a wait counts, when it is seen now: before the time of its tag a federate waits for that only.
    fn begins(&self, now: Instant, reason: Reason) -> Instant {
        match reason {
            Reason::Grant(tag) | Reason::Input(tag, _) if !self.engine.settings().fast => {
                now.max(self.machine.clock().local(tag.time))
            }
            _ => now,
        }
    }

    /// The first input of which it is not known what comes at a tag that waits for that.
    fn unknown_input(&self, tag: Tag) -> Option<&'static str> {
        let waits = self.is_decentralized() || self.engine.is_in_tag();
        // A tag begins when all is known that comes before it.
        let needed = if self.engine.is_in_tag() { tag } else { tag.before() };
        let port = self.awaited.first_unknown(needed).filter(|_| waits)?;
        self.engine.tables().inputs.get(usize::from(port)).map(|input| input.name)
    }
}
