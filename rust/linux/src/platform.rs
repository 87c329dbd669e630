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
use crate::virtual_network::{self, VirtualNetwork};
use crate::wake::WakeUp;

/// The network of this process.
#[derive(Debug)]
enum Network {
    System(Sockets),
    Virtual(VirtualNetwork),
}

/// Makes a call that both networks have.
macro_rules! network {
    ($self:ident.$call:ident($($argument:expr),*)) => {
        match &mut $self.network {
            Network::System(sockets) => sockets.$call($($argument),*),
            Network::Virtual(network) => network.$call($($argument),*),
        }
    };
}

/// The clock, the sockets and the wake-up of this process.
#[derive(Debug)]
pub struct Linux {
    clock: Clock,
    network: Network,
    wake_up: Arc<WakeUp>,
    spin: AdaptiveSpin,
}

impl Linux {
    /// Takes over this process: its signals, and this thread's timer slack.
    ///
    /// # Errors
    /// When the system has no descriptor left, or refuses a signal handler; or when there is no virtual network where
    /// this process is to take part in one.
    pub fn new() -> std::io::Result<Self> {
        if virtual_network::is_asked_for() {
            HostOutside::begin_virtual_time();
        }
        // Linux may end a wait 50 µs late to save power, which a real-time program cannot use. A failure does no harm.
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let wake_up = WakeUp::of_program()?;
        let clock = HostOutside::of_program().clock();
        let network = if virtual_network::is_asked_for() {
            let (network, time) = VirtualNetwork::begin()?;
            clock.skip_to(time);
            Network::Virtual(network)
        } else {
            Network::System(Sockets::new(wake_up.descriptor())?)
        };
        Ok(Self { clock, network, wake_up, spin: AdaptiveSpin::default() })
    }
}

impl Linux {
    /// Encrypts all connections from now on, which the system makes.
    #[cfg(feature = "tls")]
    pub(crate) fn encrypt(&mut self, encryption: Box<dyn crate::sockets::Encryption>) {
        if let Network::System(sockets) = &mut self.network {
            sockets.encrypt(encryption);
        }
    }

    /// Returns whether this process takes part in a virtual network.
    pub(crate) fn is_virtual(&self) -> bool {
        matches!(self.network, Network::Virtual(_))
    }

    /// Returns the time left until `time`.
    fn until(&self, time: Instant) -> Duration {
        let left = time.as_nanos().saturating_sub(self.clock.now().as_nanos());
        Duration::from_nanos(u64::try_from(left).unwrap_or(0))
    }

    /// Waits for this long. Returns `true` when something has come.
    fn wait_for(&mut self, time_out: Option<Duration>, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        let Network::System(sockets) = &mut self.network else { return true };
        let Waited { came, woken } = sockets.wait(time_out, ready);
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
        if let Network::Virtual(network) = &mut self.network {
            return network.random(buffer);
        }
        getrandom::fill(buffer).map_err(|error| RandomError(error.raw_os_error().unwrap_or_default()))
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        network!(self.connect(address))
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        network!(self.connected(socket))
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        network!(self.listen(port))
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        network!(self.bind(port))
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        network!(self.receive_from(socket, buffer))
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        network!(self.send_to(socket, to, bytes))
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        network!(self.local_port(listener))
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        network!(self.accept(listener))
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        network!(self.read(socket, buffer))
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        network!(self.write(socket, bytes))
    }

    fn require(&mut self, socket: SocketId, participant: Participant) {
        if let Network::System(sockets) = &mut self.network {
            sockets.require(socket, participant);
        }
    }

    fn may_be(&self, socket: SocketId, participant: Participant) -> bool {
        match &self.network {
            Network::System(sockets) => sockets.may_be(socket, participant),
            Network::Virtual(_) => true,
        }
    }

    fn failure(&self, socket: SocketId) -> Option<NetError> {
        match &self.network {
            Network::System(sockets) => sockets.failure(socket),
            Network::Virtual(_) => None,
        }
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        network!(self.shut_down_writing(socket));
    }

    fn close(&mut self, socket: SocketId) {
        network!(self.close(socket));
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        network!(self.set_interest(socket, interest));
    }

    fn expect(&mut self, time: Deadline) {
        self.spin.expect(match time {
            Deadline::At(time) => Some(std::time::Instant::now() + self.until(time)),
            Deadline::Now | Deadline::Never => None,
        });
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        if let Network::Virtual(network) = &mut self.network {
            // What a reaction has scheduled is no less than what a socket has.
            let until = if self.wake_up.clear() { Deadline::Now } else { until };
            if let Some(time) = network.wait(until, ready) {
                self.clock.skip_to(time);
            }
            return;
        }
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
        let is_told = matches!(&self.network, Network::Virtual(network) if network.interrupted());
        is_told || self.wake_up.interrupted()
    }
}
