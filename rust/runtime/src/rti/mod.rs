// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI.

mod connections;

use lf_coordination::Deadline;
use lf_coordination::rti::{Config, ConnectionId, Notice, Outcome, Rti, RtiStorage, Status, Verdict};

pub use connections::{Inlet, Outgoing};

use crate::error::RunError;
use crate::platform::{Interest, Platform, SocketId};
use connections::{Outgoings, State};

/// How many messages of one connection are handled before the next connection has its turn.
const MESSAGES_PER_TURN: u32 = 64;

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
/// [`RunError::Setup`] when configuration and storage do not go together.
pub fn run_rti<P: Platform>(
    platform: &mut P,
    setup: RtiSetup<'_>,
    listener: SocketId,
    notices: &mut impl FnMut(Notice<'_>),
) -> Result<Outcome, RunError> {
    let RtiSetup { config, storage, inlets, outgoings } = setup;
    let rti = Rti::new(config, storage).map_err(RunError::Setup)?;
    let count = inlets.len().min(outgoings.len());
    let mut state = Loop {
        platform,
        rti,
        inlets: &mut inlets[..count],
        outgoings: &mut outgoings[..count],
        listener,
        acceptable: true,
        aborted: false,
        notices,
    };
    loop {
        if let Some(outcome) = state.turn() {
            state.platform.close(listener);
            return Ok(outcome);
        }
        state.wait();
    }
}

struct Loop<'a, 's, P, N> {
    platform: &'a mut P,
    rti: Rti<'s>,
    inlets: &'a mut [Inlet<'s>],
    outgoings: &'a mut [Outgoing<'s>],
    listener: SocketId,
    /// A connection may be waiting at the listener.
    acceptable: bool,
    aborted: bool,
    notices: &'a mut N,
}

impl<P: Platform, N: FnMut(Notice<'_>)> Loop<'_, '_, P, N> {
    /// Does what can be done now. Bounded by the number of connections times [`MESSAGES_PER_TURN`].
    fn turn(&mut self) -> Option<Outcome> {
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
        self.send();
        match self.rti.status() {
            Status::Running => None,
            Status::Finished(outcome) => self.close_all().then_some(outcome),
        }
    }

    /// Closes what is still open after the end of the federation. `true` when nothing is.
    fn close_all(&mut self) -> bool {
        for outgoing in self.outgoings.iter_mut().filter(|outgoing| outgoing.is_read()) {
            outgoing.state = State::Closing(None);
        }
        self.outgoings.iter().all(|outgoing| outgoing.socket.is_none())
    }

    /// Takes the connections that wait, as long as there are places for them.
    fn accept(&mut self) {
        while self.acceptable {
            let Some(index) = self.outgoings.iter().position(|outgoing| outgoing.socket.is_none()) else { return };
            match self.platform.accept(self.listener) {
                Ok(Some((socket, address))) => {
                    self.outgoings[index].open(socket);
                    self.inlets[index].reset();
                    let now = self.platform.now();
                    let mut outlet = Outgoings { table: self.outgoings, notices: self.notices };
                    self.rti.handle_connect(now, ConnectionId(index), address.octets(), &mut outlet);
                }
                Ok(None) | Err(_) => self.acceptable = false,
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
        if self.inlets[index].fresh && self.inlets[index].blocked_by.is_none() {
            self.offer(index);
        }
        let inlet = &self.inlets[index];
        if inlet.ended && !inlet.fresh && inlet.blocked_by.is_none() && self.outgoings[index].is_read() {
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
                    inlet.blocked_by = Some(by);
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
                self.unblock(ConnectionId(index));
            }
            self.outgoings[index].advance_closing(self.platform, self.inlets[index].ended);
            if self.outgoings[index].socket.is_none() {
                self.unblock(ConnectionId(index));
                self.acceptable = true;
            }
        }
    }

    fn unblock(&mut self, room_on: ConnectionId) {
        for inlet in self.inlets.iter_mut().filter(|inlet| inlet.blocked_by == Some(room_on)) {
            inlet.blocked_by = None;
        }
    }

    /// When the next turn is due though no socket is ready.
    fn deadline(&self) -> Deadline {
        let busy = |(inlet, outgoing): (&Inlet<'_>, &Outgoing<'_>)| {
            outgoing.is_read() && inlet.blocked_by.is_none() && (inlet.fresh || inlet.ended)
        };
        if self.inlets.iter().zip(self.outgoings.iter()).any(busy) {
            return Deadline::Now;
        }
        let closing = self.outgoings.iter().map(Outgoing::poll_timeout).min().unwrap_or(Deadline::Never);
        self.rti.poll_timeout().min(closing)
    }

    /// Waits until a socket is ready or a time-out is due.
    fn wait(&mut self) {
        let room = self.outgoings.iter().any(|outgoing| outgoing.socket.is_none());
        self.platform.set_interest(self.listener, if room { Interest::READ } else { Interest::NONE });
        for (inlet, outgoing) in self.inlets.iter_mut().zip(self.outgoings.iter()) {
            if let Some(socket) = outgoing.socket {
                let reading = !inlet.ended && inlet.blocked_by.is_none() && !inlet.buffer.space().is_empty();
                self.platform.set_interest(socket, outgoing.interest(reading));
            }
        }
        let deadline = self.deadline();
        let Self { platform, inlets, outgoings, listener, acceptable, .. } = self;
        platform.wait(deadline, &mut |socket, interest| {
            if socket == *listener {
                *acceptable = true;
            } else if let Some(index) = outgoings.iter().position(|outgoing| outgoing.socket == Some(socket)) {
                inlets[index].readable |= interest.readable;
            }
        });
    }
}
