// SPDX-License-Identifier: Apache-2.0
//! Settings: the federation to join, its RTI's address, and the minimum sizes of buffers, from Kconfig, and on
//! `native_sim` from the command line.

use core::ffi::CStr;
use core::sync::atomic::{AtomicU16, Ordering};

use lf_embedded::federate::MinBuffers;
use lf_runtime::platform::{Endpoint, IpAddress};
use lf_runtime::{Join, SettingsError};

use crate::kconfig::{LF_RECEIVE_BUFFER_SIZE, LF_SEND_BUFFER_SIZE};
use crate::raw;

/// The minimum sizes of a federate's buffers.
pub const BUFFERS: MinBuffers = MinBuffers { input_bytes: LF_RECEIVE_BUFFER_SIZE, output_bytes: LF_SEND_BUFFER_SIZE };

/// Returns the federation to join.
///
/// # Errors
/// When the RTI's address is not an address of a family that the image has, or its port not a port.
pub fn join() -> Result<Join<'static>, SettingsError> {
    Ok(Join { federation_id: federation_id(), rti: rti_address()?, others: &[] })
}

/// Returns the federation id that the federate presents to the RTI; empty for that of its program.
pub(crate) fn federation_id() -> &'static [u8] {
    federation_id_text().to_bytes()
}

/// Returns the same as a text of C.
pub(crate) fn federation_id_text() -> &'static CStr {
    // SAFETY: src/settings.c returns a text of Kconfig or of the command line; these are terminated, never change and
    // live forever.
    unsafe { CStr::from_ptr(raw::lf_federation_id()) }
}

/// Returns the RTI's address.
fn rti_address() -> Result<Endpoint, SettingsError> {
    let mut octets = [0; 16];
    // SAFETY: C returns the number of bytes that it has written, at most the length of the buffer.
    let count = unsafe { raw::lf_rti_address(octets.as_mut_ptr()) };
    let ip = match (count, octets) {
        (4, [first, second, third, fourth, ..]) => IpAddress::V4([first, second, third, fourth].into()),
        #[cfg(feature = "ipv6")]
        (16, octets) => IpAddress::v6(octets.into(), 0),
        _ => return Err(SettingsError::RtiAddress),
    };
    let port = match OWN_RTI_PORT.load(Ordering::Acquire) {
        0 => own_rti_port()?,
        own => own,
    };
    if port == 0 { Err(SettingsError::RtiPort(0)) } else { Ok(Endpoint::new(ip, port)) }
}

/// The port of an RTI that is part of this image; 0 before it listens.
static OWN_RTI_PORT: AtomicU16 = AtomicU16::new(0);

/// Returns the port on which an RTI that is part of this image has to listen; on `native_sim` it may be 0, for any.
///
/// # Errors
/// When it is not a port.
pub(crate) fn own_rti_port() -> Result<u16, SettingsError> {
    // SAFETY: it has no precondition.
    let port = unsafe { raw::lf_rti_port() };
    u16::try_from(port).map_err(|_| SettingsError::RtiPort(port))
}

/// Sets the port of an RTI that is part of this image.
#[cfg(CONFIG_LF_RTI)]
pub(crate) fn set_own_rti_port(port: u16) {
    OWN_RTI_PORT.store(port, Ordering::Release);
}
