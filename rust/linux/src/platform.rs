// SPDX-License-Identifier: Apache-2.0
//! Linux as the platform of an event loop.

use std::num::NonZeroU64;
use std::sync::Arc;
use std::time::Duration;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{
    Endpoint, Interest, IpAddress, NetError, Participant, Platform, RandomError, SocketId, Transfer,
};

use crate::adaptive_spin::{AdaptiveSpin, SpinOutcome, spin_until};
use crate::clock::Clock;
use crate::outside::HostOutside;
use crate::sockets::{Sockets, Waited};
use crate::wake::WakeUp;

/// The clock, the sockets and the wake-up of this process.
#[derive(Debug)]
pub struct Linux {
    clock: Clock,
    sockets: Sockets,
    wake_up: Arc<WakeUp>,
    spin: AdaptiveSpin,
}

impl Linux {
    /// Takes over this process: its signals, and this thread's timer slack.
    ///
    /// # Errors
    /// When the system has no descriptor left, or refuses a signal handler.
    pub fn new() -> std::io::Result<Self> {
        // Linux may end a wait 50 µs late to save power, which a real-time program cannot use. A failure does no harm.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let wake_up = WakeUp::of_program()?;
        let sockets = Sockets::new(wake_up.descriptor())?;
        Ok(Self { clock: HostOutside::of_program().clock(), sockets, wake_up, spin: AdaptiveSpin::default() })
    }
}

impl Linux {
    /// Encrypts all connections from now on.
    #[cfg(feature = "tls")]
    pub(crate) fn encrypt(&mut self, encryption: Box<dyn crate::sockets::Encryption>) {
        self.sockets.encrypt(encryption);
    }

    /// Returns the time left until `time`.
    fn until(&self, time: Instant) -> Duration {
        let left = time.as_nanos().saturating_sub(self.clock.now().as_nanos());
        Duration::from_nanos(u64::try_from(left).unwrap_or(0))
    }

    /// Waits for this long. Returns `true` when something has come.
    fn wait_for(&mut self, time_out: Option<Duration>, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        let Waited { came, woken } = self.sockets.wait(time_out, ready);
        if woken {
            self.wake_up.clear();
        }
        came
    }

    fn spin_until(&mut self, end: std::time::Instant, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        let SpinOutcome { ready: came, preempted } = spin_until(end, || self.wait_for(Some(Duration::ZERO), ready));
        if let Some(lost) = preempted {
            self.spin.record_preemption(std::time::Instant::now(), lost);
        }
        came
    }

    fn sleep_until(&mut self, end: Option<std::time::Instant>, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        let left = end.map(|end| end.saturating_duration_since(std::time::Instant::now()));
        self.wait_for(left, ready)
    }
}

impl Platform for Linux {
    fn now(&mut self) -> Instant {
        HostOutside::of_program().read()
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

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
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

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        self.sockets.receive_from(socket, buffer)
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.sockets.send_to(socket, to, bytes)
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.sockets.local_port(listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        self.sockets.accept(listener)
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.sockets.read(socket, buffer)
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        self.sockets.write(socket, bytes)
    }

    fn require(&mut self, socket: SocketId, participant: Participant) {
        self.sockets.require(socket, participant);
    }

    fn may_be(&self, socket: SocketId, participant: Participant) -> bool {
        self.sockets.may_be(socket, participant)
    }

    fn failure(&self, socket: SocketId) -> Option<NetError> {
        self.sockets.failure(socket)
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

    fn expect(&mut self, time: Deadline) {
        self.spin.expect(match time {
            Deadline::At(time) => Some(std::time::Instant::now() + self.until(time)),
            Deadline::Now | Deadline::Never => None,
        });
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        let begin = std::time::Instant::now();
        let end = match until {
            Deadline::Now => {
                self.wait_for(Some(Duration::ZERO), ready);
                return;
            }
            Deadline::Never => None,
            // In virtual time nobody waits: what others have already done comes first.
            Deadline::At(time) if self.clock.is_virtual() => {
                if !self.wait_for(Some(Duration::ZERO), ready) {
                    self.clock.skip_to(time);
                }
                return;
            }
            // A time that is too far away for the system's type is as good as no limit.
            Deadline::At(time) => begin.checked_add(self.until(time)),
        };
        let plan = self.spin.plan(begin, end);
        let mut came = plan.first.is_some_and(|end| self.spin_until(end, ready));
        if let Some((wake, end)) = plan.second.filter(|_| !came) {
            came = self.sleep_until(Some(wake), ready);
            let now = std::time::Instant::now();
            if !came && now < wake {
                // A wake-up for the check of silent connections; the expected event is still to come.
                return;
            }
            if !came {
                self.spin.record_lateness(wake.max(begin), now);
            }
            came = came || self.spin_until(end, ready);
        }
        came = came || self.sleep_until(end, ready);
        self.spin.record(&plan, std::time::Instant::now(), came);
    }

    fn interrupted(&mut self) -> bool {
        self.wake_up.interrupted()
    }
}
