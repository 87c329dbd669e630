// SPDX-License-Identifier: Apache-2.0
//! The world as an event loop's platform.

use std::cell::RefCell;
use std::rc::Rc;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};

use super::Network;
use super::side::Side;

/// One participant's view of the world.
#[derive(Debug)]
pub(crate) struct Virtual {
    pub(crate) network: Rc<RefCell<Network>>,
    /// Its number; the RTI is 0.
    pub(crate) me: usize,
    pub(crate) side: &'static Side,
    pub(crate) interrupted: Rc<RefCell<Vec<bool>>>,
}

impl Platform for Virtual {
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
        self.network.borrow_mut().medium_mut().random_bytes(buffer);
        Ok(())
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        self.network.borrow_mut().connect(self.me, address, self.side.now())
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.network.borrow_mut().connected(self.me, socket, self.side.now())
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.network.borrow_mut().listen(self.me, port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.network.borrow_mut().bind(self.me, port)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        self.network.borrow_mut().receive_from(self.me, socket, buffer, self.side.now())
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.network.borrow_mut().send_to(self.me, socket, to, bytes, self.side.now())
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.network.borrow_mut().local_port(self.me, listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        self.network.borrow_mut().accept(self.me, listener, self.side.now())
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.network.borrow_mut().read(self.me, socket, buffer, self.side.now())
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        self.network.borrow_mut().write(self.me, socket, bytes, self.side.now())
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        self.network.borrow_mut().shut_down_writing(self.me, socket, self.side.now());
    }

    fn close(&mut self, socket: SocketId) {
        self.network.borrow_mut().close(self.me, socket, self.side.now());
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.network.borrow_mut().set_interest(self.me, socket, interest);
    }

    /// Never waits: who drives the loop calls it when there is something, or the time has come.
    fn wait(&mut self, _until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        self.network.borrow().ready(self.me, self.side.now(), ready);
    }

    fn interrupted(&mut self) -> bool {
        self.interrupted.borrow()[self.me]
    }
}
