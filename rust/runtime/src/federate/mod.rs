// SPDX-License-Identifier: Apache-2.0
//! The event loop of a federate.

mod clock_sync;
mod direct;
mod input;
mod link;
mod output;
mod peers;
mod stuck;
mod tags;
mod visitors;
mod waiting;
mod waits;

use core::fmt;
use core::net::SocketAddrV4;

use lf_coordination::Deadline;
use lf_coordination::auth::Nonce;
use lf_coordination::federate::{Awaited, Config, Coordination, Event, Federate, Phase};
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Engine, Program, Tables};
use lf_wire::{Limits, Message, NeighborStructure};

use crate::connection::Buffers;
use crate::description::{CONTROL_BYTES, Federation, PEERS, TAGGED_MESSAGE_HEADER_BYTES};
use crate::error::RunError;
use crate::platform::Platform;
use crate::turn::Turn;
use clock_sync::Port;
use direct::Late;
use input::Held;
use link::{Arrival, Link};
pub(crate) use peers::Peers;
pub use peers::{Inbound, Outbound};
use tags::Advance;
use waiting::Waiting;

/// How long a federate that has failed tries to tell the RTI, and any federate tries to tell its peers.
const LAST_WORDS: Interval = Interval::from_secs(1);
/// How long a federate that has resigned waits until the RTI has read all of it. The RTI may read slowly, because a
/// receiver is slow, and what it answers would reset a connection that is closed meanwhile: the rest would be lost.
const RESIGNATION: Interval = Interval::from_secs(60);

/// How long a federate that has come to its last tag reads what others send it too late, to say so, with decentralized
/// coordination. They come to the same tag, so their connections end soon; only one that is cut off does not end.
const HEARING_OUT: Interval = Interval::from_secs(60);

/// What a federate is told when it is started, and not when it is built.
#[derive(Clone, Copy, Debug)]
pub struct Join<'a> {
    /// The federation to join.
    pub federation_id: &'a [u8],
    /// Where its RTI listens.
    pub rti: SocketAddrV4,
}

/// Runs a federate from its first connection to its end. `known` is memory, one tag for each of
/// [`Federation::awaited`].
///
/// # Errors
/// Why it ended early. The RTI has been told, where that was possible.
pub fn run_federate<'s, P: Platform>(
    platform: &mut P,
    program: &mut dyn Program,
    engine: Engine<'s>,
    federation: &Federation,
    join: &Join<'_>,
    buffers: Buffers<'s>,
    known: &'s mut [Tag],
) -> Result<(), RunError> {
    let mut federate = FederateLoop::new(platform, program, engine, federation, join, buffers, known);
    // It is large, and stays where it is.
    let federate = federate.as_mut().map_err(|error| *error)?;
    loop {
        match federate.turn() {
            Turn::Wait(until) => federate.wait(until),
            Turn::Ended(result) => return result,
        }
    }
}

/// Whether messages go past the RTI; never where there are no connections past it.
fn is_decentralized(coordination: Coordination) -> bool {
    PEERS && coordination == Coordination::Decentralized
}

/// Whether the buffers can hold what this federate sends and receives; otherwise it would wait for room for ever.
fn check_buffers(
    buffers: &Buffers<'_>,
    tables: &Tables,
    federation: &Federation,
    join: &Join<'_>,
) -> Result<(), RunError> {
    let message = |payload: usize| payload.saturating_add(TAGGED_MESSAGE_HEADER_BYTES);
    let all_direct = federation.coordination == Coordination::Decentralized;
    let longest = |direct: bool| {
        let is_here = |physical: bool| (physical || all_direct) == direct;
        let inputs = tables.inputs.iter().filter(|input| is_here(input.physical)).map(|input| input.max_len);
        let outputs = tables.outputs.iter().filter(|output| is_here(output.physical)).map(|output| output.max_len);
        (inputs.map(message).max().unwrap_or(0), outputs.map(message).max().unwrap_or(0))
    };
    let ((longest_input, longest_output), direct) = (longest(false), longest(true));
    let ids = Message::FedIds { federate: federation.id, federation_id: join.federation_id };
    let neighbors = NeighborStructure::new(federation.upstream, federation.downstream);
    let handshake = ids.encoded_len().max(Message::NeighborStructure(neighbors).encoded_len());
    let needs = [
        ("receive", longest_input.max(CONTROL_BYTES), buffers.input.capacity()),
        ("send", longest_output.saturating_add(CONTROL_BYTES).max(handshake), buffers.output.capacity()),
    ];
    let introduction = CONTROL_BYTES + join.federation_id.len();
    let inbound =
        buffers.peers.inbound.iter().map(|one| ("peer receive", direct.0.max(introduction), one.input.capacity()));
    let outbound =
        buffers.peers.outbound.iter().map(|one| ("peer send", direct.1.max(introduction), one.output.capacity()));
    let places = [
        ("table of peers that send", federation.peers_in.len(), buffers.peers.inbound.len()),
        ("table of peers that receive", federation.peers_out.len(), buffers.peers.outbound.len()),
    ];
    match needs.into_iter().chain(inbound).chain(outbound).chain(places).find(|(_, needed, found)| found < needed) {
        Some((buffer, needed, found)) => Err(RunError::BufferTooSmall { buffer, needed, found }),
        None => Ok(()),
    }
}

/// The event loop of a federate, turn by turn: who calls [`FederateLoop::turn`] and [`FederateLoop::wait`] in
/// alternation runs the federate, and may do something else in between.
pub struct FederateLoop<'a, 's, P> {
    platform: &'a mut P,
    program: &'a mut dyn Program,
    engine: Engine<'s>,
    machine: Federate<'a>,
    /// What is known of inputs for which reactions wait.
    awaited: Awaited<'s>,
    link: Link<'s>,
    limits: Limits,
    /// The messages in the input buffer that wait for room in their inputs' queues.
    held: Held,
    /// Since when all of the input buffer has been held while this federate waits for room for its output.
    choked_since: Option<Instant>,
    /// The connections with other federates.
    peers: Peers<'s>,
    /// For clock synchronization.
    port: Port,
    /// Which of them is being made.
    meeting: Option<usize>,
    federation: &'a Federation,
    federation_id: &'a [u8],
    /// The RTI has been told that nothing more is sent from here, though a last tag is still to be run.
    silent: bool,
    /// With decentralized coordination.
    late: Late,
    waiting: Waiting,
    stage: Stage,
}

/// How far a federate is from its first connection to its end.
#[derive(Debug)]
enum Stage {
    /// It takes part in the federation.
    Taking,
    /// It says its last words, from this time on and for a limited time; then it ends with this result.
    Leaving(Instant, Result<(), RunError>),
    /// It has ended.
    Ended(Result<(), RunError>),
}

impl<P> fmt::Debug for FederateLoop<'_, '_, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FederateLoop").field("stage", &self.stage).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform> FederateLoop<'a, 's, P> {
    /// A federate that is to make its first connection. `known` is memory, one tag for each of
    /// [`Federation::awaited`].
    ///
    /// # Errors
    /// [`RunError::Config`] and [`RunError::BufferTooSmall`] when it can never work.
    pub fn new(
        platform: &'a mut P,
        program: &'a mut dyn Program,
        engine: Engine<'s>,
        federation: &'a Federation,
        join: &Join<'a>,
        mut buffers: Buffers<'s>,
        known: &'s mut [Tag],
    ) -> Result<Self, RunError> {
        check_buffers(&buffers, engine.tables(), federation, join)?;
        let mut peers = core::mem::take(&mut buffers.peers);
        let listening = peers.listen(platform).map_err(RunError::Listen)?;
        let (port, udp_port) = Port::open(platform, federation.clock_sync)?;
        let config = Config {
            authentication: federation.authentication,
            coordination: federation.coordination,
            upstream: federation.upstream,
            downstream: federation.downstream,
            clock_sync: federation.clock_sync,
            udp_port,
            rti: Some(*join.rti.ip()),
            test_offset: federation.test_offset,
            physical_delay: federation.physical_delay,
            listening,
            peers: federation.peers_out,
            advance_interval: federation.advance_interval,
            ..Config::new(federation.id.into(), join.federation_id)
        };
        let machine = Federate::new(config)?;
        if federation.test_offset != Interval::ZERO {
            platform.set_correction(machine.clock());
        }
        let (needed, found) = (federation.awaited.len(), known.len());
        let awaited = Awaited::new(federation.awaited, known).ok_or(RunError::KnownTooShort { needed, found })?;
        let limits = Limits {
            // What the buffer holds is the limit; an input's own length is checked when its value is decoded.
            payload_bytes_max: buffers.input.capacity(),
            federation_id_bytes_max: 0,
            neighbors_max: 0,
        };
        let link = Link::new(platform.now(), join.rti, buffers);
        log::debug!("connecting to the RTI at {}", join.rti);
        Ok(Self {
            platform,
            program,
            engine,
            machine,
            awaited,
            link,
            limits,
            held: Held::NONE,
            choked_since: None,
            peers,
            port,
            meeting: None,
            federation,
            federation_id: join.federation_id,
            silent: false,
            late: Late::default(),
            waiting: Waiting::default(),
            stage: Stage::Taking,
        })
    }

    /// Does what can be done now: reads once, runs a bounded number of tags, writes once.
    ///
    /// After the end each call gives the same result again. If it is an error, the RTI has been told, where that was
    /// possible.
    pub fn turn(&mut self) -> Turn<Result<(), RunError>> {
        if let Stage::Taking = self.stage {
            let result = match self.take_part() {
                Ok(Some(advance)) => return Turn::Wait(self.prepare_wait(advance)),
                Ok(None) => Ok(()),
                Err(error) => {
                    self.machine.fail();
                    Err(error)
                }
            };
            self.end_synchronization();
            self.peers.look_again();
            self.stage = Stage::Leaving(self.platform.now(), result);
        }
        if let Stage::Leaving(since, result) = &self.stage {
            let (since, result) = (*since, *result);
            let resigned = result.is_ok() && !self.platform.interrupted();
            let until = since + if resigned { RESIGNATION } else { LAST_WORDS };
            let direct_until = since + if resigned && self.is_decentralized() { HEARING_OUT } else { LAST_WORDS };
            let direct = self.take_leave_of_peers(resigned, direct_until);
            let linked = self.take_leave(until);
            if !linked {
                self.link.close(self.platform);
            }
            if linked || direct {
                self.peers.set_interest(self.platform, direct && resigned);
                return Turn::Wait(Deadline::At(if direct { direct_until } else { until }));
            }
            self.report_losses();
            self.stage = Stage::Ended(result);
        }
        match &self.stage {
            Stage::Ended(result) => Turn::Ended(*result),
            Stage::Taking | Stage::Leaving(..) => unreachable!("both stages were left above"),
        }
    }

    fn is_decentralized(&self) -> bool {
        is_decentralized(self.federation.coordination)
    }

    /// How many messages of other federates have come too late, with decentralized coordination. Those that were not
    /// handled were reported, now and then one.
    pub fn late_messages(&self) -> u64 {
        self.late.messages
    }

    /// How many messages are known not to have reached their receivers, which had left before their last tag, with
    /// decentralized coordination: at least. Each such receiver was reported.
    pub fn lost_messages(&self) -> u64 {
        if !self.is_decentralized() {
            return 0;
        }
        self.peers.outbound.iter().fold(0, |sum, outbound| sum.saturating_add(outbound.lost()))
    }

    /// Says how many messages have come too late, or nowhere.
    fn report_losses(&mut self) {
        if !self.is_decentralized() {
            return;
        }
        let Late { messages, unhandled, .. } = self.late;
        if unhandled > 0 {
            log::warn!(
                "{messages} late messages, {unhandled} of them not handled: wait longer with @maxwait or \
                 @absent_after, or give the reactions tardy handlers"
            );
        } else if messages > 0 {
            log::warn!("{messages} late messages");
        }
        for (to, outbound) in self.federation.peers_out.iter().zip(self.peers.outbound.iter()) {
            if outbound.lost() > 0 {
                log::warn!("at least {} messages to federate {to} did not reach it", outbound.lost());
            } else if outbound.has_left_early() {
                log::warn!("federate {to} left before this one: messages on their way to it may be lost");
            }
        }
    }

    /// Waits until there may be something to do: a socket is ready, another thread has something for the program, or
    /// the time has come that the last [`FederateLoop::turn`] gave.
    pub fn wait(&mut self, until: Deadline) {
        let (link, peers, port) = (&mut self.link, &mut self.peers, &mut self.port);
        self.platform.expect(self.machine.next_arrival());
        self.platform.wait(until, &mut |socket, interest| {
            port.handle_ready(socket);
            link.handle_ready(socket, interest);
            peers.handle_ready(socket, interest);
        });
    }

    /// One turn of a federate that takes part in the federation. `None` when it has resigned.
    fn take_part(&mut self) -> Result<Option<Advance>, RunError> {
        self.synchronize();
        if self.platform.interrupted() {
            return Err(RunError::Interrupted);
        }
        if self.link.establish(self.platform)? {
            let mut nonce = Nonce::default();
            if self.federation.authentication.is_some() {
                self.platform.random(&mut nonce)?;
            }
            let now = self.platform.now();
            self.machine.handle_connected(now, nonce);
        }
        self.receive()?;
        self.handle_timeout()?;
        self.meet_peers()?;
        self.receive_directly()?;
        let advance = self.advance()?;
        self.transmit();
        self.peers.flush(self.platform);
        self.check_stuck(advance)?;
        let has_ended = self.machine.phase() == Phase::Ended && self.link.buffers.output.is_empty();
        Ok((!has_ended).then_some(advance))
    }

    fn handle_timeout(&mut self) -> Result<(), RunError> {
        let now = self.platform.now();
        if self.machine.poll_timeout().is_due(now)
            && let Event::ClockCorrected(estimate) = self.machine.handle_timeout(now)?
        {
            log::debug!("initial clock synchronization, with fewer exchanges than expected: {estimate}");
            self.platform.set_correction(self.machine.clock());
        }
        Ok(())
    }

    /// Sends what the handshake has to say at once: answers to clock synchronization are as good as they are prompt.
    fn say_early(&mut self) {
        if self.machine.phase() < Phase::Running {
            self.transmit();
        }
    }

    /// Moves what the machine has to say into the output buffer, and writes it.
    fn transmit(&mut self) {
        if !self.link.is_open() {
            return;
        }
        loop {
            self.collect();
            if !self.link.flush(self.platform) {
                return;
            }
            let now = self.platform.now();
            self.machine.handle_written(now);
            if !self.machine.has_transmit() {
                return;
            }
        }
    }

    /// Moves what the machine has to say into the output buffer, behind the messages of the tags it speaks of.
    fn collect(&mut self) {
        while let Some(message) = self.machine.poll_transmit(self.link.buffers.output.room()) {
            // There is room: the machine was told how much, and gave a message that fits.
            let _ = self.link.buffers.output.push(&message);
        }
    }

    /// Says what to wait for, and gives until when.
    fn prepare_wait(&mut self, advance: Advance) -> Deadline {
        let event = match advance {
            _ if self.held.is_stale() => Deadline::Now,
            Advance::Until(deadline) => deadline,
            Advance::OutputFull => self.stuck_deadline(),
            Advance::NotGranted | Advance::Done => Deadline::Never,
        };
        let running = self.machine.phase() == Phase::Running;
        self.link.set_interest(self.platform);
        self.peers.set_interest(self.platform, running);
        let sockets = self.link.poll_timeout().min(self.peers.poll_timeout(running));
        let report = self.report_wait(advance);
        event.min(self.machine.poll_timeout()).min(sockets).min(report)
    }

    /// Sends what is still to be said (RESIGN or FAILED), closes our direction, and awaits the RTI's end. `false` when
    /// there is nothing more to wait for.
    ///
    /// A socket that is closed while something is unread resets the connection, and what was sent last may be lost. So
    /// the RTI's last words are read, but not for longer than [`LAST_WORDS`] after an error, and [`RESIGNATION`] after
    /// a resignation.
    fn take_leave(&mut self, until: Instant) -> bool {
        if !self.link.is_open() || self.platform.now() >= until {
            return false;
        }
        self.transmit();
        if self.link.buffers.output.is_empty() && !self.machine.has_transmit() {
            self.link.shut_down_writing(self.platform);
        }
        self.link.buffers.input.clear();
        if self.link.fill(self.platform) == Arrival::End {
            return false;
        }
        self.link.set_interest(self.platform);
        true
    }
}
