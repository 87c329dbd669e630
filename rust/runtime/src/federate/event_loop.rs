// SPDX-License-Identifier: Apache-2.0
//! The order of the steps of a federate's event loop, and its end.

use core::fmt;
use lf_coordination::Deadline;
use lf_coordination::auth::Nonce;
use lf_coordination::federate::{All, Awaited, Config, Disconnected, Event, Federate, Needs, Phase};
use lf_derive::outlined;
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Engine, Program};

use super::clock_sync::{ClockSyncPort, set_correction};
use super::deadlock::Deadlock;
use super::direct::Direct;
use super::execution::{Advance, Execution, Failed};
use super::from_rti::FromRti;
use super::join::Join;
use super::memory::Buffers;
use super::output::Output;
use super::peers::Peers;
use super::reason::Reason;
use super::session::Session;
use super::waiting::{Waiting, reason};
use crate::description::Federation;
use crate::error::RunError;
use crate::platform::Platform;
use crate::trace::{Event as Traced, Recording, Role, Waits, waits};
use crate::turn::Turn;

/// The number of tags to run before the socket is read again, when physical time is ahead of logical time. One write
/// takes as long as many short tags, and can send the messages of all of them.
const TAGS_PER_TURN: u32 = 64;
/// The time for which a federate that has failed tries to send FAILED to the RTI, and any federate tries to send the
/// rest to its peers.
const FINAL_SEND_TIME_OUT: Interval = Interval::from_secs(1);
/// The time for which a federate that has resigned waits until the RTI has read everything. The RTI may read slowly,
/// because a receiver is slow. If the connection was closed meanwhile, the RTI's answer would reset it, and the rest
/// would be lost.
const RESIGN_TIME_OUT: Interval = Interval::from_secs(60);
/// The time for which a federate at its last tag reads what others send it too late, to log it, with decentralized
/// coordination. They come to the same tag, so their connections end soon; only one that is cut off does not end.
const DRAIN_TIME_OUT: Interval = Interval::from_secs(60);

/// The event loop of a federate. Call [`FederateLoop::turn`] and [`FederateLoop::wait`] alternately to drive it.
pub struct FederateLoop<'a, 's, P, N: Needs = All> {
    platform: &'a mut P,
    federation: &'a Federation,
    execution: Execution<'a, 's, N>,
    session: Session<'a, 's>,
    direct: Direct<'a, 's, N>,
    clock_sync: ClockSyncPort,
    waiting: Waiting,
    deadlock: Deadlock,
    stage: Stage,
    recording: Recording<'a>,
}

/// The stage of a federate between its first connection and its end.
#[derive(Debug)]
enum Stage {
    /// It takes part in the federation.
    Taking,
    /// It sends its final messages, from this time on and for a limited time.
    Leaving(Instant),
    /// It has ended.
    Ended,
}

impl<P, N: Needs> fmt::Debug for FederateLoop<'_, '_, P, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FederateLoop").field("stage", &self.stage).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform, N: Needs> FederateLoop<'a, 's, P, N> {
    /// Returns a federate before its first connection. `known` is memory, one tag for each of [`Federation::awaited`].
    ///
    /// # Errors
    /// [`RunError::Config`] and [`RunError::BufferTooSmall`] when it can never work.
    pub fn new(
        platform: &'a mut P,
        program: &'a mut dyn Program,
        engine: Engine<'s>,
        federation: &'a Federation,
        join: &Join<'a>,
        buffers: Buffers<'s>,
        known: &'s mut [Tag],
    ) -> Result<Self, RunError> {
        if N::BUFFER_CHECK {
            buffers.check(engine.tables(), federation, join.federation_id)?;
        }
        let peers = Peers::new(buffers.outbound, buffers.inbound, federation, join.federation_id);
        let mut direct = Direct::new(peers, federation.id);
        let listening = direct.peers.listen(platform).map_err(RunError::Listen)?;
        let (clock_sync, udp_port) = ClockSyncPort::open(platform, federation.clock_sync).map_err(RunError::Bind)?;
        let config = Config {
            authentication: federation.authentication,
            coordination: federation.coordination,
            upstream: federation.upstream,
            downstream: federation.downstream,
            clock_sync: federation.clock_sync,
            udp_port,
            rti: Some(join.rti.ip),
            test_offset: federation.test_offset,
            physical_delay: federation.physical_delay,
            listening,
            peers: federation.peers_out,
            transients: federation.transients,
            advance_interval: federation.advance_interval,
            window: federation.window,
            ..Config::with_needs(federation.id.into(), join.federation_id)
        };
        let machine = Federate::new(config)?;
        if federation.test_offset != Interval::ZERO {
            platform.set_correction(machine.clock());
        }
        let (needed, found) = (federation.awaited.len(), known.len());
        let awaited = Awaited::new(federation.awaited, known).ok_or(RunError::KnownTooShort { needed, found })?;
        let execution = Execution::new(engine, program, machine, awaited, !federation.upstream.is_empty());
        #[cfg(feature = "transients")]
        let execution = execution.prepared();
        Ok(Self {
            execution,
            session: Session::new(platform.now(), join, buffers.rti),
            platform,
            federation,
            direct,
            clock_sync,
            waiting: Waiting::NONE,
            deadlock: Deadlock::default(),
            stage: Stage::Taking,
            recording: Recording::OFF,
        })
    }

    /// Tells what happens from now on.
    pub fn record<'r: 'a>(&mut self, recording: Recording<'r>) {
        self.recording = recording.for_less();
        let (role, tables) = (Role::Federate(self.federation.id), self.execution.engine.tables());
        self.recording.begin(self.platform, role, Some(tables));
        if self.recording.is_on() {
            let now = self.platform.now();
            self.recording.note_at(now, Traced::Clock(self.execution.physical(now)));
        }
        #[cfg(feature = "traces")]
        self.execution.engine.record_steps(self.recording.is_on());
    }

    /// Makes the same as [`FederateLoop::new`], in memory that need not be on a stack. It is not inlined, so that its
    /// own stack frame is gone before the event loop begins.
    ///
    /// # Errors
    /// Those of [`FederateLoop::new`].
    #[expect(clippy::too_many_arguments, reason = "compilers see constants among them, but not in structures")]
    #[inline(never)]
    pub fn new_in<'p>(
        place: &'p mut Option<Self>,
        platform: &'a mut P,
        program: &'a mut dyn Program,
        engine: Engine<'s>,
        federation: &'a Federation,
        join: &Join<'a>,
        buffers: Buffers<'s>,
        known: &'s mut [Tag],
    ) -> Result<&'p mut Self, RunError> {
        Self::new(platform, program, engine, federation, join, buffers, known).map(|federate| place.insert(federate))
    }

    /// Runs the federate to its end.
    ///
    /// # Errors
    /// The reason why it ended early. The RTI has received FAILED, if that was possible.
    pub fn run(&mut self) -> Result<(), RunError> {
        loop {
            match self.turn() {
                Turn::Wait(until) => self.wait(until),
                Turn::Ended(result) => return result,
            }
        }
    }

    /// Does everything that can be done now: reads once, runs a bounded number of tags, writes once.
    ///
    /// After the end each call returns the same result again. If it is an error, the RTI has received FAILED, if that
    /// was possible.
    #[outlined]
    pub fn turn(&mut self) -> Turn<Result<(), RunError>> {
        if let Stage::Taking = self.stage {
            match self.take_part() {
                Ok(Some(advance)) => return Turn::Wait(self.prepare_wait(advance)),
                Ok(None) => {}
                Err(Failed) => self.execution.machine.fail(),
            }
            self.clock_sync.end(self.platform, &self.execution.machine);
            self.direct.peers.recheck();
            self.stage = Stage::Leaving(self.platform.now());
        }
        if let Stage::Leaving(since) = self.stage {
            if let Some(until) = self.leave(since, self.execution.failure.is_none()) {
                self.recording.note(self.platform, Traced::WaitBegins(Waits::End));
                return Turn::Wait(until);
            }
            self.direct.report_losses(&self.execution);
            self.recording.note(self.platform, Traced::Ends(self.execution.failure.is_some()));
            self.stage = Stage::Ended;
        }
        Turn::Ended(self.execution.failure.map_or(Ok(()), Err))
    }

    /// Waits until there may be something to do: a socket is ready, another thread has something for the program, or
    /// the deadline of the last [`FederateLoop::turn`] has come.
    #[outlined]
    pub fn wait(&mut self, until: Deadline) {
        let (session, peers, port) = (&mut self.session, &mut self.direct.peers, &mut self.clock_sync.port);
        self.platform.expect(self.execution.machine.next_arrival());
        self.platform.wait(until, &mut |socket, interest| {
            port.handle_ready(socket);
            session.handle_ready(socket, interest);
            peers.handle_ready(socket, interest);
        });
        if self.recording.is_on() && until != Deadline::Now {
            self.recording.note(self.platform, Traced::WaitEnds);
        }
    }

    /// Returns the number of messages of other federates that have come too late, with decentralized coordination.
    /// Those that were not handled are logged now and then.
    pub fn late_messages(&self) -> u64 {
        self.direct.late_messages()
    }

    /// Returns the minimum number of messages that have not reached their receivers, which had left before their last
    /// tag, with decentralized coordination. Each such receiver is logged.
    pub fn lost_messages(&self) -> u64 {
        if self.execution.is_decentralized() { self.direct.lost_messages() } else { 0 }
    }

    /// Does one turn of a federate that takes part in the federation. Returns `None` when it has resigned.
    #[outlined]
    fn take_part(&mut self) -> Result<Option<Advance>, Failed> {
        self.clock_sync.synchronize(self.platform, &mut self.recording, &mut self.execution.machine);
        if self.platform.interrupted() && !self.leaves_when_interrupted() {
            return Err(self.execution.fail(RunError::Interrupted));
        }
        let made = self.session.establish(self.platform);
        if made.map_err(|Failed| self.execution.fail(self.session.unreachable()))? {
            let mut nonce = Nonce::default();
            if N::AUTHENTICATION && self.federation.authentication.is_some() {
                let filled = self.platform.random(&mut nonce);
                filled.map_err(|error| self.execution.fail(error.into()))?;
            }
            let now = self.platform.now();
            if P::NAMES {
                self.execution.machine.set_rti(self.session.rti::<P>());
            }
            self.execution.machine.handle_connected(now, nonce);
        }
        let now = self.receive()?;
        self.handle_timeout(now)?;
        self.direct.meet(self.platform, &mut self.execution)?;
        self.direct.receive(self.platform, &mut self.recording, &mut self.execution)?;
        let advance = self.advance(now)?;
        #[cfg(feature = "transients")]
        self.send_outside_of_tags();
        self.direct.send_ends(self.platform, &mut self.recording, &self.execution);
        self.transmit();
        self.direct.peers.flush(self.platform);
        let (receiver, direct) = (&mut self.session.receiver, &mut self.direct);
        if let Some(error) = self.deadlock.find(self.platform, advance, receiver, direct, &self.execution) {
            return Err(self.execution.fail(error));
        }
        let has_ended = self.execution.phase() == Phase::Ended && self.session.output().is_empty();
        Ok((!has_ended).then_some(advance))
    }

    /// Reads what the RTI has sent and handles it, as far as there is room for it. Returns the time after the read.
    #[outlined]
    fn receive(&mut self) -> Result<Instant, Failed> {
        let has_ended = self.session.fill(self.platform);
        let now = self.platform.now();
        let (mut found, mut refused) = (None, false);
        #[cfg(feature = "transients")]
        let mut peer = None;
        while !refused {
            let mut policy = FromRti {
                platform: &mut *self.platform,
                recording: self.recording.reborrow(),
                execution: &mut self.execution,
                found: &mut found,
                #[cfg(feature = "transients")]
                peer: &mut peer,
                refused: &mut refused,
                now,
            };
            match self.session.receiver.next(&mut policy)? {
                // The accuracy of clock synchronization depends on a prompt answer.
                Some(true) if self.execution.phase() < Phase::Running => self.transmit(),
                Some(_) => {}
                None => break,
            }
            #[cfg(feature = "transients")]
            if let Some((federate, is_here)) = peer.take() {
                self.direct.peers.expect(self.platform, federate, is_here);
            }
        }
        if let Some((federate, address)) = found {
            self.direct.peers.connect(self.platform, federate, address);
        }
        if refused {
            self.session.ask_again(self.platform);
        } else if has_ended {
            // Held messages have no effect any more: nothing can be granted.
            let disconnected = self.execution.machine.handle_disconnected();
            match disconnected.map_err(|error| self.execution.fail(error.into()))? {
                Disconnected::ConnectAgain => {
                    let reason = self.session.end_reason(self.platform);
                    self.session.begin_anew(self.platform, reason);
                }
                Disconnected::Ended => self.session.close(self.platform),
            }
        }
        Ok(now)
    }

    fn handle_timeout(&mut self, now: Instant) -> Result<(), Failed> {
        let machine = &mut self.execution.machine;
        if !machine.poll_timeout().is_due(now) {
            return Ok(());
        }
        match machine.handle_timeout(now) {
            Ok(Event::ClockCorrected(estimate)) => {
                log::debug!("initial clock synchronization, with fewer exchanges than expected: {estimate}");
                set_correction(self.platform, &mut self.recording, machine.clock());
                Ok(())
            }
            Ok(_) => Ok(()),
            Err(error) => Err(self.execution.fail(error.into())),
        }
    }

    /// Runs the tags that are due and granted, in a turn that began at `now`.
    #[outlined]
    fn advance(&mut self, now: Instant) -> Result<Advance, Failed> {
        if self.execution.phase() != Phase::Running {
            return Ok(Advance::Until(Deadline::Never));
        }
        #[cfg(feature = "transients")]
        if self.execution.hands_over() {
            return Ok(Advance::OutputFull);
        }
        for tag in 1..=TAGS_PER_TURN {
            let until = (tag > 1).then_some(now + P::TURN_TIME);
            if !self.execution.engine.is_in_tag()
                && let Some(advance) = self.begin_next(until)?
            {
                return Ok(advance);
            }
            let (max_level, limit) = self.level_limit()?;
            let mut output = Output {
                platform: &mut *self.platform,
                recording: self.recording.reborrow(),
                session: &mut self.session,
                peers: &mut self.direct.peers,
                at_once: until.is_none(),
            };
            if let Some(advance) = self.execution.run(&mut output, max_level, limit)? {
                return Ok(advance);
            }
        }
        Ok(Advance::Until(Deadline::Now))
    }

    /// Sends what a transient federate has to send before its first tag and after the last one.
    #[cfg(feature = "transients")]
    fn send_outside_of_tags(&mut self) {
        if self.execution.passed.is_some() || self.execution.hands_over() {
            let recording = self.recording.reborrow();
            let (session, peers) = (&mut self.session, &mut self.direct.peers);
            let mut output = Output { platform: &mut *self.platform, recording, session, peers, at_once: true };
            if self.execution.hands_over() {
                self.execution.hand_over(&mut output, self.federation.id);
            } else {
                self.execution.pass(&mut output);
            }
        }
    }

    /// Begins the next tag, if it may begin before `until`, the end of the turn; otherwise returns what it waits for.
    #[outlined]
    fn begin_next(&mut self, until: Option<Instant>) -> Result<Option<Advance>, Failed> {
        // The clock comes first: then everything that was scheduled before this time is collected.
        let (now, outside) = (self.platform.now(), self.platform.outside());
        if until.is_some_and(|until| now >= until) {
            return Ok(Some(Advance::Until(Deadline::Now)));
        }
        self.execution.collect(outside, self.direct.peers.can_receive());
        let is_decentralized = self.execution.is_decentralized();
        if is_decentralized {
            self.direct.take_held(self.platform, &mut self.recording, &mut self.execution)?;
        }
        let held = self.session.receiver.held.earliest;
        let next = if is_decentralized { self.execution.engine.next_tag() } else { self.execution.announce(now, held) };
        let Some(tag) = next else {
            return Ok(Some(self.execution.idle(now, held, outside, self.direct.peers.can_receive())));
        };
        let waits = if is_decentralized {
            self.waits_for_others(now, tag)?
        } else {
            // Each tag has a NET, even when many tags go into one write: each lets the RTI grant the tag before to
            // others, which may need that before they can accept the messages of this one.
            self.session.collect(self.platform, &mut self.recording, &mut self.execution.machine);
            self.execution.grant(now, tag, held)
        };
        if waits.is_none() {
            self.execution.begin(tag)?;
            self.recording.note_tag(self.platform, &self.execution.engine, self.execution.program);
            if N::INPUTS {
                self.session.receiver.held.recheck();
            }
            self.direct.peers.recheck();
        }
        Ok(waits)
    }

    /// With decentralized coordination, returns what a tag waits for, unless everything before it is known or its wait
    /// is over. Before a wait counts as over, the federate reads everything that has come, so that no message is late
    /// that was there in time.
    fn waits_for_others(&mut self, now: Instant, tag: Tag) -> Result<Option<Advance>, Failed> {
        if !self.execution.machine.may_advance(tag) || self.direct.peers.awaits_rest_before(tag) {
            return Ok(Some(Advance::NotGranted));
        }
        let (due, is_known, waits) = self.execution.begin_time(now, tag);
        if waits.is_some() {
            return Ok(waits);
        }
        if !is_known && self.direct.sweep(self.platform, &mut self.recording, &mut self.execution)? {
            return Ok(Some(Advance::Until(Deadline::Now)));
        }
        self.recording.note(self.platform, Traced::Due(due));
        Ok(None)
    }

    /// Returns the level from which on reactions of the open tag have to wait, if any, and what they wait for.
    #[outlined]
    fn level_limit(&mut self) -> Result<(Option<u16>, Advance), Failed> {
        if !self.execution.is_decentralized() {
            return Ok((self.execution.max_level(), Advance::NotGranted));
        }
        self.direct.take_held(self.platform, &mut self.recording, &mut self.execution)?;
        loop {
            let now = self.platform.now();
            match self.execution.pause(now) {
                None => return Ok((None, Advance::NotGranted)),
                Some((level, Some(waits))) => return Ok((Some(level), waits)),
                Some((level, None))
                    if self.direct.sweep(self.platform, &mut self.recording, &mut self.execution)? =>
                {
                    return Ok((Some(level), Advance::Until(Deadline::Now)));
                }
                Some((_, None)) => self.execution.assume_absent(now),
            }
        }
    }

    /// Lets a transient federate that the RTI has accepted leave in order. Returns whether this federate is such a one.
    fn leaves_when_interrupted(&mut self) -> bool {
        let leaves = self.is_transient() && self.execution.phase() >= Phase::Synchronizing;
        #[cfg(feature = "transients")]
        if leaves {
            self.execution.stop_alone(self.platform.now());
        }
        leaves
    }

    /// Returns whether this federate comes and goes while the federation runs.
    fn is_transient(&self) -> bool {
        N::TRANSIENTS && self.federation.is_transient(self.federation.id)
    }

    fn transmit(&mut self) {
        self.session.transmit(self.platform, &mut self.recording, &mut self.execution.machine);
    }

    /// Sets what to wait for, and returns the deadline.
    #[outlined]
    fn prepare_wait(&mut self, advance: Advance) -> Deadline {
        let event = match advance {
            Advance::Until(deadline) => deadline,
            // What was full may be empty by now, and then no socket becomes writable.
            Advance::OutputFull if self.session.output().is_empty() && self.direct.peers.blocked().is_none() => {
                Deadline::Now
            }
            Advance::OutputFull => self.deadlock.poll_timeout(&self.direct.peers),
            Advance::NotGranted | Advance::Done => Deadline::Never,
        };
        let running = self.execution.phase() == Phase::Running;
        self.session.set_interest(self.platform);
        self.direct.peers.set_interest(self.platform, running);
        let sockets = self.session.poll_timeout().min(self.direct.peers.poll_timeout(running));
        // There is one search at a time, and its end is news by itself.
        #[cfg(feature = "transients")]
        let searches = running && !self.execution.machine.is_searching();
        #[cfg(feature = "transients")]
        let sockets = if searches { sockets.min(self.direct.peers.poll_search()) } else { sockets };
        let (now, reason) = (self.platform.now(), self.reason(advance));
        let (execution, start) = (&self.execution, self.execution.engine.start_time());
        let report = self.waiting.note(now, reason, self.log_waits(), |tag| execution.local(tag), start);
        let until = event.min(execution.machine.poll_timeout()).min(sockets).min(report);
        if self.recording.is_on() && until != Deadline::Now {
            let next = execution.tag_in_question().filter(|_| running);
            let input = next.and_then(|tag| execution.unknown_input(tag));
            let is_timed = matches!(advance, Advance::Until(Deadline::At(_)));
            self.recording.note(self.platform, Traced::WaitBegins(waits(reason, input, next, is_timed)));
        }
        until
    }

    /// Returns the time after which the running federate logs what it waits for, if at all.
    fn log_waits(&self) -> Option<Interval> {
        if N::WAITS { self.federation.log_waits } else { None }
    }

    /// Returns what this federate waits for, if it is not just the time.
    fn reason(&mut self, advance: Advance) -> Option<Reason> {
        match self.execution.phase() {
            Phase::Running => {
                if !self.recording.is_on() {
                    self.log_waits()?;
                }
                reason(&self.execution, advance, self.direct.peers.blocked().map(|(federate, _)| federate))
            }
            Phase::Disconnected => Some(self.session.reason(self.session.missing())),
            Phase::Meeting => {
                let (federate, fault) = self.direct.peers.meets(self.execution.machine.next_peer_index())?;
                Some(Reason::Peer(federate, fault))
            }
            Phase::Starting => Some(Reason::Others),
            Phase::Resigning | Phase::Ended => None,
            phase @ (Phase::Authenticating | Phase::Introducing) => Some(self.session.reason(Reason::Answer(phase))),
            phase => Some(Reason::Answer(phase)),
        }
    }

    /// Sends the final messages, since this time. Returns the deadline of the wait; `None` when nothing is left to do,
    /// or when the time is over.
    #[outlined]
    fn leave(&mut self, since: Instant, is_ok: bool) -> Option<Deadline> {
        let resigned = is_ok && (self.is_transient() || !self.platform.interrupted());
        let until = since + if resigned { RESIGN_TIME_OUT } else { FINAL_SEND_TIME_OUT };
        // Messages to a transient federate that leaves are dropped.
        let hears = resigned && self.execution.is_decentralized() && !self.is_transient();
        let direct_until = since + if hears { DRAIN_TIME_OUT } else { FINAL_SEND_TIME_OUT };
        let direct =
            self.direct.leave(self.platform, &mut self.recording, &mut self.execution, (resigned, hears), direct_until);
        let linked = self.platform.now() < until
            && self.session.leave(self.platform, &mut self.recording, &mut self.execution.machine);
        if !linked {
            self.session.close(self.platform);
        }
        if !linked && !direct {
            return None;
        }
        self.direct.peers.set_interest(self.platform, direct && resigned);
        Some(Deadline::At(if direct { direct_until } else { until }))
    }
}
