// SPDX-License-Identifier: Apache-2.0
//! The RTI of an image: Kconfig has its sizes, which the compiler computes.

pub use lf_embedded::rti::{AUTHENTICATOR, ClockSync, Description, longest};
use lf_embedded::rti::{ImageRti, Parts};
use lf_runtime::RtiError;

use crate::kconfig::{
    LF_RTI_BUFFER_SIZE, LF_RTI_CONNECTIONS, LF_RTI_FEDERATES, LF_RTI_IN_TRANSIT, LF_RTI_TRANSIENTS, LF_RTI_UPSTREAM,
};
use crate::platform::ZephyrPlatform;
use crate::{ImagePlatform, settings};

/// The connections, the listener, and a port for datagrams.
const SOCKETS: usize = LF_RTI_CONNECTIONS + 1 + if cfg!(CONFIG_NET_UDP) { 1 } else { 0 };

/// The platform of an RTI.
type RtiPlatform = ImagePlatform<SOCKETS>;

/// The static memory of an RTI with buffers of this size.
pub type Memory<const BYTES: usize> = lf_embedded::rti::Memory<
    RtiPlatform,
    Parts<LF_RTI_FEDERATES, LF_RTI_TRANSIENTS, LF_RTI_CONNECTIONS, LF_RTI_UPSTREAM, LF_RTI_IN_TRANSIT, BYTES>,
>;

/// The RTI of an image, and its description of the federation.
pub type Image = (&'static dyn ImageRti<RtiPlatform>, &'static Description);

/// Returns the size of the buffer of each connection in each direction; Kconfig may ask for more than the federation
/// needs.
pub const fn buffer_bytes(description: &Description) -> usize {
    description.buffer_bytes(LF_RTI_FEDERATES, LF_RTI_BUFFER_SIZE)
}

/// Returns the RTI's platform. Without encryption this is no code of its own.
fn platform() -> RtiPlatform {
    #[cfg(CONFIG_LF_SECURITY)]
    return crate::security::of_rti(ZephyrPlatform::without_wake());
    #[cfg(not(CONFIG_LF_SECURITY))]
    ZephyrPlatform::without_wake()
}

/// Accepts federates; prints the port on the console.
pub(crate) fn listen(rti: &'static dyn ImageRti<RtiPlatform>, description: &Description) -> Result<(), RtiError> {
    let port = settings::own_rti_port().map_err(RtiError::Settings)?;
    let port = rti.listen(description, platform(), port, settings::federation_id())?;
    settings::set_own_rti_port(port);
    crate::println!("listening on TCP port {port}");
    Ok(())
}
