// SPDX-License-Identifier: Apache-2.0
//! Addresses of IP, as participants compare, store and print them.
//!
//! With the feature `ipv6` an address is IPv4 or IPv6, otherwise IPv4. An IPv4 address that an IPv6 socket shows as a
//! mapped one (`::ffff:10.0.0.1`) is the IPv4 address, so a host has one spelling, and an image without IPv6 carries no
//! code for it.

use core::fmt;
#[cfg(feature = "ipv6")]
use core::net::{IpAddr, Ipv6Addr, SocketAddr, SocketAddrV6};
use core::net::{Ipv4Addr, SocketAddrV4};

use lf_texts::say;

/// The address of a host.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum IpAddress {
    /// An IPv4 address.
    V4(Ipv4Addr),
    /// An IPv6 address that is not a mapped IPv4 address, and its scope: the index of the local network interface for a
    /// link-local address, else 0.
    #[cfg(feature = "ipv6")]
    V6(Ipv6Addr, u32),
}

/// The address of a socket.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Endpoint {
    /// The address of its host.
    pub ip: IpAddress,
    /// Its port.
    pub port: u16,
}

impl IpAddress {
    /// The address of no host.
    pub const UNSPECIFIED: Self = Self::V4(Ipv4Addr::UNSPECIFIED);

    /// Returns the address with these bits; `scope` counts for link-local addresses only.
    #[cfg(feature = "ipv6")]
    pub const fn v6(address: Ipv6Addr, scope: u32) -> Self {
        match address.to_ipv4_mapped() {
            Some(address) => Self::V4(address),
            None => Self::V6(address, if address.is_unicast_link_local() { scope } else { 0 }),
        }
    }
}

impl Endpoint {
    /// Returns the socket address at this host and port.
    pub fn new(ip: impl Into<IpAddress>, port: u16) -> Self {
        Self { ip: ip.into(), port }
    }
}

impl Default for IpAddress {
    fn default() -> Self {
        Self::UNSPECIFIED
    }
}

impl From<Ipv4Addr> for IpAddress {
    fn from(address: Ipv4Addr) -> Self {
        Self::V4(address)
    }
}

impl From<SocketAddrV4> for Endpoint {
    fn from(address: SocketAddrV4) -> Self {
        Self::new(*address.ip(), address.port())
    }
}

#[cfg(feature = "ipv6")]
impl From<SocketAddr> for Endpoint {
    fn from(address: SocketAddr) -> Self {
        match address {
            SocketAddr::V4(address) => address.into(),
            SocketAddr::V6(address) => Self::new(IpAddress::v6(*address.ip(), address.scope_id()), address.port()),
        }
    }
}

#[cfg(feature = "ipv6")]
impl From<IpAddr> for IpAddress {
    fn from(address: IpAddr) -> Self {
        match address {
            IpAddr::V4(address) => Self::V4(address),
            IpAddr::V6(address) => Self::v6(address, 0),
        }
    }
}

#[cfg(feature = "ipv6")]
impl From<Endpoint> for SocketAddr {
    fn from(Endpoint { ip, port }: Endpoint) -> Self {
        match ip {
            IpAddress::V4(address) => Self::V4(SocketAddrV4::new(address, port)),
            IpAddress::V6(address, scope) => Self::V6(SocketAddrV6::new(address, port, 0, scope)),
        }
    }
}

/// Writes the usual spelling. It supports no width, which would take half a KiB of flash for an IPv4 address.
impl fmt::Display for IpAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::V4(address) => {
                let [first, second, third, fourth] = address.octets();
                say!(f, "{first}.{second}.{third}.{fourth}")
            }
            #[cfg(feature = "ipv6")]
            Self::V6(address, 0) => say!(f, "{address}"),
            #[cfg(feature = "ipv6")]
            Self::V6(address, scope) => say!(f, "{address}%{scope}"),
        }
    }
}

/// Writes the spelling of URLs: an IPv6 address is between brackets.
impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ip, port } = self;
        match ip {
            IpAddress::V4(_) => say!(f, "{ip}:{port}"),
            #[cfg(feature = "ipv6")]
            IpAddress::V6(..) => say!(f, "[{ip}]:{port}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString as _;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn addresses_look_as_anywhere_else(ip: IpAddr, port: u16, scope: u32) {
            prop_assume!(!matches!(ip, IpAddr::V6(ip) if ip.to_ipv4_mapped().is_some()));
            prop_assert_eq!(IpAddress::from(ip).to_string(), ip.to_string());
            let mut address = SocketAddr::new(ip, port);
            if let SocketAddr::V6(address) = &mut address && address.ip().is_unicast_link_local() {
                address.set_scope_id(scope);
            }
            let endpoint = Endpoint::from(address);
            prop_assert_eq!(endpoint.to_string(), address.to_string());
            prop_assert_eq!(SocketAddr::from(endpoint), address);
        }

        #[test]
        fn a_mapped_ipv4_address_is_the_ipv4_address(ip: Ipv4Addr, port: u16, scope: u32) {
            let mapped = SocketAddr::V6(SocketAddrV6::new(ip.to_ipv6_mapped(), port, 7, scope));
            prop_assert_eq!(Endpoint::from(mapped), Endpoint::new(ip, port));
        }
    }

    #[test]
    fn a_scope_counts_for_link_local_addresses_only() {
        let [near, far] = ["fe80::1", "fd00::1"].map(|text| text.parse::<Ipv6Addr>().expect("an address"));
        assert_eq!(Endpoint::new(IpAddress::v6(near, 3), 7).to_string(), "[fe80::1%3]:7");
        assert_eq!(IpAddress::v6(far, 3), IpAddress::from(IpAddr::V6(far)));
    }
}
