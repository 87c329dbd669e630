// SPDX-License-Identifier: Apache-2.0
//! `deployment.yaml`: where each federate and the RTI run.
//!
//! ```yaml
//! rti: { platform: host, ip: 10.0.0.1, port: 15045 }   # `lfz rti` on this computer, which is the default
//! federates:
//!   sender: { platform: host }
//!   simulated: { platform: native_sim/native/64 }      # with the sockets of this computer
//!   bridged: { platform: native_sim/native/64, ip: 10.0.0.3 }   # with Zephyr's own network stack, over TAP
//!   receiver:
//!     platform: qemu_cortex_m3
//!     ip: 10.0.0.2
//!     netmask: 255.255.255.0        # the default; with an IPv6 address, `prefix: 64` is
//!     gateway: 10.0.0.1             # optional
//!     mac: 02:00:00:00:00:02        # optional; for boards that would otherwise share one
//!     ethernet: eth                 # optional; the devicetree label of the MAC, where it is not known
//!     runner: pyocd                 # optional; as in `west flash --runner`
//!     probe: "0240000034544e45"     # optional; which of several probes
//!   filter: { platform: host, restart: on-failure }   # a transient federate that starts again when it has failed
//!   meter:
//!     platform: qemu_cortex_m3
//!     ip: 10.0.0.4
//!     spare: { ip: 10.0.0.14 }      # optional; a second board, with which a transient federate is swapped; or a `mac`
//!                                   # and a `probe` of it, too
//! ```
//!
//! The RTI can be an image, too: alone on a board, for which it has the keys of a federate beside its port, or jointly
//! with a federate, which says `joint-rti: true`. Then the RTI's address is that of the federate.
//!
//! ```yaml
//! rti: { platform: qemu_cortex_m3, ip: 10.0.0.9, port: 15045 }
//! ```
//! ```yaml
//! federates:
//!   sender: { platform: qemu_cortex_m3, ip: 10.0.0.2, joint-rti: true }
//! ```
//!
//! `security: { keys: FOLDER }` says where the keys of an encrypted federation are, relative to the file.
//!
//! Addresses are IPv4 or IPv6, and those of a board and of its RTI are of one family.
//!
//! Virtual boards (`native_sim` with `ip`, QEMU) that are given no `mac` have one that follows from their `ip`.
//!
//! A federate that is not listed runs on this computer. Keys that are not listed above are errors, and so are
//! addresses and probes that occur twice.

mod check;
mod home;
mod parse;
mod raw;

use core::fmt;
use core::net::{IpAddr, Ipv4Addr};
use std::collections::BTreeMap;

use crate::plan::{Plan, Rti};

/// The places of the federates and the RTI.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Deployment {
    /// The RTI.
    pub rti: RtiPlace,
    /// The listed federates, by name.
    pub federates: BTreeMap<String, Place>,
    /// The folder of the federation's keys, as it is written: relative to the file.
    pub keys: Option<String>,
}

/// The place and the address of the RTI.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RtiPlace {
    /// The program or image that contains it.
    pub home: RtiHome,
    /// The address to which federates connect, which for an image is that of its board; the program's own `at` if it is
    /// missing.
    pub ip: Option<IpAddr>,
    /// The TCP port; the program's own if it is missing.
    pub port: Option<u16>,
}

/// The program or image that contains the RTI.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RtiHome {
    /// A program of this computer.
    #[default]
    Program,
    /// A Zephyr image of its own.
    Image(Box<Place>),
    /// The Zephyr image of this federate.
    Joint(String),
}

/// The place of a federate, or of an RTI that is an image of its own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// This computer, or a Zephyr board.
    pub platform: Platform,
    /// The network configuration of the board.
    pub network: Option<BoardNetwork>,
    /// The MAC address that the image assigns to the board.
    pub mac: Option<Mac>,
    /// The devicetree label of the Ethernet MAC.
    pub ethernet: Option<String>,
    /// The runner that flashes the board.
    pub runner: Option<String>,
    /// The probe to which the board is attached.
    pub probe: Option<String>,
    /// Whether the federate, which is transient, starts again when it has failed.
    pub restarts: bool,
    /// The place of a second board of the same kind, with which the federate, which is transient, is swapped.
    pub spare: Option<Box<Self>>,
}

impl Place {
    /// Returns its address, if it is known: that of its board, or this computer's if it uses its sockets here.
    pub(super) fn address(&self) -> Option<IpAddr> {
        self.network.map(|network| network.ip).or(self.is_offloaded().then_some(Ipv4Addr::LOCALHOST.into()))
    }

    /// Returns whether it is a Zephyr image that runs as a program of this computer, with this computer's sockets.
    pub fn is_offloaded(&self) -> bool {
        self.platform.is_native_sim() && self.network.is_none()
    }
}

/// This computer, or a Zephyr board.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Platform {
    /// A program for this computer.
    #[default]
    Host,
    /// A Zephyr image for this board, qualifiers included: `native_sim/native/64`.
    Zephyr(String),
}

impl Platform {
    /// Returns whether it is a Zephyr image that runs as a program of this computer.
    pub fn is_native_sim(&self) -> bool {
        self.board_name() == Some("native_sim")
    }

    /// Returns whether it is a virtual board: `native_sim` or QEMU. Such a board has no MAC address from its
    /// manufacturer.
    pub fn is_virtual(&self) -> bool {
        self.board_name().is_some_and(|name| name == "native_sim" || name == "mps2" || name.starts_with("qemu_"))
    }

    /// Returns the board without qualifiers and revision.
    fn board_name(&self) -> Option<&str> {
        match self {
            Self::Host => None,
            Self::Zephyr(board) => board.split(['/', '@']).next(),
        }
    }
}

/// The fixed IP configuration of a board: all its addresses are of one family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardNetwork {
    /// The board's address.
    pub ip: IpAddr,
    /// The length of its network's prefix.
    pub prefix_bits: u8,
    /// The gateway, if there is one.
    pub gateway: Option<IpAddr>,
}

impl BoardNetwork {
    /// Returns the netmask of an IPv4 network.
    pub fn netmask(self) -> Option<Ipv4Addr> {
        let ones = u32::MAX.checked_shl(32_u32.saturating_sub(self.prefix_bits.into())).unwrap_or_default();
        self.ip.is_ipv4().then_some(Ipv4Addr::from_bits(ones))
    }
}

/// A unicast MAC address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mac(pub [u8; 6]);

impl Mac {
    /// Returns the default address of a virtual board: locally administered, and different for different IP addresses.
    pub fn of_virtual_board(ip: IpAddr) -> Self {
        match ip {
            IpAddr::V4(ip) => {
                let [a, b, c, d] = ip.octets();
                Self([2, 0, a, b, c, d])
            }
            IpAddr::V6(ip) => {
                // FNV-1a: different addresses have the same hash with a probability of 2^-40.
                let mix = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                let hash = ip.octets().into_iter().fold(0xcbf2_9ce4_8422_2325_u64, mix);
                let [first, second, third, fourth, fifth, ..] = (hash ^ hash >> 40).to_le_bytes();
                Self([2, first, second, third, fourth, fifth])
            }
        }
    }
}

impl fmt::Display for Mac {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, byte) in self.0.iter().enumerate() {
            write!(f, "{}{byte:02x}", if index == 0 { "" } else { ":" })?;
        }
        Ok(())
    }
}

impl Deployment {
    /// Returns the address at which the federates of a program find its RTI: as deployed, or else as in the program.
    pub fn rti_of(&self, plan: &Plan) -> Option<Rti> {
        let mut rti = plan.rti.clone()?;
        if let Some(ip) = self.rti.ip {
            rti.host = ip.to_string();
        }
        rti.port = self.rti.port.unwrap_or(rti.port);
        Some(rti)
    }

    /// Returns whether the RTI is in the image of this federate.
    pub fn is_joint(&self, federate: &str) -> bool {
        matches!(&self.rti.home, RtiHome::Joint(name) if name == federate)
    }

    /// Returns the number of spare boards.
    pub fn spares(&self) -> usize {
        self.federates.values().filter(|place| place.spare.is_some()).count()
    }

    /// Returns this deployment with the two boards of a federate exchanged, if it has a spare one.
    pub fn with_spare(&self, federate: &str) -> Option<Self> {
        let first = self.federates.get(federate)?;
        let spare = first.spare.as_deref()?.clone();
        let first = Box::new(Place { spare: None, ..first.clone() });
        let mut deployment = self.clone();
        deployment.federates.insert(federate.to_owned(), Place { spare: Some(first), ..spare });
        Some(deployment)
    }

    /// Returns the place of a federate; this computer if it is not listed.
    pub fn place(&self, federate: &str) -> Place {
        self.federates.get(federate).cloned().unwrap_or_default()
    }
}
