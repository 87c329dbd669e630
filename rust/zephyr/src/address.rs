// SPDX-License-Identifier: Apache-2.0
//! Addresses in the form of Zephyr's sockets.
//!
//! In an image with IPv6, listeners and UDP ports are sockets of IPv6, which also accept IPv4 if the image has both.

use core::ffi::c_int;
use core::net::Ipv4Addr;
#[cfg(feature = "ipv6")]
use core::net::Ipv6Addr;

use lf_runtime::platform::{Endpoint, IpAddress};

use crate::raw;
// Room for any address that this image can have.
#[cfg(not(feature = "ipv6"))]
use crate::raw::sockaddr_in as Storage;
#[cfg(feature = "ipv6")]
use crate::raw::sockaddr_in6 as Storage;

/// An address in C, with its length.
#[derive(Clone, Copy)]
pub(crate) struct SystemAddress {
    storage: Storage,
    length: raw::socklen_t,
}

/// The family of sockets that accept any family.
pub(crate) const ANY_FAMILY: u32 = if cfg!(feature = "ipv6") { raw::AF_INET6 } else { raw::AF_INET };

impl SystemAddress {
    /// Returns room for an address that a call writes.
    pub(crate) fn room() -> Self {
        Self { storage: Storage::default(), length: size_of_in_bytes::<Storage>() }
    }

    /// Returns the address that a socket connects to.
    pub(crate) fn of(endpoint: Endpoint) -> Self {
        match endpoint.ip {
            IpAddress::V4(address) => Self::of_v4(address, endpoint.port),
            #[cfg(feature = "ipv6")]
            IpAddress::V6(address, scope) => Self::of_v6(address, scope, endpoint.port),
        }
    }

    /// Returns the address that stands for all addresses of this image.
    pub(crate) fn any(port: u16) -> Self {
        #[cfg(feature = "ipv6")]
        return Self::of_v6(Ipv6Addr::UNSPECIFIED, 0, port);
        #[cfg(not(feature = "ipv6"))]
        Self::of_v4(Ipv4Addr::UNSPECIFIED, port)
    }

    /// Returns the address for a datagram, in the form for a socket of [`ANY_FAMILY`].
    pub(crate) fn for_any(endpoint: Endpoint) -> Self {
        #[cfg(feature = "ipv6")]
        if let IpAddress::V4(address) = endpoint.ip {
            return Self::of_v6(address.to_ipv6_mapped(), 0, endpoint.port);
        }
        Self::of(endpoint)
    }

    /// Returns the family of the address.
    pub(crate) fn family(&self) -> u32 {
        #[cfg(feature = "ipv6")]
        return self.storage.sin6_family.into();
        #[cfg(not(feature = "ipv6"))]
        self.storage.sin_family.into()
    }

    /// Returns a pointer to it.
    pub(crate) fn as_ptr(&self) -> *const raw::sockaddr {
        (&raw const self.storage).cast()
    }

    /// Returns pointers for a call that writes an address and its length.
    pub(crate) fn as_mut_ptrs(&mut self) -> (*mut raw::sockaddr, *mut raw::socklen_t) {
        ((&raw mut self.storage).cast(), &raw mut self.length)
    }

    /// Returns its length in C.
    pub(crate) fn length(&self) -> raw::socklen_t {
        self.length
    }

    #[cfg(not(feature = "ipv6"))]
    pub(crate) fn endpoint(&self) -> Endpoint {
        endpoint_v4(&self.storage)
    }

    /// Returns the address that a call has written.
    #[cfg(feature = "ipv6")]
    pub(crate) fn endpoint(&self) -> Endpoint {
        if self.family() == raw::AF_INET6 {
            // SAFETY: all views of the address are arrays of integers, without invalid values.
            let octets = unsafe { self.storage.sin6_addr.__bindgen_anon_1.s6_addr };
            let address = IpAddress::v6(Ipv6Addr::from(octets), self.storage.sin6_scope_id.into());
            return Endpoint::new(address, u16::from_be(self.storage.sin6_port));
        }
        // SAFETY: an address of IPv4 is shorter, is aligned no more strictly, and has no invalid values.
        endpoint_v4(unsafe { &*(&raw const self.storage).cast::<raw::sockaddr_in>() })
    }

    fn of_v4(address: Ipv4Addr, port: u16) -> Self {
        // The type is narrow, but the constant is 1.
        #[allow(clippy::cast_possible_truncation, reason = "see above")]
        let sin_family = raw::AF_INET as raw::sa_family_t;
        let mut system = raw::sockaddr_in { sin_family, sin_port: port.to_be(), ..Default::default() };
        system.sin_addr.__bindgen_anon_1.s_addr = address.to_bits().to_be();
        let mut storage = Storage::default();
        // SAFETY: the storage has room for an address of IPv4, and is aligned at least as strictly.
        unsafe { (&raw mut storage).cast::<raw::sockaddr_in>().write(system) };
        Self { storage, length: size_of_in_bytes::<raw::sockaddr_in>() }
    }

    #[cfg(feature = "ipv6")]
    fn of_v6(address: Ipv6Addr, scope: u32, port: u16) -> Self {
        // The type is narrow, but the constant is 2.
        #[allow(clippy::cast_possible_truncation, reason = "see above")]
        let sin6_family = raw::AF_INET6 as raw::sa_family_t;
        // Zephyr has few interfaces, and numbers them in a byte.
        let sin6_scope_id = scope.try_into().unwrap_or_default();
        let port = port.to_be();
        let mut storage = Storage { sin6_family, sin6_port: port, sin6_scope_id, ..Default::default() };
        storage.sin6_addr.__bindgen_anon_1.s6_addr = address.octets();
        Self { storage, length: size_of_in_bytes::<raw::sockaddr_in6>() }
    }
}

fn endpoint_v4(address: &raw::sockaddr_in) -> Endpoint {
    // SAFETY: all three views of the address are integers or arrays of them, without invalid values.
    let bits = unsafe { address.sin_addr.__bindgen_anon_1.s_addr };
    Endpoint::new(Ipv4Addr::from_bits(u32::from_be(bits)), u16::from_be(address.sin_port))
}

/// Returns a size in the type of C's functions.
#[allow(clippy::cast_possible_truncation, reason = "it is asked only for an address and an integer")]
pub(crate) fn size_of_in_bytes<T>() -> raw::socklen_t {
    size_of::<T>() as raw::socklen_t
}

/// Returns a small constant of C in the type of its functions.
pub(crate) const fn integer(value: u32) -> c_int {
    value.cast_signed()
}
