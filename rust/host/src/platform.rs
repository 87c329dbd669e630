// SPDX-License-Identifier: Apache-2.0
//! Linux under an event loop.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::num::NonZeroU64;
use std::sync::Arc;
use std::time::Duration;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{Interest, NetError, Observation, Platform, RandomError, SocketId, Transfer};

use crate::clock::Clock;
use crate::observations::Observations;
use crate::outside::HostOutside;
use crate::sockets::Sockets;
use crate::wake::WakeUp;

/// The clock, the sockets and the wake-up of this process.
#[derive(Debug)]
pub struct Host {
    clock: Clock,
    sockets: Sockets,
    wake_up: Arc<WakeUp>,
    observations: Option<Observations>,
}

impl Host {
    /// Takes over this process: its signals, and this thread's timer slack.
    ///
    /// # Errors
    /// When the system has no descriptor left, or refuses a signal handler.
    pub fn new() -> std::io::Result<Self> {
        // Linux may end a wait 50 µs late to save power; a real-time program would rather not. It is a wish, no need.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let wake_up = WakeUp::of_program()?;
        let sockets = Sockets::new(wake_up.descriptor())?;
        Ok(Self { clock: HostOutside::of_program().clock(), sockets, wake_up, observations: None })
    }
}

impl Host {
    /// From now on writes what the event loop observes into a file.
    pub(crate) fn observe_into(&mut self, observations: Observations) {
        self.observations = Some(observations);
    }
}

impl Platform for Host {
    fn observe(&mut self, observation: Observation) {
        if let Some(observations) = &mut self.observations {
            observations.note(observation);
        }
    }

    fn now(&mut self) -> Instant {
        self.clock.now()
    }

    fn outside(&self) -> &'static dyn Outside {
        HostOutside::of_program()
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        HostOutside::of_program().set_correction(correction);
    }

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        getrandom::fill(buffer).map_err(|error| RandomError(error.raw_os_error().unwrap_or_default()))
    }

    fn connect(&mut self, address: SocketAddrV4) -> Result<SocketId, NetError> {
        self.sockets.connect(address)
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.sockets.connected(socket)
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.sockets.listen(port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.sockets.bind(port)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, SocketAddrV4)>, NetError> {
        self.sockets.receive_from(socket, buffer)
    }

    fn send_to(&mut self, socket: SocketId, to: SocketAddrV4, bytes: &[u8]) -> Result<(), NetError> {
        self.sockets.send_to(socket, to, bytes)
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.sockets.local_port(listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, Ipv4Addr)>, NetError> {
        self.sockets.accept(listener)
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.sockets.read(socket, buffer)
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        self.sockets.write(socket, bytes)
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        self.sockets.shut_down_writing(socket);
    }

    fn close(&mut self, socket: SocketId) {
        self.sockets.close(socket);
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.sockets.set_interest(socket, interest);
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        let time_out = match until {
            Deadline::Now => Some(Duration::ZERO),
            Deadline::Never => None,
            Deadline::At(time) => {
                let left = time.as_nanos().saturating_sub(self.clock.now().as_nanos());
                Some(Duration::from_nanos(u64::try_from(left).unwrap_or(0)))
            }
        };
        if self.sockets.wait(time_out, ready) {
            self.wake_up.clear();
        }
    }

    fn interrupted(&mut self) -> bool {
        self.wake_up.interrupted()
    }
}
