// SPDX-License-Identifier: Apache-2.0
//! Zephyr as the platform of a program that is not federated: an image without a network.

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};

use crate::outside::ZephyrOutside;
use crate::{clock, pause, raw};

/// [`Platform`] for Zephyr without sockets: only the time and the program's wake-up end a wait.
#[derive(Debug)]
pub struct LocalPlatform(());

/// The result of every call for a socket.
const NONE: NetError = NetError::NoSocketLeft;

impl LocalPlatform {
    /// Returns the platform of the program.
    ///
    /// # Errors
    /// None; a platform with sockets has some.
    #[allow(clippy::unnecessary_wraps, reason = "that of federates can fail")]
    pub fn new() -> Result<Self, NetError> {
        Ok(Self(()))
    }
}

impl Platform for LocalPlatform {
    const DATAGRAMS: bool = false;
    const NAMES: bool = false;

    fn now(&mut self) -> Instant {
        clock::now()
    }

    fn outside(&self) -> &'static dyn Outside {
        ZephyrOutside::of_program()
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        ZephyrOutside::of_program().set_correction(correction);
    }

    fn random(&mut self, _buffer: &mut [u8]) -> Result<(), RandomError> {
        Err(RandomError(0))
    }

    fn connect(&mut self, _address: Endpoint) -> Result<SocketId, NetError> {
        Err(NONE)
    }

    fn connected(&mut self, _socket: SocketId) -> Result<(), NetError> {
        Err(NONE)
    }

    fn listen(&mut self, _port: u16) -> Result<SocketId, NetError> {
        Err(NONE)
    }

    fn bind(&mut self, _port: u16) -> Result<SocketId, NetError> {
        Err(NONE)
    }

    fn receive_from(&mut self, _socket: SocketId, _buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        Err(NONE)
    }

    fn send_to(&mut self, _socket: SocketId, _to: Endpoint, _bytes: &[u8]) -> Result<(), NetError> {
        Err(NONE)
    }

    fn local_port(&mut self, _listener: SocketId) -> Result<u16, NetError> {
        Err(NONE)
    }

    fn accept(&mut self, _listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        Err(NONE)
    }

    fn read(&mut self, _socket: SocketId, _buffer: &mut [u8]) -> Result<Transfer, NetError> {
        Err(NONE)
    }

    fn write(&mut self, _socket: SocketId, _bytes: &[u8]) -> Result<Transfer, NetError> {
        Err(NONE)
    }

    fn shut_down_writing(&mut self, _socket: SocketId) {}

    fn close(&mut self, _socket: SocketId) {}

    fn set_interest(&mut self, _socket: SocketId, _interest: Interest) {}

    fn wait(&mut self, until: Deadline, _ready: &mut dyn FnMut(SocketId, Interest)) {
        // SAFETY: it has no precondition.
        pause::until(until, i64::MAX, &mut |ticks| unsafe { raw::lf_wait_for_wake(ticks) });
    }
}
