// SPDX-License-Identifier: Apache-2.0
//! The table of a program's sockets, and epoll over all of them.

mod closing;
mod secured;
mod silence;

use std::fmt;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::os::fd::{AsFd, OwnedFd};
use std::time::{Duration, Instant};

use lf_coordination::Tally;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Participant, SocketId, Transfer};
use rustix::event::{Timespec, epoll};
use rustix::io::Errno;
use rustix::net::{AddressFamily, Protocol, RecvFlags, SendFlags, Shutdown, SocketFlags, SocketType, ipproto, sockopt};

use self::closing::Closing;
pub(crate) use self::secured::{Encryption, Secured, SecuredStage, Wire};
use self::silence::Silence;

/// The epoll key of the wake-up descriptor, which is not a socket of the table.
const WAKE_KEY: u64 = u64::MAX;
/// TCP keep-alive: the silence after which a peer is probed, the interval, and the number of failed probes. A board
/// that has halted, or whose cable is out, ends its connections after 40 seconds. Data in transit: see [`silence`].
const KEEPALIVE: (Duration, Duration, u32) = (Duration::from_secs(10), Duration::from_secs(5), 6);
/// The number of events that one wait takes from the kernel; the rest comes with the next wait.
const EVENTS: usize = 256;

/// All sockets of one program.
pub(crate) struct Sockets {
    epoll: OwnedFd,
    places: Vec<SocketPlace>,
    events: Vec<epoll::Event>,
    silence: Silence,
    /// The encryption of its connections, if they are encrypted.
    encryption: Option<Box<dyn Encryption>>,
    /// Encrypted connections with something to read that the system does not know of.
    unread: Vec<SocketId>,
    /// Encrypted connections that this end has closed and the other one has not.
    closing: Closing,
    /// The number of connections that were not secure.
    insecure: Tally,
}

#[derive(Debug)]
struct SocketPlace {
    generation: u16,
    socket: Option<Socket>,
}

#[derive(Debug)]
struct Socket {
    descriptor: OwnedFd,
    /// The address family of its calls.
    family: AddressFamily,
    interest: Interest,
    /// The interest that the epoll set has.
    watched: Interest,
    /// Its encryption, if it is an encrypted connection.
    secured: Option<Box<dyn Secured>>,
}

/// The reason why a wait has ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waited {
    /// Whether a socket or the wake-up is ready, or a signal has come.
    pub(crate) came: bool,
    /// Whether the wake-up is ready.
    pub(crate) woken: bool,
}

impl fmt::Debug for Sockets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sockets").field("epoll", &self.epoll).field("places", &self.places).finish_non_exhaustive()
    }
}

impl Sockets {
    /// Returns an empty table whose waits also end when `wake` becomes readable.
    ///
    /// # Errors
    /// When the system has no descriptor left.
    pub(crate) fn new(wake: &impl AsFd) -> std::io::Result<Self> {
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        epoll::add(&epoll, wake, epoll::EventData::new_u64(WAKE_KEY), epoll::EventFlags::IN)?;
        // A kernel before 5.11, or a sandbox, may not know the call that waits. Better to learn it here than in a loop.
        let mut none: [epoll::Event; 1] =
            [epoll::Event { flags: epoll::EventFlags::empty(), data: epoll::EventData::new_u64(0) }];
        match epoll::wait(&epoll, &mut none[..], Some(&Timespec { tv_sec: 0, tv_nsec: 0 })) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(errno) => return Err(errno.into()),
        }
        Ok(Self {
            epoll,
            places: Vec::new(),
            events: Vec::with_capacity(EVENTS),
            silence: Silence::new(Instant::now()),
            encryption: None,
            unread: Vec::new(),
            closing: Closing::default(),
            insecure: Tally::NOTHING,
        })
    }

    /// Encrypts all connections from now on.
    #[cfg(feature = "tls")]
    pub(crate) fn encrypt(&mut self, encryption: Box<dyn Encryption>) {
        self.encryption = Some(encryption);
    }

    /// See [`lf_runtime::platform::Platform::connect`].
    pub(crate) fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        let family = match address.ip {
            IpAddress::V4(_) => AddressFamily::INET,
            IpAddress::V6(..) => AddressFamily::INET6,
        };
        let descriptor = open(family, SocketType::STREAM, ipproto::TCP)?;
        set_up_connection(&descriptor)?;
        match rustix::net::connect(&descriptor, &SocketAddr::from(address)) {
            Ok(()) | Err(Errno::INPROGRESS) => {
                let secured = secured(self.encryption.as_deref(), |it| it.connecting())?;
                self.insert(descriptor, family, secured)
            }
            Err(errno) => Err(error(errno)),
        }
    }

    /// See [`lf_runtime::platform::Platform::connected`].
    pub(crate) fn connected(&self, id: SocketId) -> Result<(), NetError> {
        let descriptor = self.descriptor(id)?;
        sockopt::socket_error(descriptor).map_err(error)?.map_err(error)?;
        // If no process listens on a port of this computer, TCP can connect a socket with itself.
        let own = rustix::net::getsockname(descriptor).map_err(error)?;
        let peer = rustix::net::getpeername(descriptor).map_err(error)?;
        if Some(own) == peer {
            return Err(NetError::Refused);
        }
        match self.socket(id)?.secured.as_ref().map(|secured| secured.stage()) {
            Some(SecuredStage::Failed) => Err(NetError::Insecure),
            _ => Ok(()),
        }
    }

    /// See [`lf_runtime::platform::Platform::listen`].
    pub(crate) fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        let (descriptor, family) = open_for_all(SocketType::STREAM, ipproto::TCP)?;
        sockopt::set_socket_reuseaddr(&descriptor, true).map_err(error)?;
        rustix::net::bind(&descriptor, &any_address(family, port)).map_err(error)?;
        rustix::net::listen(&descriptor, 1024).map_err(error)?;
        self.insert(descriptor, family, None)
    }

    /// See [`lf_runtime::platform::Platform::bind`].
    pub(crate) fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        let (descriptor, family) = open_for_all(SocketType::DGRAM, ipproto::UDP)?;
        rustix::net::bind(&descriptor, &any_address(family, port)).map_err(error)?;
        self.insert(descriptor, family, None)
    }

    /// See [`lf_runtime::platform::Platform::receive_from`].
    pub(crate) fn receive_from(&self, id: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        let descriptor = self.descriptor(id)?;
        loop {
            return match rustix::net::recvfrom(descriptor, &mut *buffer, RecvFlags::empty()) {
                Ok((count, _, from)) => match from.map(SocketAddr::try_from) {
                    Some(Ok(from)) => Ok(Some((count, from.into()))),
                    // The socket is one of IP, so there is no such datagram.
                    _ => continue,
                },
                Err(Errno::INTR) => continue,
                Err(Errno::AGAIN) => Ok(None),
                Err(errno) => Err(error(errno)),
            };
        }
    }

    /// See [`lf_runtime::platform::Platform::send_to`].
    pub(crate) fn send_to(&self, id: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        let socket = self.socket(id)?;
        let to = match (to.ip, socket.family) {
            (IpAddress::V4(ip), AddressFamily::INET6) => SocketAddr::new(ip.to_ipv6_mapped().into(), to.port),
            _ => to.into(),
        };
        rustix::net::sendto(&socket.descriptor, bytes, SendFlags::NOSIGNAL, &to).map_err(error)?;
        Ok(())
    }

    /// See [`lf_runtime::platform::Platform::local_port`].
    pub(crate) fn local_port(&self, id: SocketId) -> Result<u16, NetError> {
        let address = rustix::net::getsockname(self.descriptor(id)?).map_err(error)?;
        SocketAddr::try_from(address).map(|address| address.port()).map_err(error)
    }

    /// See [`lf_runtime::platform::Platform::accept`].
    pub(crate) fn accept(&mut self, id: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
        let listener = self.socket(id)?;
        let family = listener.family;
        let (descriptor, peer) = match rustix::net::acceptfrom_with(&listener.descriptor, flags) {
            Ok(accepted) => accepted,
            Err(Errno::AGAIN | Errno::INTR | Errno::CONNABORTED) => return Ok(None),
            Err(errno) => return Err(error(errno)),
        };
        set_up_connection(&descriptor)?;
        let peer = match peer.map(SocketAddr::try_from) {
            Some(Ok(address)) => Endpoint::from(address).ip,
            _ => IpAddress::UNSPECIFIED,
        };
        let secured = secured(self.encryption.as_deref(), |it| it.accepting())?;
        Ok(Some((self.insert(descriptor, family, secured)?, peer)))
    }

    /// See [`lf_runtime::platform::Platform::read`].
    pub(crate) fn read(&mut self, id: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        let Socket { descriptor, secured, .. } = self.socket_mut(id)?;
        let Some(secured) = secured else {
            return transfer(|| rustix::net::recv(&*descriptor, &mut *buffer, RecvFlags::empty()).map(|(_, n)| n));
        };
        let outcome = secured.read(&mut Wire(descriptor), buffer);
        self.settle(id, outcome)
    }

    /// See [`lf_runtime::platform::Platform::write`].
    pub(crate) fn write(&mut self, id: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        let Socket { descriptor, secured, .. } = self.socket_mut(id)?;
        let Some(secured) = secured else {
            return transfer(|| rustix::net::send(&*descriptor, bytes, SendFlags::NOSIGNAL));
        };
        let outcome = secured.write(&mut Wire(descriptor), bytes);
        self.settle(id, outcome)
    }

    /// See [`lf_runtime::platform::Platform::require`].
    pub(crate) fn require(&mut self, id: SocketId, participant: Participant) {
        if let Ok(Socket { secured: Some(secured), .. }) = self.socket_mut(id) {
            secured.require(participant);
        }
    }

    /// See [`lf_runtime::platform::Platform::may_be`].
    pub(crate) fn may_be(&self, id: SocketId, participant: Participant) -> bool {
        self.socket(id).is_ok_and(|socket| socket.secured.as_ref().is_none_or(|secured| secured.may_be(participant)))
    }

    /// See [`lf_runtime::platform::Platform::failure`].
    pub(crate) fn failure(&self, id: SocketId) -> Option<NetError> {
        let stage = self.socket(id).ok()?.secured.as_ref()?.stage();
        (stage == SecuredStage::Failed).then_some(NetError::Insecure)
    }

    /// Logs the reason why an encrypted connection is of no use, and waits from now on for what it needs.
    fn settle(
        &mut self,
        id: SocketId,
        outcome: Result<Result<Transfer, NetError>, String>,
    ) -> Result<Transfer, NetError> {
        self.watch(id);
        self.note_unread(id);
        outcome.unwrap_or_else(|reason| {
            self.report_insecure(id, &reason);
            Err(NetError::Insecure)
        })
    }

    /// Notes that the system will not report what an encrypted connection has to read.
    fn note_unread(&mut self, id: SocketId) {
        if let Ok(Socket { secured: Some(secured), .. }) = self.socket_mut(id)
            && secured.has_more()
            && !self.unread.contains(&id)
        {
            self.unread.push(id);
        }
    }

    fn report_insecure(&mut self, id: SocketId, reason: &str) {
        let times = self.insecure.count();
        if !times.is_logged() {
            return;
        }
        let peer = self.descriptor(id).ok().and_then(|descriptor| rustix::net::getpeername(descriptor).ok().flatten());
        match peer.map(SocketAddr::try_from) {
            Some(Ok(peer)) => log::error!("the connection with {peer} is not secure: {reason}{times}"),
            _ => log::error!("a connection is not secure: {reason}{times}"),
        }
    }

    /// See [`lf_runtime::platform::Platform::shut_down_writing`].
    pub(crate) fn shut_down_writing(&mut self, id: SocketId) {
        if let Ok(Socket { descriptor, secured, .. }) = self.socket_mut(id) {
            if let Some(secured) = secured {
                secured.close(&mut Wire(descriptor));
            }
            // It fails only when the connection is gone already, as requested.
            let _ = rustix::net::shutdown(&*descriptor, Shutdown::Write);
        }
    }

    /// See [`lf_runtime::platform::Platform::close`].
    pub(crate) fn close(&mut self, id: SocketId) {
        if let Some(place) = self.places.get_mut(usize::from(id.index))
            && place.generation == id.generation
            && let Some(Socket { descriptor, secured, .. }) = place.socket.take()
        {
            // Closing a descriptor also removes it from the epoll set.
            place.generation = place.generation.wrapping_add(1);
            if let Some(mut secured) = secured {
                secured.close(&mut Wire(&descriptor));
                if secured.stage() == SecuredStage::Open {
                    self.closing.add(&self.epoll, descriptor);
                }
            }
        }
    }

    /// See [`lf_runtime::platform::Platform::set_interest`].
    pub(crate) fn set_interest(&mut self, id: SocketId, interest: Interest) {
        if let Ok(socket) = self.socket_mut(id) {
            socket.interest = interest;
            self.watch(id);
        }
    }

    /// Makes the epoll set wait for what a socket needs for its interest.
    fn watch(&mut self, id: SocketId) {
        let Some(SocketPlace { generation, socket: Some(socket) }) = self.places.get_mut(usize::from(id.index)) else {
            return;
        };
        let wanted = match &socket.secured {
            // Room means nothing before the handshake is over, and it may need what comes.
            Some(secured) if secured.stage() == SecuredStage::Handshake && socket.interest != Interest::NONE => {
                Interest { readable: true, writable: secured.wants_write() }
            }
            _ => socket.interest,
        };
        if *generation != id.generation || socket.watched == wanted {
            return;
        }
        // None of the three can fail: the descriptor is open, and in the set exactly when there is an interest. Without
        // one it is removed, because epoll would report a broken connection again and again.
        let _ = match (socket.watched, wanted) {
            (Interest::NONE, _) => epoll::add(&self.epoll, &socket.descriptor, key(id), flags(wanted)),
            (_, Interest::NONE) => epoll::delete(&self.epoll, &socket.descriptor),
            (_, _) => epoll::modify(&self.epoll, &socket.descriptor, key(id), flags(wanted)),
        };
        socket.watched = wanted;
    }

    /// Waits until `time_out` has passed, a socket is ready or the wake-up is.
    pub(crate) fn wait(&mut self, time_out: Option<Duration>, ready: &mut dyn FnMut(SocketId, Interest)) -> Waited {
        let time_out = if self.close_silent() {
            Some(time_out.unwrap_or(silence::CHECK_INTERVAL).min(silence::CHECK_INTERVAL))
        } else {
            time_out
        };
        let has_unread = self.take_unread(ready);
        let time_out = if has_unread { Some(Duration::ZERO) } else { time_out };
        // A time that no timespec holds is as good as no limit.
        let time_out = time_out.and_then(|time_out| Timespec::try_from(time_out).ok());
        self.events.clear();
        let spare = rustix::buffer::spare_capacity(&mut self.events);
        // Only an interruption by a signal can make it fail, and then nothing is ready.
        if epoll::wait(&self.epoll, spare, time_out.as_ref()).is_err() {
            return Waited { came: true, woken: false };
        }
        let mut woken = false;
        for index in 0..self.events.len() {
            // The fields of a packed struct have to be copied before they are used.
            let (data, flags) = (self.events[index].data, self.events[index].flags);
            if data.u64() == WAKE_KEY {
                woken = true;
                continue;
            }
            if self.closing.go_on(data.u64()) {
                continue;
            }
            let failed = flags.intersects(epoll::EventFlags::ERR | epoll::EventFlags::HUP);
            let interest = Interest {
                readable: failed || flags.contains(epoll::EventFlags::IN),
                writable: failed || flags.contains(epoll::EventFlags::OUT),
            };
            let id = from_key(data.u64());
            if self.is_open(id) {
                ready(id, interest);
            }
        }
        Waited { came: has_unread || !self.events.is_empty(), woken }
    }

    /// Reports encrypted connections with something to read that the system does not know of. Returns whether there
    /// are any.
    fn take_unread(&mut self, ready: &mut dyn FnMut(SocketId, Interest)) -> bool {
        if self.unread.is_empty() {
            return false;
        }
        let unread = std::mem::take(&mut self.unread);
        let (due, others) = unread
            .into_iter()
            .filter(|id| self.socket(*id).is_ok())
            .partition(|id: &SocketId| self.socket(*id).is_ok_and(|socket| socket.interest.readable));
        let due: Vec<SocketId> = due;
        self.unread = others;
        for id in &due {
            ready(*id, Interest::READ);
        }
        !due.is_empty()
    }

    /// Goes on with the handshake of an encrypted connection. Returns whether the event loop can use the connection, or
    /// has to know that it cannot.
    fn is_open(&mut self, id: SocketId) -> bool {
        let Ok(Socket { descriptor, secured: Some(secured), .. }) = self.socket_mut(id) else { return true };
        if secured.stage() != SecuredStage::Handshake {
            return true;
        }
        let outcome = secured.handshake(&mut Wire(descriptor));
        let is_open = secured.stage() != SecuredStage::Handshake;
        if let Err(reason) = outcome {
            self.report_insecure(id, &reason);
        }
        self.watch(id);
        self.note_unread(id);
        is_open
    }

    /// Ends connections whose peers are gone, which the event loop sees like any other end. Returns whether there are
    /// connections to check again.
    fn close_silent(&mut self) -> bool {
        let mut sockets = self.places.iter().filter_map(|place| place.socket.as_ref()).peekable();
        if sockets.peek().is_none() {
            return false;
        }
        let now = Instant::now();
        let gone = self.silence.poll(now);
        if !gone.is_empty() {
            for socket in sockets {
                if inode(&socket.descriptor).is_some_and(|inode| gone.contains(&inode)) {
                    // It fails only when the connection has ended already.
                    let _ = rustix::net::shutdown(&socket.descriptor, Shutdown::Both);
                }
            }
        }
        true
    }

    fn descriptor(&self, id: SocketId) -> Result<&OwnedFd, NetError> {
        self.socket(id).map(|socket| &socket.descriptor)
    }

    fn socket(&self, id: SocketId) -> Result<&Socket, NetError> {
        match self.places.get(usize::from(id.index)) {
            Some(SocketPlace { generation, socket: Some(socket) }) if *generation == id.generation => Ok(socket),
            _ => Err(NetError::Stale),
        }
    }

    fn socket_mut(&mut self, id: SocketId) -> Result<&mut Socket, NetError> {
        match self.places.get_mut(usize::from(id.index)) {
            Some(SocketPlace { generation, socket: Some(socket) }) if *generation == id.generation => Ok(socket),
            _ => Err(NetError::Stale),
        }
    }

    fn insert(
        &mut self,
        descriptor: OwnedFd,
        family: AddressFamily,
        secured: Option<Box<dyn Secured>>,
    ) -> Result<SocketId, NetError> {
        let free = self.places.iter().position(|place| place.socket.is_none());
        let index = free.unwrap_or(self.places.len());
        let id_index = u16::try_from(index).map_err(|_| NetError::NoSocketLeft)?;
        if free.is_none() {
            self.places.push(SocketPlace { generation: 0, socket: None });
        }
        let place = &mut self.places[index];
        let id = SocketId { index: id_index, generation: place.generation };
        place.socket = Some(Socket { descriptor, family, interest: Interest::NONE, watched: Interest::NONE, secured });
        Ok(id)
    }
}

/// Returns one end of an encrypted connection, if connections are encrypted.
fn secured(
    encryption: Option<&dyn Encryption>,
    end: fn(&dyn Encryption) -> Option<Box<dyn Secured>>,
) -> Result<Option<Box<dyn Secured>>, NetError> {
    encryption.map(|encryption| end(encryption).ok_or(NetError::NoSocketLeft)).transpose()
}

/// Messages are collected before they are written, so TCP need not wait for more.
fn set_up_connection(descriptor: &OwnedFd) -> Result<(), NetError> {
    let (idle, interval, count) = KEEPALIVE;
    sockopt::set_tcp_nodelay(descriptor, true).map_err(error)?;
    sockopt::set_tcp_keepidle(descriptor, idle).map_err(error)?;
    sockopt::set_tcp_keepintvl(descriptor, interval).map_err(error)?;
    sockopt::set_tcp_keepcnt(descriptor, count).map_err(error)?;
    sockopt::set_socket_keepalive(descriptor, true).map_err(error)
}

/// Returns Linux's number of a socket in its table of connections.
fn inode(descriptor: &OwnedFd) -> Option<u64> {
    rustix::fs::fstat(descriptor).ok().map(|stat| stat.st_ino)
}

/// Opens a socket for any family that this computer has: one of IPv6 that takes IPv4, too, or of IPv4 if there is no
/// other.
fn open_for_all(kind: SocketType, protocol: Protocol) -> Result<(OwnedFd, AddressFamily), NetError> {
    let takes_both = open(AddressFamily::INET6, kind, protocol).and_then(|descriptor| {
        sockopt::set_ipv6_v6only(&descriptor, false).map_err(error)?;
        Ok((descriptor, AddressFamily::INET6))
    });
    takes_both.or_else(|_| Ok((open(AddressFamily::INET, kind, protocol)?, AddressFamily::INET)))
}

/// Returns the address that stands for all addresses of this computer.
fn any_address(family: AddressFamily, port: u16) -> SocketAddr {
    if family == AddressFamily::INET6 {
        SocketAddr::from((Ipv6Addr::UNSPECIFIED, port))
    } else {
        SocketAddr::from((Ipv4Addr::UNSPECIFIED, port))
    }
}

fn open(family: AddressFamily, kind: SocketType, protocol: Protocol) -> Result<OwnedFd, NetError> {
    let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
    rustix::net::socket_with(family, kind, flags, Some(protocol)).map_err(error)
}

fn transfer(mut call: impl FnMut() -> Result<usize, Errno>) -> Result<Transfer, NetError> {
    loop {
        return match call() {
            Ok(0) => Ok(Transfer::Closed),
            Ok(count) => Ok(Transfer::Bytes(count)),
            Err(Errno::INTR) => continue,
            Err(Errno::AGAIN) => Ok(Transfer::WouldBlock),
            Err(errno) => Err(error(errno)),
        };
    }
}

fn key(id: SocketId) -> epoll::EventData {
    epoll::EventData::new_u64(u64::from(id.index) << 16 | u64::from(id.generation))
}

#[allow(clippy::cast_possible_truncation, reason = "the key was made of two u16")]
fn from_key(key: u64) -> SocketId {
    SocketId { index: (key >> 16) as u16, generation: key as u16 }
}

fn flags(interest: Interest) -> epoll::EventFlags {
    let mut flags = epoll::EventFlags::empty();
    flags.set(epoll::EventFlags::IN, interest.readable);
    flags.set(epoll::EventFlags::OUT, interest.writable);
    flags
}

fn error(errno: Errno) -> NetError {
    match errno {
        Errno::CONNREFUSED => NetError::Refused,
        Errno::CONNRESET | Errno::PIPE | Errno::TIMEDOUT | Errno::CONNABORTED => NetError::Reset,
        Errno::NETUNREACH | Errno::HOSTUNREACH | Errno::NETDOWN | Errno::HOSTDOWN => NetError::Unreachable,
        Errno::ADDRINUSE => NetError::AddressInUse,
        Errno::MFILE | Errno::NFILE | Errno::NOBUFS | Errno::NOMEM => NetError::NoSocketLeft,
        other => NetError::Os(other.raw_os_error()),
    }
}

#[cfg(test)]
mod tests;
