// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI.

mod clock_sync;
mod connections;
mod exchange;
mod notices;

use core::fmt;

use lf_coordination::auth::Nonce;
use lf_coordination::rti::{Config, ConnectionId, Notice, Outcome, Rti, RtiStorage, Status, Verdict, Waits};
use lf_coordination::{Deadline, Tally};
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::Storage;

pub use connections::{Inlet, Outgoing};
pub use notices::log_notice;

use crate::error::RunError;
use crate::platform::{Interest, Platform, SocketId};
use crate::turn::Turn;
use clock_sync::Port;
use connections::{Awaited, Due, Outgoings, State, connection_of, note_socket};

/// How many messages of one connection are handled before the next connection has its turn.
const MESSAGES_PER_TURN: u32 = 64;
/// How long no connection is accepted after the system has had no resources for one.
const ACCEPT_PAUSE: Interval = Interval::from_millis(100);

/// All that an RTI needs: the machine's memory, and as many inlets and outgoings as that has connections, whose buffers
/// are in slices or in [`Storage`] that grows.
pub struct RtiSetup<'s, B = &'s mut [u8]> {
    /// What the RTI is told about the federation.
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

/// Runs the RTI of one federation on a listening socket, until all federates have left or the program is interrupted.
///
/// `notices` is told what people may want to know.
///
/// # Errors
/// [`RunError::Setup`] when configuration and storage do not go together, [`RunError::BufferTooSmall`] when a buffer
/// cannot hold the longest message. The listening socket is closed in any case.
pub fn run_rti<P: Platform, B: Storage>(
    platform: &mut P,
    setup: RtiSetup<'_, B>,
    listener: SocketId,
    notices: &mut impl FnMut(Notice<'_>),
) -> Result<Outcome, RunError> {
    let mut rti = RtiLoop::new(platform, setup, listener, notices)?;
    loop {
        match rti.turn() {
            Turn::Wait(until) => rti.wait(until),
            Turn::Ended(outcome) => return Ok(outcome),
        }
    }
}

/// Whether each buffer can hold the longest message; one that cannot would hold that message back for ever.
fn check_buffers<B: Storage>(needed: usize, inlets: &[Inlet<B>], outgoings: &[Outgoing<B>]) -> Result<(), RunError> {
    let receive = inlets.iter().map(|inlet| ("receive", inlet.buffer.capacity_max()));
    let send = outgoings.iter().map(|outgoing| ("send", outgoing.buffer.capacity_max()));
    match receive.chain(send).find(|(_, found)| *found < needed) {
        Some((buffer, found)) => Err(RunError::BufferTooSmall { buffer, needed, found }),
        None => Ok(()),
    }
}

/// The event loop of the RTI, turn by turn: who calls [`RtiLoop::turn`] and [`RtiLoop::wait`] in alternation runs the
/// RTI, and may do something else in between.
pub struct RtiLoop<'a, 's, P, N, B = &'s mut [u8]> {
    platform: &'a mut P,
    rti: Rti<'s>,
    inlets: &'a mut [Inlet<B>],
    outgoings: &'a mut [Outgoing<B>],
    /// Where something came, went or is to be done; all others are left alone.
    due: Due,
    /// How many connections there are.
    open: usize,
    /// When the next connection that is being closed may be due.
    closing: Deadline,
    listening: Listening,
    /// For clock synchronization.
    port: Port,
    aborted: bool,
    /// The tag at which all stop, once it is known and what was held has been let go on.
    stop_tag: Option<Tag>,
    /// Each connection gets a nonce.
    authentication: bool,
    /// After how long it is said that messages wait, and when to look whether some do.
    log_waits: Option<(Interval, Instant)>,
    notices: &'a mut N,
}

/// Where connections come from.
struct Listening {
    /// Until the federation is over.
    socket: Option<SocketId>,
    /// A connection may be waiting.
    acceptable: bool,
    /// The listener has said so since the last one was taken.
    knocks: bool,
    /// When to accept again after the system had no resources.
    again: Option<Instant>,
    /// How often it had none.
    failures: Tally,
}

impl<P, N, B> fmt::Debug for RtiLoop<'_, '_, P, N, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RtiLoop").field("aborted", &self.aborted).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform, N: FnMut(Notice<'_>), B: Storage> RtiLoop<'a, 's, P, N, B> {
    /// An RTI whose federates may come now.
    ///
    /// # Errors
    /// [`RunError::Setup`] when configuration and storage do not go together, [`RunError::BufferTooSmall`] when a
    /// buffer cannot hold the longest message. The listening socket is then closed.
    pub fn new(
        platform: &'a mut P,
        setup: RtiSetup<'s, B>,
        listener: SocketId,
        notices: &'a mut N,
    ) -> Result<Self, RunError>
    where
        's: 'a,
    {
        let RtiSetup { config, storage, inlets, outgoings, datagrams } = setup;
        let mut port = Port::new(platform, datagrams);
        let authentication = config.authentication.is_some();
        let log_waits = config.log_waits.map(|interval| (interval, platform.now()));
        let rti = Rti::new(config, storage).map_err(RunError::Setup).and_then(|rti| {
            check_buffers(rti.message_bytes_max(), inlets, outgoings)?;
            Ok(rti)
        });
        let rti = match rti {
            Ok(rti) => rti,
            Err(error) => {
                platform.close(listener);
                port.close(platform);
                return Err(error);
            }
        };
        let count = inlets.len().min(outgoings.len()).min(u16::MAX.into());
        Ok(Self {
            platform,
            rti,
            inlets: &mut inlets[..count],
            outgoings: &mut outgoings[..count],
            due: Due::default(),
            open: 0,
            closing: Deadline::Never,
            listening: Listening {
                socket: Some(listener),
                acceptable: true,
                knocks: false,
                again: None,
                failures: Tally::NOTHING,
            },
            port,
            aborted: false,
            stop_tag: None,
            authentication,
            log_waits,
            notices,
        })
    }

    /// Does what can be done now. Bounded by the number of connections with something to do times
    /// [`MESSAGES_PER_TURN`].
    pub fn turn(&mut self) -> Turn<Outcome> {
        self.synchronize();
        if !self.aborted && self.platform.interrupted() {
            self.aborted = true;
            self.tell(|rti, outlet| rti.abort(outlet));
        }
        self.exchange();
        let now = self.platform.now();
        self.accept(now);
        self.expire(now);
        for entry in 0..self.due.len() {
            self.receive(self.due.get(self.outgoings, entry));
            self.exchange();
        }
        if self.rti.poll_timeout().is_due(now) {
            self.tell(|rti, outlet| rti.handle_timeout(now, outlet));
        }
        self.look_for_waits(now);
        if self.stop_tag != self.rti.stop_tag() {
            self.stop_tag = self.rti.stop_tag();
            (0..self.inlets.len()).for_each(|index| self.let_go_on(Awaited::Input(ConnectionId(index))));
        }
        // Messages and grants go before advice: a write can take longer than all that was done for it.
        for entry in 0..self.due.len() {
            let index = self.due.get(self.outgoings, entry);
            self.outgoings[index].hurry(self.platform);
        }
        for _ in 0..self.due.len() {
            if let Some(index) = self.due.pop(self.outgoings) {
                self.send(index);
            }
        }
        match self.rti.status() {
            Status::Finished(outcome) if self.close_all() => Turn::Ended(outcome),
            Status::Finished(_) | Status::Running => Turn::Wait(self.prepare_wait()),
        }
    }

    /// Waits until a socket is ready, or the time has come that the last [`RtiLoop::turn`] gave.
    pub fn wait(&mut self, until: Deadline) {
        let Self { platform, inlets, outgoings, due, listening, port, .. } = self;
        platform.wait(until, &mut |socket, interest| {
            if Some(socket) == listening.socket {
                (listening.acceptable, listening.knocks) = (true, true);
            } else if port.handle_ready(socket) {
                // It is read at the beginning of the next turn.
            } else if let Some(index) = connection_of(outgoings, socket) {
                inlets[index].readable |= interest.readable;
                due.push(outgoings, index);
            }
        });
    }

    fn tell<R>(&mut self, what: impl FnOnce(&mut Rti<'s>, &mut Outgoings<'_, N, B>) -> R) -> R {
        let mut outlet = Outgoings { table: self.outgoings, due: &mut self.due, notices: self.notices };
        what(&mut self.rti, &mut outlet)
    }

    /// Closes what is still open after the end of the federation. `true` when nothing is.
    fn close_all(&mut self) -> bool {
        if let Some(listener) = self.listening.socket.take() {
            // Whoever comes now shall see at once that nobody is here.
            self.platform.close(listener);
        }
        self.port.close(self.platform);
        for index in 0..self.outgoings.len() {
            if self.outgoings[index].is_read() {
                self.outgoings[index].state = State::Closing(None);
                self.due.push(self.outgoings, index);
            }
        }
        self.open == 0
    }

    /// Takes the connections that wait, as long as there are places for them.
    fn accept(&mut self, now: Instant) {
        if self.listening.again.is_some_and(|time| time <= now) {
            (self.listening.again, self.listening.acceptable) = (None, true);
        }
        while self.listening.acceptable {
            let Some(listener) = self.listening.socket else { return };
            let Some(index) = self.place() else { return };
            self.listening.knocks = false;
            match self.platform.accept(listener) {
                Ok(Some((socket, address))) => {
                    let mut nonce = Nonce::default();
                    if self.authentication
                        && let Err(error) = self.platform.random(&mut nonce)
                    {
                        log::error!("a connection is refused: {error}");
                        self.platform.close(socket);
                        continue;
                    }
                    self.open += 1;
                    self.outgoings[index].open(socket);
                    self.inlets[index].reset();
                    note_socket(self.outgoings, socket, index);
                    self.due.push(self.outgoings, index);
                    self.tell(|rti, outlet| {
                        rti.handle_connect(now, ConnectionId(index), address.octets(), nonce, outlet);
                    });
                }
                Ok(None) => self.listening.acceptable = false,
                Err(error) => {
                    // The connection still waits, so the listener stays ready: asking it at once would be without end.
                    let times = self.listening.failures.count();
                    if times.is_told() {
                        log::warn!("a connection could not be accepted: {error}{times}");
                    }
                    self.listening.acceptable = false;
                    self.listening.again = Some(now + ACCEPT_PAUSE);
                }
            }
        }
    }

    /// A place for a new connection. When there is none, and one has come for sure, somebody makes way for it: who is
    /// being closed, or else who has not said which federate it is.
    fn place(&mut self) -> Option<usize> {
        let vacant = self.outgoings.iter().position(|outgoing| outgoing.socket.is_none());
        if vacant.is_some() {
            return vacant;
        }
        // Asked again when the listener says that one waits.
        self.listening.acceptable = core::mem::take(&mut self.listening.knocks);
        if !self.listening.acceptable {
            return None;
        }
        let index = match self.lingering() {
            Some(index) => index,
            None => self.tell(|rti, outlet| rti.make_way(outlet))?.0,
        };
        let socket = self.outgoings.get_mut(index)?.vacate()?;
        self.platform.close(socket);
        self.open -= 1;
        self.let_go_on(Awaited::Room(ConnectionId(index)));
        self.let_go_on(Awaited::Input(ConnectionId(index)));
        Some(index)
    }

    /// The connection that has been being closed for longest, if its peer has been sent all.
    fn lingering(&self) -> Option<usize> {
        let until = |(index, outgoing): (usize, &Outgoing<B>)| outgoing.lingers_until().map(|until| (until, index));
        self.outgoings.iter().enumerate().filter_map(until).min().map(|(_, index)| index)
    }

    /// Looks at the connections that are being closed, if the time of one may have come.
    fn expire(&mut self, now: Instant) {
        if !self.closing.is_due(now) {
            return;
        }
        self.closing = Deadline::Never;
        for index in 0..self.outgoings.len() {
            let time_out = self.outgoings[index].poll_timeout();
            if time_out.is_due(now) {
                self.due.push(self.outgoings, index);
            } else {
                self.closing = self.closing.min(time_out);
            }
        }
    }

    /// Reads one connection and handles what has come.
    fn receive(&mut self, index: usize) {
        let Some(socket) = self.outgoings[index].socket else { return };
        if !self.outgoings[index].is_read() {
            self.inlets[index].discard(self.platform, socket);
            return;
        }
        let inlet = &mut self.inlets[index];
        if inlet.fill(self.platform, socket) {
            if inlet.reads_on() {
                inlet.awaits = None;
            }
            if inlet.ended {
                self.rti.handle_end(ConnectionId(index));
            }
        }
        if self.inlets[index].fresh && self.inlets[index].awaits.is_none() {
            self.offer(index);
            self.let_go_on(Awaited::Input(ConnectionId(index)));
        }
        if self.inlets[index].ended && !self.inlets[index].fresh && self.has_work(index) {
            let now = self.platform.now();
            self.tell(|rti, outlet| rti.handle_disconnect(now, ConnectionId(index), outlet));
            self.outgoings[index].state = State::Closing(None);
        }
    }

    /// Offers what has come on one connection to the machine, message by message.
    fn offer(&mut self, index: usize) {
        let now = self.platform.now();
        for _ in 0..MESSAGES_PER_TURN {
            let mut outlet = Outgoings { table: self.outgoings, due: &mut self.due, notices: self.notices };
            let inlet = &mut self.inlets[index];
            let bytes = inlet.buffer.bytes();
            if bytes.is_empty() {
                inlet.fresh = false;
                inlet.buffer.shrink();
                return;
            }
            match self.rti.handle_input(now, ConnectionId(index), bytes, &mut outlet) {
                Verdict::Consumed(count) => {
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
                Verdict::Blocked(by) => return self.put_off(now, index, Awaited::Room(by)),
                Verdict::Held(until) => return self.put_off(now, index, Awaited::Input(until)),
                Verdict::HeldReadOn(until) => {
                    let needed = bytes.len() + 1;
                    if !inlet.buffer.make_space_for(needed) {
                        return self.give_up(index, needed);
                    }
                    return self.put_off(now, index, Awaited::InputOrMore(until));
                }
                Verdict::Closed => {
                    inlet.fresh = false;
                    inlet.clear();
                    self.outgoings[index].state = State::Closing(None);
                    return;
                }
            }
        }
    }

    /// There is no memory for a message of so many bytes, from a connection or for it: nothing goes on there.
    fn give_up(&mut self, index: usize, bytes: usize) {
        self.tell(|rti, outlet| rti.handle_no_memory(ConnectionId(index), bytes, outlet));
        self.inlets[index].clear();
        self.outgoings[index].state = State::Closing(None);
        self.due.push(self.outgoings, index);
    }

    /// Writes what is pending on one connection, lets go on what waited for room there, and says what to wait for.
    fn send(&mut self, index: usize) {
        if self.outgoings[index].socket.is_none() {
            return;
        }
        if let Some(bytes) = self.outgoings[index].refused.take() {
            self.give_up(index, bytes);
        }
        if self.outgoings[index].flush(self.platform) {
            let now = self.platform.now();
            self.tell(|rti, outlet| rti.handle_writable(now, ConnectionId(index), outlet));
            // What was put off goes with the same turn.
            self.outgoings[index].flush(self.platform);
            self.let_go_on(Awaited::Room(ConnectionId(index)));
        }
        self.outgoings[index].advance_closing(self.platform, self.inlets[index].ended);
        if !self.outgoings[index].is_open() {
            self.let_go_on(Awaited::Room(ConnectionId(index)));
            self.let_go_on(Awaited::Input(ConnectionId(index)));
        }
        let Some(socket) = self.outgoings[index].socket else {
            self.open -= 1;
            (self.listening.again, self.listening.acceptable) = (None, true);
            return;
        };
        self.closing = self.closing.min(self.outgoings[index].poll_timeout());
        let reading = self.inlets[index].wants_more();
        self.platform.set_interest(socket, self.outgoings[index].interest(reading));
        if self.has_work(index) {
            self.due.push(self.outgoings, index);
        }
    }

    /// Says whose messages have been waiting for too long, and for whom, if it is time to look.
    fn look_for_waits(&mut self, now: Instant) {
        let Some((interval, due)) = self.log_waits.filter(|(_, due)| *due <= now) else { return };
        self.log_waits = Some((interval, due.max(now) + Interval((interval.as_nanos() / 4).max(1))));
        for index in 0..self.inlets.len() {
            let inlet = &self.inlets[index];
            let (Some(awaited), Some(since)) = (inlet.awaits, inlet.awaits_since) else { continue };
            let lasts = now.since(since);
            let federates = (self.rti.federate_on(ConnectionId(index)), self.rti.federate_on(awaited.connection()));
            if let (Some(from), Some(to)) = federates
                && lasts >= interval
            {
                self.inlets[index].awaits_since = Some(Instant::FOREVER);
                let room = matches!(awaited, Awaited::Room(_));
                (self.notices)(Notice::Waits(Waits::Sender { from, to, room, lasts }));
            }
        }
    }

    /// The message at the front of a connection has to wait.
    fn put_off(&mut self, now: Instant, index: usize, awaited: Awaited) {
        let inlet = &mut self.inlets[index];
        inlet.awaits = Some(awaited);
        inlet.awaits_since = inlet.awaits_since.or(Some(now));
        let on = awaited.connection();
        if let Some(outgoing) = self.outgoings.get_mut(on.0) {
            outgoing.awaited = true;
            // Should it be closing already, nothing else would lead there.
            self.due.push(self.outgoings, on.0);
        }
    }

    /// What was awaited has come about.
    fn let_go_on(&mut self, awaited: Awaited) {
        let on = awaited.connection();
        if !core::mem::take(&mut self.outgoings[on.0].awaited) {
            return;
        }
        for index in 0..self.inlets.len() {
            let inlet = &mut self.inlets[index];
            if inlet.awaits.is_some_and(|awaits| awaits.is(awaited)) {
                inlet.awaits = None;
                self.due.push(self.outgoings, index);
            } else if inlet.awaits.is_some_and(|other| other.connection() == on) {
                self.outgoings[on.0].awaited = true;
            }
        }
    }

    /// Whether there is something to be done for a connection though its socket is not ready.
    fn has_work(&self, index: usize) -> bool {
        let inlet = &self.inlets[index];
        self.outgoings[index].is_read() && inlet.awaits.is_none() && (inlet.fresh || inlet.ended)
    }

    /// Says whether to wait for connections, and gives until when to wait.
    fn prepare_wait(&mut self) -> Deadline {
        let room = self.open < self.outgoings.len();
        if let Some(listener) = self.listening.socket {
            let place = room || self.lingering().is_some() || self.rti.can_make_way();
            let accepting = place && self.listening.again.is_none();
            self.platform.set_interest(listener, if accepting { Interest::READ } else { Interest::NONE });
        }
        if self.due.len() > 0 {
            return Deadline::Now;
        }
        // A place may have become free after this turn's look at the listener.
        let accept = match self.listening.socket {
            Some(_) if self.listening.acceptable && room => Deadline::Now,
            Some(_) => self.listening.again.into(),
            None => Deadline::Never,
        };
        let now = self.platform.now();
        let next_event = self.rti.next_event_after(now);
        self.platform.expect(next_event);
        let look = self.log_waits.map(|(_, due)| due).into();
        let federation = self.rti.poll_timeout().min(self.rti.poll_exchange_timeout()).min(self.next_round());
        federation.min(self.closing).min(accept).min(look)
    }
}
