// SPDX-License-Identifier: Apache-2.0
//! The world as an event loop's platform.

use std::sync::Arc;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};
use lf_runtime::trace::{Event, Record, Recorder};

use super::turns::Turns;
use super::{Shared, Side, Wires};
use crate::network::Medium;

/// The percentage of waits that leave one more ready socket for the next wait, in worlds in which waits may do so.
const LEFT_PERCENT: u64 = 25;

/// One participant's view of the world.
#[derive(Debug)]
pub struct Virtual<M: Medium = Wires> {
    world: Shared<M>,
    me: usize,
    side: &'static Side,
    /// The state behind blocking, if it has a thread of its own.
    turns: Option<Arc<Turns<M>>>,
}

impl<M: Medium> Shared<M> {
    /// Returns a participant's platform, whose `wait` returns at once.
    pub fn platform(&self, participant: usize) -> Virtual<M> {
        Virtual::new(self.clone(), participant, None)
    }
}

impl<M: Medium> Virtual<M> {
    pub(super) fn new(world: Shared<M>, me: usize, turns: Option<Arc<Turns<M>>>) -> Self {
        let side = world.lock().side(me);
        Self { world, me, side, turns }
    }

    /// Waits for this participant's first turn, if it has a thread of its own.
    pub fn begin(&mut self) {
        if let Some(turns) = &self.turns {
            turns.wait_for(self.me);
        }
    }

    /// Returns the number of this participant.
    pub fn number(&self) -> usize {
        self.me
    }

    /// Returns the state that this participant shares with its threads.
    pub fn side(&self) -> &'static Side {
        self.side
    }

    /// Returns a recorder that keeps this participant's events in the world.
    pub fn recorder(&self) -> MemberRecorder<M> {
        MemberRecorder { world: self.world.clone(), me: self.me }
    }
}

/// A recorder that keeps the events of one participant in the world.
#[derive(Debug)]
pub struct MemberRecorder<M: Medium = Wires> {
    world: Shared<M>,
    me: usize,
}

impl<M: Medium> Recorder for MemberRecorder<M> {
    fn record(&mut self, at: Instant, event: Event) {
        self.world.lock().members[self.me].records.push(Record { at, event });
    }
}

/// A participant with a thread of its own ends when its platform is dropped.
impl<M: Medium> Drop for Virtual<M> {
    fn drop(&mut self) {
        if let Some(turns) = &self.turns {
            turns.leave(self.me);
        }
    }
}

impl<M: Medium> Platform for Virtual<M> {
    fn now(&mut self) -> Instant {
        self.side.local()
    }

    fn outside(&self) -> &'static dyn Outside {
        self.side
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        self.side.set_correction(correction);
    }

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        let mut world = self.world.lock();
        let random = world.network.medium_mut().random();
        buffer.fill_with(|| random.byte());
        Ok(())
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        self.world.lock().network.connect(self.me, address, self.side.now())
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.world.lock().network.connected(self.me, socket, self.side.now())
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.world.lock().network.listen(self.me, port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.world.lock().network.bind(self.me, port)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        self.world.lock().network.receive_from(self.me, socket, buffer, self.side.now())
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.world.lock().network.send_to(self.me, socket, to, bytes, self.side.now())
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.world.lock().network.local_port(self.me, listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        self.world.lock().network.accept(self.me, listener, self.side.now())
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.world.lock().network.read(self.me, socket, buffer, self.side.now())
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        self.world.lock().network.write(self.me, socket, bytes, self.side.now())
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        self.world.lock().network.shut_down_writing(self.me, socket, self.side.now());
    }

    fn close(&mut self, socket: SocketId) {
        self.world.lock().network.close(self.me, socket, self.side.now());
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.world.lock().network.set_interest(self.me, socket, interest);
    }

    /// Blocks a participant that has a thread of its own. Returns at once otherwise: one loop drives all participants,
    /// and calls each when it has input or its time has come.
    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        if let Some(turns) = &self.turns {
            turns.pass(self.me, self.side.virtual_time(until));
        }
        let mut world = self.world.lock();
        let mut sockets = Vec::new();
        world.network.ready(self.me, self.side.now(), |socket, interest| sockets.push((socket, interest)));
        while world.leaves_some && sockets.len() > 1 && world.random.percent(LEFT_PERCENT) {
            let left = world.random.index(sockets.len());
            sockets.swap_remove(left);
        }
        drop(world);
        for (socket, interest) in sockets {
            ready(socket, interest);
        }
    }

    fn interrupted(&mut self) -> bool {
        self.world.lock().members[self.me].interrupted
    }
}
