// SPDX-License-Identifier: Apache-2.0
//! The event loops that bind the reactor model and the coordination machines to a platform.
//!
//! One loop runs one participant: a federate, the RTI, or an unfederated main reactor. It polls all of its sockets and
//! its wake-up until the next event's time or the next time-out, and runs the reactions itself. This crate reads a
//! clock or touches a socket only through [`platform::Platform`].
//!
//! Each loop is a type ([`FederateLoop`], [`RtiLoop`], [`UnfederatedLoop`]) that runs to its end, or turn by turn. What
//! happens in it, it tells a [`trace::Recorder`], if it was given one.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod connection;
mod datagram;
mod description;
mod error;
mod federate;
mod image;
mod listener;
mod log_event;
pub mod platform;
mod rti;
#[cfg(feature = "security")]
mod secure;
pub mod trace;
mod turn;
mod unfederated;

pub use description::{
    CONTROL_BYTES, Description, Federation, PEERS, TAGGED_MESSAGE_HEADER_BYTES, TRANSIENTS, buffer_bytes,
    peer_buffer_bytes,
};
pub use error::{PeerFault, RunError};
pub use federate::{Buffers, FederateLoop, Inbound, Join, Outbound, Reason};
pub use image::{ImageError, RtiError, SettingsError};
pub use lf_coordination::auth::{AUTHENTICATOR, Authenticator, answer_rti};
pub use lf_coordination::code::PREFIX as CODE_PREFIX;
pub use lf_coordination::federate::{All, AwaitedInput, ClockSync, Coordination, Needs};
pub use lf_wire::DELAY_NONE;
pub use log_event::{Code, ConnectionEvent, DeviceEvent, FederateEvent, LogEvent, PeerEvent, TEXTS, explain, report};
pub use rti::{Inlet, Outgoing, RtiLoop, RtiPorts, RtiSetup, log_rti_event};
#[cfg(feature = "security")]
pub use secure::{Insecurity, SecurePlatform, SecureSlot, SecurityEvent};
pub use turn::Turn;
pub use unfederated::UnfederatedLoop;
