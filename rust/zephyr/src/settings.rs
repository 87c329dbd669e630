// SPDX-License-Identifier: Apache-2.0
//! Which federation to join, and where its RTI is: from Kconfig, and on `native_sim` from the command line.

use core::ffi::{CStr, c_char};
use core::fmt;
use core::net::{Ipv4Addr, SocketAddrV4};
use core::sync::atomic::{AtomicU16, Ordering};

use crate::raw;

/// A setting that cannot be used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SettingsError {
    /// The federation id is not UTF-8.
    FederationId,
    /// The address of the RTI is not an IPv4 address.
    RtiAddress(&'static str),
    /// The port of the RTI is not one.
    RtiPort(u32),
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FederationId => f.write_str("CONFIG_LF_FEDERATION_ID is not UTF-8"),
            Self::RtiAddress(text) => {
                write!(f, "CONFIG_LF_RTI_ADDRESS is \"{text}\", but has to be an IPv4 address such as 10.0.0.1")
            }
            Self::RtiPort(port) => write!(f, "the RTI's port is {port}, but has to be one of 1 to 65535"),
        }
    }
}

impl core::error::Error for SettingsError {}

/// The federation id that the federate presents to the RTI.
///
/// # Errors
/// When it is not UTF-8.
pub fn federation_id() -> Result<&'static str, SettingsError> {
    // SAFETY: it has no precondition.
    text(unsafe { raw::lf_federation_id() }).ok_or(SettingsError::FederationId)
}

/// Where the RTI listens.
///
/// # Errors
/// When the address is not an IPv4 address, or the port not a port.
pub fn rti_address() -> Result<SocketAddrV4, SettingsError> {
    // SAFETY: it has no precondition.
    let address = text(unsafe { raw::lf_rti_address() }).unwrap_or("not UTF-8");
    let address: Ipv4Addr = address.parse().map_err(|_| SettingsError::RtiAddress(address))?;
    let port = match OWN_RTI_PORT.load(Ordering::Acquire) {
        0 => own_rti_port()?,
        own => own,
    };
    if port == 0 { Err(SettingsError::RtiPort(0)) } else { Ok(SocketAddrV4::new(address, port)) }
}

/// Where an RTI that is part of this image listens; 0 before it does.
static OWN_RTI_PORT: AtomicU16 = AtomicU16::new(0);

/// The port on which an RTI that is part of this image is to listen; on `native_sim` it may be 0, for any.
///
/// # Errors
/// When it is none.
pub(crate) fn own_rti_port() -> Result<u16, SettingsError> {
    // SAFETY: it has no precondition.
    let port = unsafe { raw::lf_rti_port() };
    u16::try_from(port).map_err(|_| SettingsError::RtiPort(port))
}

/// An RTI that is part of this image listens on this port.
#[cfg(CONFIG_LF_RTI)]
pub(crate) fn set_own_rti_port(port: u16) {
    OWN_RTI_PORT.store(port, Ordering::Release);
}

/// A text of C that lives as long as the program.
fn text(pointer: *const c_char) -> Option<&'static str> {
    // SAFETY: src/settings.c returns texts of Kconfig or of the command line, all of which are terminated and never
    // change or go away.
    unsafe { CStr::from_ptr(pointer) }.to_str().ok()
}
