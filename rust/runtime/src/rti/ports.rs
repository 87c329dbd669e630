// SPDX-License-Identifier: Apache-2.0
//! The ports of an RTI.

use lf_coordination::clock_sync::RTI_UDP_PORT;
use lf_coordination::rti::ClockSync;

use crate::image::RtiError;
use crate::platform::{NetError, Platform, SocketId};

/// The open ports of an RTI; its loop closes them.
#[derive(Clone, Copy, Debug)]
pub struct RtiPorts {
    /// The socket that accepts connections.
    pub listener: SocketId,
    /// Its TCP port.
    pub tcp: u16,
    /// A UDP port for clock synchronization, if it goes on while the federation runs.
    pub datagrams: Option<SocketId>,
}

impl RtiPorts {
    /// Opens this TCP port, where 0 stands for any, and a UDP port if `clock_sync` needs one.
    ///
    /// # Errors
    /// The port that the system refuses to open.
    pub fn open(platform: &mut impl Platform, port: u16, clock_sync: ClockSync) -> Result<Self, RtiError> {
        let failed = |error| RtiError::Listen { port, error };
        let listener = platform.listen(port).map_err(failed)?;
        let tcp = platform.local_port(listener).map_err(failed)?;
        let datagrams = match clock_sync {
            ClockSync::Off | ClockSync::Init { .. } => None,
            // Federates answer to the source of the datagrams, so another port than the usual one will do.
            ClockSync::On { .. } => Some(match platform.bind(RTI_UDP_PORT) {
                Err(NetError::AddressInUse) => platform.bind(0),
                outcome => outcome,
            })
            .transpose()
            .map_err(RtiError::Bind)?,
        };
        Ok(Self { listener, tcp, datagrams })
    }
}
