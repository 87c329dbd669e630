// SPDX-License-Identifier: Apache-2.0
//! Zephyr as the platform of the event loop.

use core::ffi::c_int;
use core::sync::atomic::{AtomicBool, Ordering};

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::{Instant, Interval};
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};
use lf_runtime::{FederateEvent, report};

use log::Level;

use crate::kconfig::LF_SOCKETS;
use crate::net::{self, Descriptor};
use crate::outside::ZephyrOutside;
use crate::{clock, pause, raw, wake};

/// The pause before output is tried again that had no buffers.
const RETRY_NS: i64 = 200_000;

const READABLE: u32 = raw::ZSOCK_POLLIN;
const WRITABLE: u32 = raw::ZSOCK_POLLOUT;
const BROKEN: u32 = raw::ZSOCK_POLLERR | raw::ZSOCK_POLLHUP | raw::ZSOCK_POLLNVAL;

/// [`Platform`] for Zephyr: `SOCKETS` sockets, and the program's wake-up.
///
/// One program has one; a second one would share the wake-up. An RTI beside it has one without a wake-up.
#[derive(Debug)]
pub struct ZephyrPlatform<const SOCKETS: usize = LF_SOCKETS> {
    places: [SocketPlace; SOCKETS],
    /// The descriptor of the wake-up; negative if there is none, which a poll ignores.
    wake: c_int,
}

#[derive(Debug, Default)]
struct SocketPlace {
    generation: u16,
    socket: Option<Socket>,
}

#[derive(Debug)]
struct Socket {
    descriptor: Descriptor,
    interest: Interest,
    /// The port, if it listens or takes datagrams.
    port: Option<u16>,
    /// Whether Zephyr had no buffers for output. It does not report when it has some again.
    lacks_buffers: bool,
}

impl<const SOCKETS: usize> ZephyrPlatform<SOCKETS> {
    /// Returns the platform of the program, without sockets.
    ///
    /// # Errors
    /// When there is no descriptor left for the wake-up.
    pub fn new() -> Result<Self, NetError> {
        Ok(Self { wake: wake::descriptor()?, ..Self::without_wake() })
    }

    /// Returns a platform without sockets that only its sockets and the time wake.
    pub(crate) const fn without_wake() -> Self {
        Self { places: [const { SocketPlace { generation: 0, socket: None } }; SOCKETS], wake: -1 }
    }

    fn has_place(&self) -> bool {
        self.places.iter().any(|place| place.socket.is_none())
    }

    fn insert(&mut self, descriptor: Descriptor, port: Option<u16>) -> Result<SocketId, NetError> {
        let free = (0..).zip(&mut self.places).find(|(_, place)| place.socket.is_none());
        let (index, place) = free.ok_or(NetError::NoSocketLeft)?;
        place.socket = Some(Socket { descriptor, interest: Interest::NONE, port, lacks_buffers: false });
        Ok(SocketId { index, generation: place.generation })
    }

    fn place(&mut self, id: SocketId) -> Option<&mut SocketPlace> {
        self.places.get_mut(usize::from(id.index)).filter(|place| place.generation == id.generation)
    }

    fn socket(&mut self, id: SocketId) -> Result<&mut Socket, NetError> {
        self.place(id).and_then(|place| place.socket.as_mut()).ok_or(NetError::Stale)
    }

    /// Reports sockets as writable again that had no buffers.
    fn retry(&mut self, ready: &mut dyn FnMut(SocketId, Interest)) {
        for (index, place) in (0..).zip(&mut self.places) {
            if let Some(socket) = &mut place.socket
                && core::mem::take(&mut socket.lacks_buffers)
                && socket.interest.writable
            {
                ready(SocketId { index, generation: place.generation }, Interest::WRITE);
            }
        }
    }

    /// Calls `ready` for each ready socket, after waiting for this many ticks; returns whether there was one.
    fn poll(&self, timeout_ticks: i64, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        // Negative descriptors are ignored.
        const NOTHING: raw::zvfs_pollfd = raw::zvfs_pollfd { fd: -1, events: 0, revents: 0 };
        let wake = raw::zvfs_pollfd { fd: self.wake, events: bits(READABLE), revents: 0 };
        let mut set = Set { sockets: [NOTHING; SOCKETS], wake };
        for (entry, place) in set.sockets.iter_mut().zip(&self.places) {
            if let Some(Socket { descriptor, interest, lacks_buffers, .. }) = &place.socket
                && *interest != Interest::NONE
            {
                entry.fd = descriptor.number();
                let readable = if interest.readable { READABLE } else { 0 };
                let writable = if interest.writable && !lacks_buffers { WRITABLE } else { 0 };
                entry.events = bits(readable | writable);
            }
        }
        if net::poll(set.entries(), timeout_ticks) == 0 {
            return false;
        }
        if set.wake.revents != 0 {
            wake::clear(self.wake);
        }
        for (index, (entry, place)) in (0..).zip(set.sockets.iter().zip(&self.places)) {
            let shows = |condition: u32| entry.revents & bits(condition | BROKEN) != 0;
            let is = Interest { readable: shows(READABLE), writable: shows(WRITABLE) };
            if entry.fd >= 0 && is != Interest::NONE {
                ready(SocketId { index, generation: place.generation }, is);
            }
        }
        true
    }
}

/// The descriptors that are polled at once.
#[repr(C)]
struct Set<const SOCKETS: usize> {
    sockets: [raw::zvfs_pollfd; SOCKETS],
    wake: raw::zvfs_pollfd,
}

impl<const SOCKETS: usize> Set<SOCKETS> {
    /// Returns all entries as a slice; their number is not a constant expression, so they cannot be one array.
    fn entries(&mut self) -> &mut [raw::zvfs_pollfd] {
        // SAFETY: the layout is that of C, and it consists of entries of one type, so nothing is between them. The
        // slice borrows the whole structure.
        unsafe { core::slice::from_raw_parts_mut((&raw mut *self).cast(), SOCKETS + 1) }
    }
}

impl<const SOCKETS: usize> Platform for ZephyrPlatform<SOCKETS> {
    const DATAGRAMS: bool = cfg!(CONFIG_NET_UDP);
    const NAMES: bool = false;
    // A small board takes hundreds of microseconds to read and to write.
    const TURN_TIME: Interval = Interval::from_millis(2);

    fn now(&mut self) -> Instant {
        clock::now()
    }

    fn outside(&self) -> &'static dyn Outside {
        ZephyrOutside::of_program()
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        ZephyrOutside::of_program().set_correction(correction);
    }

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        // SAFETY: the pointer is valid for as many bytes, and C only writes them.
        match unsafe { raw::lf_random(buffer.as_mut_ptr(), buffer.len()) } {
            0 => Ok(()),
            error => Err(RandomError(error)),
        }
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        if !self.has_place() {
            return Err(NetError::NoSocketLeft);
        }
        self.insert(Descriptor::connect(address)?, None)
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.socket(socket)?.descriptor.connected()
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        if !self.has_place() {
            return Err(NetError::NoSocketLeft);
        }
        let (descriptor, port) = Descriptor::listen(port, SOCKETS)?;
        self.insert(descriptor, Some(port))
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        if !self.has_place() {
            return Err(NetError::NoSocketLeft);
        }
        let (descriptor, port) = Descriptor::datagrams(port)?;
        self.insert(descriptor, Some(port))
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        self.socket(socket)?.descriptor.receive_from(buffer)
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.socket(socket)?.descriptor.send_to(to, bytes)
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.socket(listener)?.port.ok_or(NetError::Stale)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let has_place = self.has_place();
        let descriptor = &self.socket(listener)?.descriptor;
        if !has_place {
            // Accepting would take a connection that then had to be closed; so this only checks whether there is one.
            let mut set = [raw::zvfs_pollfd { fd: descriptor.number(), events: bits(READABLE), revents: 0 }];
            return if net::poll(&mut set, 0) == 0 { Ok(None) } else { Err(NetError::NoSocketLeft) };
        }
        match descriptor.accept()? {
            Some((descriptor, peer)) => Ok(Some((self.insert(descriptor, None)?, peer))),
            None => Ok(None),
        }
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.socket(socket)?.descriptor.read(buffer)
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        let socket = self.socket(socket)?;
        match socket.descriptor.write(bytes) {
            // The socket is open, so it is buffers that are missing.
            Err(NetError::NoSocketLeft) => {
                socket.lacks_buffers = true;
                report_missing_buffers();
                Ok(Transfer::WouldBlock)
            }
            result => result,
        }
    }

    /// `native_sim`'s offloaded sockets have no such call: there the peer sees the end when the socket is closed.
    fn shut_down_writing(&mut self, socket: SocketId) {
        if let Ok(socket) = self.socket(socket) {
            socket.descriptor.shut_down_writing();
        }
    }

    fn close(&mut self, socket: SocketId) {
        if let Some(place) = self.place(socket)
            && place.socket.take().is_some()
        {
            place.generation = place.generation.wrapping_add(1);
        }
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        if let Ok(socket) = self.socket(socket) {
            socket.interest = interest;
        }
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        let lacks_buffers = |place: &SocketPlace| place.socket.as_ref().is_some_and(|socket| socket.lacks_buffers);
        let longest_ns = if self.places.iter().any(lacks_buffers) { RETRY_NS } else { i64::MAX };
        pause::until(until, longest_ns, &mut |ticks| self.poll(ticks, ready));
        self.retry(ready);
    }
}

/// Logs once that output waits for buffers; the user can configure more.
fn report_missing_buffers() {
    static TOLD: AtomicBool = AtomicBool::new(false);
    if !TOLD.swap(true, Ordering::Relaxed) {
        report(Level::Warn, &FederateEvent::NoBuffers);
    }
}

/// Converts flags to the type of the poll structure; they are all below 2¹⁵.
#[allow(clippy::cast_possible_truncation, reason = "see above")]
const fn bits(flags: u32) -> i16 {
    (flags as u16).cast_signed()
}
