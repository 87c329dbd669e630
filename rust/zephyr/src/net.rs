// SPDX-License-Identifier: Apache-2.0
//! Sockets of Zephyr, one call each: descriptors that close themselves, and errors as values.

use core::ffi::{c_int, c_void};

use lf_runtime::platform::{Endpoint, IpAddress, NetError, Transfer};

use crate::address::{ANY_FAMILY, SystemAddress, integer, size_of_in_bytes};
use crate::raw::{self, lf_network_error as error};

/// The ports to try for a listener on "any port" if the network stack does not report which one it has chosen.
const DYNAMIC_PORTS: core::ops::RangeInclusive<u16> = 49_152..=u16::MAX;

const TCP: u32 = raw::net_ip_protocol::IPPROTO_TCP;
const UDP: u32 = raw::net_ip_protocol::IPPROTO_UDP;

/// An open socket, closed when it is dropped.
#[derive(Debug)]
pub(crate) struct Descriptor(c_int);

impl Drop for Descriptor {
    fn drop(&mut self) {
        // SAFETY: it takes any descriptor. It fails only for one that is not open, and this one is open.
        let _ = unsafe { raw::zsock_close(self.0) };
    }
}

impl Descriptor {
    /// Opens a socket whose calls return at once.
    fn open(family: u32, kind: raw::net_sock_type::Type, protocol: u32) -> Result<Self, NetError> {
        // SAFETY: it has no precondition.
        let number = unsafe { raw::zsock_socket(integer(family), integer(kind), integer(protocol)) };
        Self::adopt(number)
    }

    fn adopt(number: c_int) -> Result<Self, NetError> {
        let descriptor = Self(check(number)?);
        // SAFETY: it takes any descriptor.
        let set = unsafe { raw::zsock_fcntl_impl(number, integer(raw::ZVFS_F_SETFL), integer(raw::ZVFS_O_NONBLOCK)) };
        check(set)?;
        Ok(descriptor)
    }

    /// Returns the system's number of it.
    pub(crate) fn number(&self) -> c_int {
        self.0
    }

    /// Begins to connect.
    pub(crate) fn connect(address: Endpoint) -> Result<Self, NetError> {
        let address = SystemAddress::of(address);
        let descriptor = Self::open(address.family(), raw::net_sock_type::SOCK_STREAM, TCP)?;
        descriptor.set_up_connection();
        // SAFETY: pointer and length are those of a local that holds an address.
        let result = unsafe { raw::zsock_connect(descriptor.0, address.as_ptr(), address.length()) };
        match check(result) {
            Err(_) if last_class() == error::LF_NETWORK_IN_PROGRESS => Ok(descriptor),
            result => result.map(|_| descriptor),
        }
    }

    /// Returns the outcome of connecting.
    pub(crate) fn connected(&self) -> Result<(), NetError> {
        let mut outcome: c_int = 0;
        let mut length = size_of_in_bytes::<c_int>();
        // SAFETY: pointer and length are those of a local.
        let result = unsafe {
            let outcome = (&raw mut outcome).cast::<c_void>();
            raw::zsock_getsockopt(self.0, integer(raw::SOL_SOCKET), integer(raw::SO_ERROR), outcome, &raw mut length)
        };
        check(result)?;
        if outcome == 0 { Ok(()) } else { Err(error_of(outcome)) }
    }

    /// Listens on a port, or on any for 0, with room for `waiting` pending connections; returns the port.
    pub(crate) fn listen(port: u16, waiting: usize) -> Result<(Self, u16), NetError> {
        Self::on_port(port, |port| Self::listen_on(port, waiting))
    }

    /// Opens a UDP port, or any for 0; returns the port.
    pub(crate) fn datagrams(port: u16) -> Result<(Self, u16), NetError> {
        Self::on_port(port, Self::datagrams_on)
    }

    fn on_port(port: u16, open: impl Fn(u16) -> Result<Self, NetError>) -> Result<(Self, u16), NetError> {
        let descriptor = open(port)?;
        if port != 0 {
            return Ok((descriptor, port));
        }
        match descriptor.local_port() {
            Ok(port) => return Ok((descriptor, port)),
            Err(_) if last_class() == error::LF_NETWORK_NOT_SUPPORTED => drop(descriptor),
            Err(error) => return Err(error),
        }
        for port in DYNAMIC_PORTS {
            match open(port) {
                Err(NetError::AddressInUse) => {}
                result => return result.map(|descriptor| (descriptor, port)),
            }
        }
        Err(NetError::AddressInUse)
    }

    fn datagrams_on(port: u16) -> Result<Self, NetError> {
        let descriptor = Self::open(ANY_FAMILY, raw::net_sock_type::SOCK_DGRAM, UDP)?;
        descriptor.bind(port)?;
        Ok(descriptor)
    }

    /// Takes a datagram that has come, if there is one.
    pub(crate) fn receive_from(&self, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        let mut address = SystemAddress::room();
        let (sender, length) = address.as_mut_ptrs();
        // SAFETY: pointers and lengths are those of a slice that may be written to, and of a local that has room for an
        // address.
        let count = unsafe { raw::zsock_recvfrom(self.0, buffer.as_mut_ptr().cast(), buffer.len(), 0, sender, length) };
        match usize::try_from(count) {
            Ok(count) => Ok(Some((count, address.endpoint()))),
            Err(_) if matches!(last_class(), error::LF_NETWORK_WOULD_BLOCK | error::LF_NETWORK_INTERRUPTED) => Ok(None),
            Err(_) => Err(last_error()),
        }
    }

    /// Sends a datagram.
    pub(crate) fn send_to(&self, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        let to = SystemAddress::for_any(to);
        // SAFETY: pointers and lengths are those of a slice, and of a local that holds an address.
        let count =
            unsafe { raw::zsock_sendto(self.0, bytes.as_ptr().cast(), bytes.len(), 0, to.as_ptr(), to.length()) };
        if count < 0 { Err(last_error()) } else { Ok(()) }
    }

    fn listen_on(port: u16, waiting: usize) -> Result<Self, NetError> {
        let descriptor = Self::open(ANY_FAMILY, raw::net_sock_type::SOCK_STREAM, TCP)?;
        // A port must be free again as soon as the program before has ended; a stack without the option behaves so
        // anyway.
        descriptor.switch_on(raw::SOL_SOCKET, raw::SO_REUSEADDR);
        descriptor.bind(port)?;
        let waiting = c_int::try_from(waiting).unwrap_or(c_int::MAX);
        // SAFETY: it takes any descriptor.
        check(unsafe { raw::zsock_listen(descriptor.0, waiting) })?;
        Ok(descriptor)
    }

    /// Takes a port of all addresses, of both families where there are both.
    fn bind(&self, port: u16) -> Result<(), NetError> {
        #[cfg(feature = "ipv6")]
        self.set(raw::net_ip_protocol::IPPROTO_IPV6, raw::IPV6_V6ONLY, 0);
        let address = SystemAddress::any(port);
        // SAFETY: pointer and length are those of a local that holds an address.
        check(unsafe { raw::zsock_bind(self.0, address.as_ptr(), address.length()) })?;
        Ok(())
    }

    fn local_port(&self) -> Result<u16, NetError> {
        let mut address = SystemAddress::room();
        let (own, length) = address.as_mut_ptrs();
        // SAFETY: pointer and length are those of a local that has room for an address.
        check(unsafe { raw::zsock_getsockname(self.0, own, length) })?;
        Ok(address.endpoint().port)
    }

    /// Accepts a pending connection, if there is one.
    pub(crate) fn accept(&self) -> Result<Option<(Self, IpAddress)>, NetError> {
        let mut address = SystemAddress::room();
        let (peer, length) = address.as_mut_ptrs();
        // SAFETY: pointer and length are those of a local that has room for an address.
        let number = unsafe { raw::zsock_accept(self.0, peer, length) };
        if number < 0 && matches!(last_class(), error::LF_NETWORK_WOULD_BLOCK | error::LF_NETWORK_INTERRUPTED) {
            return Ok(None);
        }
        let descriptor = Self::adopt(number)?;
        descriptor.set_up_connection();
        Ok(Some((descriptor, address.endpoint().ip)))
    }

    /// Reads what has come.
    pub(crate) fn read(&self, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        // SAFETY: pointer and length are those of a slice that may be written to.
        let count = unsafe { raw::zsock_recv(self.0, buffer.as_mut_ptr().cast(), buffer.len(), 0) };
        transferred(count)
    }

    /// Writes as much as the system takes.
    ///
    /// Returns [`NetError::NoSocketLeft`] if it has no buffers to spare.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<Transfer, NetError> {
        // SAFETY: it has no precondition.
        let room = unsafe { raw::lf_send_room() };
        let bytes = bytes.get(..room).unwrap_or(bytes);
        if bytes.is_empty() {
            return Err(NetError::NoSocketLeft);
        }
        // SAFETY: pointer and length are those of a slice.
        let count = unsafe { raw::zsock_send(self.0, bytes.as_ptr().cast(), bytes.len(), 0) };
        transferred(count)
    }

    /// Closes the writing direction.
    pub(crate) fn shut_down_writing(&self) {
        // SAFETY: it takes any descriptor. It fails if the connection is gone already, as requested, or if the stack
        // has no such call.
        let _ = unsafe { raw::zsock_shutdown(self.0, integer(raw::ZSOCK_SHUT_WR)) };
    }

    /// Sets the options of a connection. Messages are collected before they are written, so TCP need not wait for more.
    /// A peer that has gone without a word is detected even if nothing is to be sent.
    fn set_up_connection(&self) {
        self.switch_on(TCP, raw::TCP_NODELAY);
        self.switch_on(raw::SOL_SOCKET, raw::SO_KEEPALIVE);
    }

    /// Sets an option whose absence does no harm.
    fn switch_on(&self, level: u32, option: u32) {
        self.set(level, option, 1);
    }

    fn set(&self, level: u32, option: u32, value: c_int) {
        let length = size_of_in_bytes::<c_int>();
        let value = (&raw const value).cast();
        // SAFETY: pointer and length are those of a local.
        let _ = unsafe { raw::zsock_setsockopt(self.0, integer(level), integer(option), value, length) };
    }
}

/// Waits for descriptors; a negative number of ticks means without limit. Returns how many of them are ready.
pub(crate) fn poll(set: &mut [raw::zvfs_pollfd], timeout_ticks: i64) -> usize {
    let count = c_int::try_from(set.len()).unwrap_or(c_int::MAX);
    // SAFETY: pointer and length are those of a slice that may be written to.
    let ready = unsafe { raw::lf_poll(set.as_mut_ptr(), count, timeout_ticks) };
    // It fails only when CONFIG_ZVFS_POLL_MAX is too small, against which the build has an assertion.
    usize::try_from(ready).unwrap_or(0)
}

/// Returns the calling thread's last error.
pub(crate) fn last_error() -> NetError {
    // SAFETY: it has no precondition.
    error_of(unsafe { raw::lf_errno() })
}

fn check(result: c_int) -> Result<c_int, NetError> {
    if result < 0 { Err(last_error()) } else { Ok(result) }
}

fn transferred(count: isize) -> Result<Transfer, NetError> {
    match usize::try_from(count) {
        Ok(0) => Ok(Transfer::Closed),
        Ok(count) => Ok(Transfer::Bytes(count)),
        Err(_) => match last_class() {
            error::LF_NETWORK_WOULD_BLOCK | error::LF_NETWORK_INTERRUPTED => Ok(Transfer::WouldBlock),
            _ => Err(last_error()),
        },
    }
}

/// Returns the kind of the calling thread's last error.
fn last_class() -> error::Type {
    // SAFETY: neither has a precondition.
    unsafe { raw::lf_network_error(raw::lf_errno()) }
}

fn error_of(number: c_int) -> NetError {
    // SAFETY: it has no precondition.
    match unsafe { raw::lf_network_error(number) } {
        error::LF_NETWORK_REFUSED => NetError::Refused,
        error::LF_NETWORK_RESET => NetError::Reset,
        error::LF_NETWORK_UNREACHABLE => NetError::Unreachable,
        error::LF_NETWORK_ADDRESS_IN_USE => NetError::AddressInUse,
        error::LF_NETWORK_NO_SOCKET_LEFT => NetError::NoSocketLeft,
        _ => NetError::Os(number),
    }
}
