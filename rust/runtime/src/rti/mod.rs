// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI.

mod connections;

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::rti::{Config, ConnectionId, Notice, Outcome, Rti, RtiStorage, Status, Verdict};
use lf_model::time::{Instant, Interval, Tag};

pub use connections::{Inlet, Outgoing};

use crate::error::RunError;
use crate::platform::{Interest, Platform, SocketId};
use crate::turn::Turn;
use connections::{Awaited, Outgoings, State};

/// How many messages of one connection are handled before the next connection has its turn.
const MESSAGES_PER_TURN: u32 = 64;
/// How long no connection is accepted after the system has had no resources for one.
const ACCEPT_PAUSE: Interval = Interval::from_millis(100);

/// All that an RTI needs: the machine's memory, and as many inlets and outgoings as that has connections.
pub struct RtiSetup<'s> {
    /// What the RTI is told about the federation.
    pub config: Config<'s>,
    /// The machine's memory.
    pub storage: RtiStorage<'s>,
    /// The receiving side of the connections.
    pub inlets: &'s mut [Inlet<'s>],
    /// The sending side of the connections.
    pub outgoings: &'s mut [Outgoing<'s>],
}

/// Runs the RTI of one federation on a listening socket, until all federates have left or the program is interrupted.
///
/// `notices` is told what people may want to know.
///
/// # Errors
/// [`RunError::Setup`] when configuration and storage do not go together, [`RunError::BufferTooSmall`] when a buffer
/// cannot hold the longest message. The listening socket is closed in any case.
pub fn run_rti<P: Platform>(
    platform: &mut P,
    setup: RtiSetup<'_>,
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
fn check_buffers(needed: usize, inlets: &[Inlet<'_>], outgoings: &[Outgoing<'_>]) -> Result<(), RunError> {
    let receive = inlets.iter().map(|inlet| ("receive", inlet.buffer.capacity()));
    let send = outgoings.iter().map(|outgoing| ("send", outgoing.buffer.capacity()));
    match receive.chain(send).find(|(_, found)| *found < needed) {
        Some((buffer, found)) => Err(RunError::BufferTooSmall { buffer, needed, found }),
        None => Ok(()),
    }
}

/// The event loop of the RTI, turn by turn: who calls [`RtiLoop::turn`] and [`RtiLoop::wait`] in alternation runs the
/// RTI, and may do something else in between.
pub struct RtiLoop<'a, 's, P, N> {
    platform: &'a mut P,
    rti: Rti<'s>,
    inlets: &'a mut [Inlet<'s>],
    outgoings: &'a mut [Outgoing<'s>],
    /// Until the federation is over.
    listener: Option<SocketId>,
    /// A connection may be waiting at the listener.
    acceptable: bool,
    /// When to accept again after the system had no resources.
    accept_again: Option<Instant>,
    aborted: bool,
    /// A message may be held until another connection has input.
    held: bool,
    /// The tag at which all stop, once it is known and what was held has been let go on.
    stop_tag: Option<Tag>,
    notices: &'a mut N,
}

impl<P, N> fmt::Debug for RtiLoop<'_, '_, P, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RtiLoop").field("aborted", &self.aborted).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform, N: FnMut(Notice<'_>)> RtiLoop<'a, 's, P, N> {
    /// An RTI whose federates may come now.
    ///
    /// # Errors
    /// [`RunError::Setup`] when configuration and storage do not go together, [`RunError::BufferTooSmall`] when a
    /// buffer cannot hold the longest message. The listening socket is then closed.
    pub fn new(
        platform: &'a mut P,
        setup: RtiSetup<'s>,
        listener: SocketId,
        notices: &'a mut N,
    ) -> Result<Self, RunError>
    where
        's: 'a,
    {
        let RtiSetup { config, storage, inlets, outgoings } = setup;
        let rti = Rti::new(config, storage).map_err(RunError::Setup).and_then(|rti| {
            check_buffers(rti.message_bytes_max(), inlets, outgoings)?;
            Ok(rti)
        });
        let rti = match rti {
            Ok(rti) => rti,
            Err(error) => {
                platform.close(listener);
                return Err(error);
            }
        };
        let count = inlets.len().min(outgoings.len());
        Ok(Self {
            platform,
            rti,
            inlets: &mut inlets[..count],
            outgoings: &mut outgoings[..count],
            listener: Some(listener),
            acceptable: true,
            accept_again: None,
            aborted: false,
            held: false,
            stop_tag: None,
            notices,
        })
    }

    /// Does what can be done now. Bounded by the number of connections times [`MESSAGES_PER_TURN`].
    pub fn turn(&mut self) -> Turn<Outcome> {
        if !self.aborted && self.platform.interrupted() {
            self.aborted = true;
            let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
            self.rti.abort(&mut outlet);
        }
        self.accept();
        for index in 0..self.inlets.len() {
            if self.outgoings[index].socket.is_some() {
                self.receive(index);
            }
        }
        let now = self.platform.now();
        if self.rti.poll_timeout().is_due(now) {
            let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
            self.rti.handle_timeout(now, &mut outlet);
        }
        if self.stop_tag != self.rti.stop_tag() {
            self.stop_tag = self.rti.stop_tag();
            (0..self.inlets.len()).for_each(|index| self.let_go_on(Awaited::Input(ConnectionId(index))));
        }
        self.send();
        match self.rti.status() {
            Status::Finished(outcome) if self.close_all() => Turn::Ended(outcome),
            Status::Finished(_) | Status::Running => Turn::Wait(self.prepare_wait()),
        }
    }

    /// Waits until a socket is ready, or the time has come that the last [`RtiLoop::turn`] gave.
    pub fn wait(&mut self, until: Deadline) {
        let Self { platform, inlets, outgoings, listener, acceptable, .. } = self;
        platform.wait(until, &mut |socket, interest| {
            if Some(socket) == *listener {
                *acceptable = true;
            } else if let Some(index) = outgoings.iter().position(|outgoing| outgoing.socket == Some(socket)) {
                inlets[index].readable |= interest.readable;
            }
        });
    }

    /// Closes what is still open after the end of the federation. `true` when nothing is.
    fn close_all(&mut self) -> bool {
        if let Some(listener) = self.listener.take() {
            // Whoever comes now shall see at once that nobody is here.
            self.platform.close(listener);
        }
        for outgoing in self.outgoings.iter_mut().filter(|outgoing| outgoing.is_read()) {
            outgoing.state = State::Closing(None);
        }
        self.outgoings.iter().all(|outgoing| outgoing.socket.is_none())
    }

    /// Takes the connections that wait, as long as there are places for them.
    fn accept(&mut self) {
        let now = self.platform.now();
        if self.accept_again.is_some_and(|time| time <= now) {
            (self.accept_again, self.acceptable) = (None, true);
        }
        while self.acceptable {
            let Some(listener) = self.listener else { return };
            let Some(index) = self.outgoings.iter().position(|outgoing| outgoing.socket.is_none()) else { return };
            match self.platform.accept(listener) {
                Ok(Some((socket, address))) => {
                    self.outgoings[index].open(socket);
                    self.inlets[index].reset();
                    let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
                    self.rti.handle_connect(now, ConnectionId(index), address.octets(), &mut outlet);
                }
                Ok(None) => self.acceptable = false,
                Err(error) => {
                    // The connection still waits, so the listener stays ready: asking it at once would be without end.
                    log::warn!("a connection could not be accepted: {error}");
                    self.acceptable = false;
                    self.accept_again = Some(now + ACCEPT_PAUSE);
                }
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
        self.inlets[index].fill(self.platform, socket);
        if self.inlets[index].fresh && self.inlets[index].awaits.is_none() {
            self.offer(index);
            if self.held {
                self.let_go_on(Awaited::Input(ConnectionId(index)));
                self.held = self.inlets.iter().any(|inlet| matches!(inlet.awaits, Some(Awaited::Input(_))));
            }
        }
        let inlet = &self.inlets[index];
        if inlet.ended && !inlet.fresh && inlet.awaits.is_none() && self.outgoings[index].is_read() {
            let now = self.platform.now();
            let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
            self.rti.handle_disconnect(now, ConnectionId(index), &mut outlet);
            self.outgoings[index].state = State::Closing(None);
        }
    }

    /// Offers what has come on one connection to the machine, message by message.
    fn offer(&mut self, index: usize) {
        let now = self.platform.now();
        for _ in 0..MESSAGES_PER_TURN {
            let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
            let inlet = &mut self.inlets[index];
            let bytes = inlet.buffer.bytes();
            if bytes.is_empty() {
                inlet.fresh = false;
                return;
            }
            match self.rti.handle_input(now, ConnectionId(index), bytes, &mut outlet) {
                Verdict::Consumed(count) => inlet.buffer.consume(count),
                Verdict::Incomplete(_) => {
                    inlet.fresh = false;
                    return;
                }
                Verdict::Blocked(by) => {
                    inlet.awaits = Some(Awaited::Room(by));
                    return;
                }
                Verdict::Held(until) => {
                    inlet.awaits = Some(Awaited::Input(until));
                    self.held = true;
                    return;
                }
                Verdict::Closed => {
                    inlet.fresh = false;
                    inlet.buffer.clear();
                    self.outgoings[index].state = State::Closing(None);
                    return;
                }
            }
        }
    }

    /// Writes what is pending on all connections, and lets go on what waited for room there.
    fn send(&mut self) {
        for index in 0..self.outgoings.len() {
            if self.outgoings[index].socket.is_none() {
                continue;
            }
            if self.outgoings[index].flush(self.platform) {
                let now = self.platform.now();
                let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
                self.rti.handle_writable(now, ConnectionId(index), &mut outlet);
                // What was put off goes with the same turn.
                self.outgoings[index].flush(self.platform);
                self.let_go_on(Awaited::Room(ConnectionId(index)));
            }
            self.outgoings[index].advance_closing(self.platform, self.inlets[index].ended);
            if !self.outgoings[index].is_open() {
                self.let_go_on(Awaited::Room(ConnectionId(index)));
                self.let_go_on(Awaited::Input(ConnectionId(index)));
            }
            if self.outgoings[index].socket.is_none() {
                (self.accept_again, self.acceptable) = (None, true);
            }
        }
    }

    /// What was awaited has come about.
    fn let_go_on(&mut self, awaited: Awaited) {
        for inlet in self.inlets.iter_mut().filter(|inlet| inlet.awaits == Some(awaited)) {
            inlet.awaits = None;
        }
    }

    /// When the next turn is due though no socket is ready.
    fn deadline(&self) -> Deadline {
        let busy = |(inlet, outgoing): (&Inlet<'_>, &Outgoing<'_>)| {
            outgoing.is_read() && inlet.awaits.is_none() && (inlet.fresh || inlet.ended)
        };
        if self.inlets.iter().zip(self.outgoings.iter()).any(busy) {
            return Deadline::Now;
        }
        let closing = self.outgoings.iter().map(Outgoing::poll_timeout).min().unwrap_or(Deadline::Never);
        // A place may have become free after this turn's look at the listener.
        let room = self.outgoings.iter().any(|outgoing| outgoing.socket.is_none());
        let accept = match self.listener {
            Some(_) if self.acceptable && room => Deadline::Now,
            Some(_) => self.accept_again.into(),
            None => Deadline::Never,
        };
        self.rti.poll_timeout().min(closing).min(accept)
    }

    /// Says what to wait for, and gives until when.
    fn prepare_wait(&mut self) -> Deadline {
        if let Some(listener) = self.listener {
            let room = self.outgoings.iter().any(|outgoing| outgoing.socket.is_none());
            let accepting = room && self.accept_again.is_none();
            self.platform.set_interest(listener, if accepting { Interest::READ } else { Interest::NONE });
        }
        for (inlet, outgoing) in self.inlets.iter_mut().zip(self.outgoings.iter()) {
            if let Some(socket) = outgoing.socket {
                let reading = !inlet.ended && inlet.awaits.is_none() && !inlet.buffer.space().is_empty();
                self.platform.set_interest(socket, outgoing.interest(reading));
            }
        }
        self.deadline()
    }
}
