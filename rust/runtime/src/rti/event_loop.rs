// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI.

use core::fmt;

use lf_coordination::Deadline;
#[cfg(feature = "transients")]
use lf_coordination::FederateId;
use lf_coordination::auth::Nonce;
use lf_coordination::rti::{
    Config, ConnectionId, Outcome, Rti, RtiEvent, RtiStorage, SetupError, Status, Verdict, Waits,
};
use lf_derive::outlined;
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::Storage;

use super::connections::{Awaited, Inlet, Outgoing, State};
use super::table::{Outgoings, Table};
use crate::datagram::{DatagramPort, send};
use crate::listener::Listener;
use crate::log_event::{ConnectionEvent, report};
use crate::platform::{Platform, SocketId};
use crate::trace::{Event, RTI, Recording, Role, Waits as WaitsFor};
use crate::turn::Turn;
use log::Level;

/// The number of messages of one connection that are handled before the next connection: about as many as one read
/// brings. If one federate sends to many, the announcement behind its messages lets the RTI grant their tags, so both
/// go out with one write; writes take most of an RTI's time.
const MESSAGES_PER_TURN: u32 = 8192;

/// The parts of an RTI: the machine's memory, and as many inlets and outgoings as that has connections, whose buffers
/// are in slices or in [`Storage`] that grows.
pub struct RtiSetup<'s, B = &'s mut [u8]> {
    /// The configuration of the RTI.
    pub config: Config<'s>,
    /// The machine's memory.
    pub storage: RtiStorage<'s>,
    /// The receiving side of the connections.
    pub inlets: &'s mut [Inlet<B>],
    /// The sending side of the connections.
    pub outgoings: &'s mut [Outgoing<B>],
    /// A UDP port for clock synchronization, if the configuration asks for it; the loop closes it.
    pub datagrams: Option<SocketId>,
}

/// The event loop of the RTI. Call [`RtiLoop::turn`] and [`RtiLoop::wait`] alternately to drive it.
pub struct RtiLoop<'a, 's, P, N, B = &'s mut [u8]> {
    platform: &'a mut P,
    rti: Rti<'s>,
    table: Table<'a, B>,
    listener: Listener,
    /// For clock synchronization.
    port: DatagramPort,
    aborted: bool,
    /// The tag at which all stop, once it is known and held messages have been released.
    stop_tag: Option<Tag>,
    /// Whether each connection gets a nonce.
    authentication: bool,
    /// The time after which waiting messages are logged, and the time of the next check.
    log_waits: Option<(Interval, Instant)>,
    log: &'a mut N,
    recording: Recording<'a>,
}

impl<P, N, B> fmt::Debug for RtiLoop<'_, '_, P, N, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RtiLoop").field("aborted", &self.aborted).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform, N: FnMut(RtiEvent<'_>), B: Storage> RtiLoop<'a, 's, P, N, B> {
    /// Returns an RTI that accepts federates. `log` gets its log events.
    ///
    /// # Errors
    /// When configuration and storage do not fit together, or a buffer cannot hold the longest message. The listening
    /// socket is then closed.
    pub fn new(
        platform: &'a mut P,
        setup: RtiSetup<'s, B>,
        listener: SocketId,
        log: &'a mut N,
    ) -> Result<Self, SetupError>
    where
        's: 'a,
    {
        let RtiSetup { config, storage, inlets, outgoings, datagrams } = setup;
        let mut port = DatagramPort::new(platform, datagrams);
        let authentication = config.authentication.is_some();
        let log_waits = config.log_waits.map(|interval| (interval, platform.now()));
        let rti = Rti::new(config, storage).and_then(|rti| {
            let table = Table::new(inlets, outgoings, rti.message_bytes_max())?;
            Ok((rti, table))
        });
        let (rti, table) = match rti {
            Ok(both) => both,
            Err(error) => {
                platform.close(listener);
                port.close(platform);
                return Err(error);
            }
        };
        Ok(Self {
            platform,
            rti,
            table,
            listener: Listener::new(listener),
            port,
            aborted: false,
            stop_tag: None,
            authentication,
            log_waits,
            log,
            recording: Recording::OFF,
        })
    }

    /// Tells what happens from now on.
    pub fn record<'r: 'a>(&mut self, recording: Recording<'r>) {
        self.recording = recording.for_less();
        self.recording.begin(self.platform, Role::Rti, None);
    }

    /// Runs the RTI until all federates have left or the program is interrupted.
    pub fn run(&mut self) -> Outcome {
        loop {
            match self.turn() {
                Turn::Wait(until) => self.wait(until),
                Turn::Ended(outcome) => return outcome,
            }
        }
    }

    /// Tells a transient federate to leave: it stops alone, soon. Returns `false` if no such federate takes part.
    #[cfg(feature = "transients")]
    pub fn dismiss(&mut self, federate: FederateId) -> bool {
        self.drive(|rti, outlet| rti.dismiss(federate, outlet))
    }

    /// Does everything that can be done now. Bounded by the number of connections with something to do times
    /// [`MESSAGES_PER_TURN`].
    #[outlined]
    pub fn turn(&mut self) -> Turn<Outcome> {
        self.synchronize();
        if !self.aborted && self.platform.interrupted() {
            self.aborted = true;
            self.drive(|rti, outlet| rti.abort(outlet));
        }
        self.exchange();
        let now = self.platform.now();
        self.accept(now);
        self.table.expire(now);
        for entry in 0..self.table.due() {
            self.receive(self.table.due_at(entry));
            self.exchange();
        }
        if self.rti.poll_timeout().is_due(now) {
            self.drive(|rti, outlet| rti.handle_timeout(now, outlet));
        }
        self.report_waits(now);
        if self.stop_tag != self.rti.stop_tag() {
            self.stop_tag = self.rti.stop_tag();
            (0..self.table.len()).for_each(|index| self.table.resume(Awaited::Input(ConnectionId(index))));
        }
        // Messages and grants go before DNETs: a write can take longer than everything that was done for it.
        for entry in 0..self.table.due() {
            let index = self.table.due_at(entry);
            self.table.outgoings[index].flush_urgent(self.platform);
        }
        for _ in 0..self.table.due() {
            if let Some(index) = self.table.pop() {
                self.send(index);
            }
        }
        match self.rti.status() {
            Status::Finished(outcome) if self.close_all() => {
                self.recording.note(self.platform, Event::Ends(outcome != Outcome::Complete));
                Turn::Ended(outcome)
            }
            Status::Finished(_) | Status::Running => {
                let until = self.prepare_wait();
                if self.recording.is_on() && until != Deadline::Now {
                    self.recording.note(self.platform, Event::WaitBegins(WaitsFor::Anything));
                }
                Turn::Wait(until)
            }
        }
    }

    /// Waits until a socket is ready, or the deadline of the last [`RtiLoop::turn`] has come.
    pub fn wait(&mut self, until: Deadline) {
        let Self { platform, table, listener, port, .. } = self;
        platform.wait(until, &mut |socket, interest| {
            // A datagram is read at the beginning of the next turn.
            if !listener.handle_ready(socket) && !port.handle_ready(socket) {
                table.handle_ready(socket, interest);
            }
        });
        if self.recording.is_on() && until != Deadline::Now {
            self.recording.note(self.platform, Event::WaitEnds);
        }
    }

    fn drive<R>(&mut self, what: impl FnOnce(&mut Rti<'s>, &mut Outgoings<'_, P, N, B>) -> R) -> R {
        what(&mut self.rti, &mut self.table.outlet(self.platform, self.recording.reborrow(), self.log).1)
    }

    /// Closes what is still open after the end of the federation. Returns `true` when nothing is.
    fn close_all(&mut self) -> bool {
        // A peer that comes now has to learn at once that there is no RTI any more.
        self.listener.close(self.platform);
        self.port.close(self.platform);
        self.table.close_all();
        self.table.open() == 0
    }

    /// Accepts pending connections, while there are slots for them.
    fn accept(&mut self, now: Instant) {
        while self.listener.has_pending(now)
            && let Some(index) = self.place()
            && let Some((socket, address)) = self.listener.accept(self.platform, now)
        {
            let mut nonce = Nonce::default();
            if self.authentication
                && let Err(error) = self.platform.random(&mut nonce)
            {
                report(Level::Error, &ConnectionEvent::NoRandom(error));
                self.platform.close(socket);
                continue;
            }
            self.table.occupy(index, socket);
            self.drive(|rti, outlet| {
                rti.handle_connect(now, ConnectionId(index), address, nonce, outlet);
            });
        }
    }

    /// Returns a slot for a new connection. When there is none, and one is pending for sure, evicts a connection: one
    /// that is being closed, or else one that has not sent its id.
    fn place(&mut self) -> Option<usize> {
        let vacant = self.table.vacant();
        // Asked again when the listener says that one waits.
        if vacant.is_some() || !self.listener.postpone() {
            return vacant;
        }
        let index = match self.table.lingering() {
            Some(index) => index,
            None => self.drive(|rti, outlet| rti.evict(outlet))?.0,
        };
        self.platform.close(self.table.vacate(index)?);
        Some(index)
    }

    /// Reads one connection and handles its input.
    fn receive(&mut self, index: usize) {
        let Some(socket) = self.table.outgoings[index].socket else { return };
        if !self.table.outgoings[index].is_read() {
            self.table.inlets[index].discard(self.platform, socket);
            return;
        }
        let inlet = &mut self.table.inlets[index];
        if inlet.fill(self.platform, socket) {
            if inlet.reads_on() {
                inlet.awaits = None;
            }
            if inlet.ended {
                self.rti.handle_end(ConnectionId(index));
            }
        }
        if self.table.inlets[index].fresh && self.table.inlets[index].awaits.is_none() {
            self.offer(index);
            self.table.resume(Awaited::Input(ConnectionId(index)));
        }
        if self.table.inlets[index].ended && !self.table.inlets[index].fresh && self.table.has_work(index) {
            let now = self.platform.now();
            self.drive(|rti, outlet| rti.handle_disconnect(now, ConnectionId(index), outlet));
            self.table.outgoings[index].state = State::Closing(None);
        }
    }

    /// Passes the input of one connection to the machine, message by message.
    fn offer(&mut self, index: usize) {
        let now = self.platform.now();
        for _ in 0..MESSAGES_PER_TURN {
            let (inlets, mut outlet) = self.table.outlet(self.platform, self.recording.reborrow(), self.log);
            let inlet = &mut inlets[index];
            let bytes = inlet.buffer.bytes();
            if bytes.is_empty() {
                inlet.fresh = false;
                inlet.buffer.shrink();
                return;
            }
            outlet.learn_federate(index, bytes);
            match self.rti.handle_input(now, ConnectionId(index), bytes, &mut outlet) {
                Verdict::Consumed(count) => {
                    outlet.note_received(index, now, bytes.get(..count).unwrap_or_default());
                    inlet.buffer.consume(count);
                    inlet.awaits_since = None;
                }
                Verdict::Incomplete(needed) => {
                    inlet.fresh = false;
                    if !inlet.buffer.make_space_for(needed) {
                        self.give_up(index, needed);
                    }
                    return;
                }
                Verdict::Blocked(by) => return self.table.postpone(now, index, Awaited::Room(by)),
                Verdict::Held(until) => return self.table.postpone(now, index, Awaited::Input(until)),
                Verdict::HeldReadOn(until) => {
                    let needed = bytes.len() + 1;
                    if !inlet.buffer.make_space_for(needed) {
                        return self.give_up(index, needed);
                    }
                    return self.table.postpone(now, index, Awaited::InputOrMore(until));
                }
                Verdict::Closed => {
                    inlet.fresh = false;
                    inlet.clear();
                    self.table.outgoings[index].state = State::Closing(None);
                    return;
                }
            }
        }
    }

    /// Abandons a connection without memory for a message of this many bytes, from it or for it.
    fn give_up(&mut self, index: usize, bytes: usize) {
        self.drive(|rti, outlet| rti.handle_no_memory(ConnectionId(index), bytes, outlet));
        self.table.inlets[index].clear();
        self.table.outgoings[index].state = State::Closing(None);
        self.table.push(index);
    }

    /// Writes what is pending on one connection, releases input that waited for room there, and sets what to wait for.
    fn send(&mut self, index: usize) {
        if self.table.outgoings[index].socket.is_none() {
            return;
        }
        if let Some(bytes) = self.table.outgoings[index].refused.take() {
            self.give_up(index, bytes);
        }
        // What was postponed goes out in the same turn, and makes room for what did not fit behind it.
        while self.table.outgoings[index].flush(self.platform) {
            let now = self.platform.now();
            self.drive(|rti, outlet| rti.handle_writable(now, ConnectionId(index), outlet));
            self.table.resume(Awaited::Room(ConnectionId(index)));
        }
        self.table.outgoings[index].advance_closing(self.platform, self.table.inlets[index].ended);
        if !self.table.outgoings[index].is_open() {
            self.table.resume(Awaited::Room(ConnectionId(index)));
            self.table.resume(Awaited::Input(ConnectionId(index)));
        }
        let Some(socket) = self.table.outgoings[index].socket else {
            self.table.freed();
            self.listener.mark_pending();
            return;
        };
        let interest = self.table.interest(index);
        self.platform.set_interest(socket, interest);
        if self.table.has_work(index) {
            self.table.push(index);
        }
    }

    /// Logs senders whose messages have been waiting for too long, and their receivers, when a check is due.
    fn report_waits(&mut self, now: Instant) {
        let Some((interval, due)) = self.log_waits.filter(|(_, due)| *due <= now) else { return };
        self.log_waits = Some((interval, due.max(now) + Interval::from_nanos((interval.as_nanos() / 4).max(1))));
        for index in 0..self.table.len() {
            let inlet = &self.table.inlets[index];
            let (Some(awaited), Some(since)) = (inlet.awaits, inlet.awaits_since) else { continue };
            let lasts = now.since(since);
            let federates = (self.rti.federate_on(ConnectionId(index)), self.rti.federate_on(awaited.connection()));
            if let (Some(from), Some(to)) = federates
                && lasts >= interval
            {
                self.table.inlets[index].awaits_since = Some(Instant::FOREVER);
                let room = matches!(awaited, Awaited::Room(_));
                (self.log)(RtiEvent::Waits(Waits::Sender { from, to, room, lasts }));
            }
        }
    }

    /// Returns when the next round begins: never without a port, which is closed when the federation has ended.
    fn next_round(&self) -> Deadline {
        if P::DATAGRAMS && self.port.socket().is_some() { self.rti.poll_round_timeout() } else { Deadline::Never }
    }

    /// Answers the datagrams that have come, a bounded number of them, and begins a round if one is due.
    fn synchronize(&mut self) {
        let Some(socket) = self.port.socket().filter(|_| P::DATAGRAMS) else { return };
        let Self { rti, table, log, recording, .. } = self;
        self.port.receive(self.platform, |platform, socket, now, from, datagram| {
            let outlet = &mut table.outlet(platform, recording.reborrow(), *log).1;
            let answer = rti.handle_datagram(now, from, datagram, outlet);
            let sent = answer.map(|answer| {
                send(platform, socket, answer.to, &answer.message);
                let probe = answer.coded_probe(platform.now());
                send(platform, socket, probe.to, &probe.message);
                [answer.message, probe.message]
            });
            // Only now, because the times of these messages count.
            if recording.is_on() {
                let federate = rti.federate_at(from).map_or(RTI, |id| id.0);
                recording.note_bytes(now, datagram, federate);
                for message in sent.iter().flatten() {
                    recording.note_sent(platform, message, federate);
                }
            }
        });
        let now = self.platform.now();
        if self.rti.poll_round_timeout().is_due(now)
            && let Some(question) = self.rti.poll_round(now)
        {
            send(self.platform, socket, question.to, &question.message);
            if self.recording.is_on() {
                let federate = self.rti.federate_at(question.to).map_or(RTI, |id| id.0);
                self.recording.note_sent(self.platform, &question.message, federate);
            }
        }
    }

    /// Runs clock synchronization over TCP before the start. Any work between an answer and the times that depend on it
    /// would count as network delay. So the connection of the current exchange comes before all others, and again after
    /// each of them; the RTI writes its answer at once, and reads the time right before it begins an exchange.
    ///
    /// Only reading shows whether input has arrived there, because the last wait is over.
    fn exchange(&mut self) {
        if let Some(ConnectionId(index)) = self.rti.exchanging() {
            self.table.inlets[index].readable = true;
            self.receive(index);
            self.send(index);
        }
        while self.rti.poll_exchange_timeout() != Deadline::Never {
            let now = self.platform.now();
            let Some(ConnectionId(index)) = self.drive(|rti, outlet| rti.poll_exchange(now, outlet)) else { return };
            self.send(index);
        }
    }

    /// Sets whether to wait for connections, and returns the deadline of the wait.
    fn prepare_wait(&mut self) -> Deadline {
        let room = self.table.vacant().is_some();
        self.listener.set_interest(self.platform, room || self.table.lingering().is_some() || self.rti.can_evict());
        if self.table.due() > 0 {
            return Deadline::Now;
        }
        // A slot may have become free after this turn's check of the listener.
        let accept = self.listener.poll_timeout(room);
        let now = self.platform.now();
        let next_event = self.rti.next_event_after(now);
        self.platform.expect(next_event);
        let look = self.log_waits.map(|(_, due)| due).into();
        let federation = self.rti.poll_timeout().min(self.rti.poll_exchange_timeout()).min(self.next_round());
        federation.min(self.table.poll_timeout()).min(accept).min(look)
    }
}
