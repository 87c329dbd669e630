// SPDX-License-Identifier: Apache-2.0
//! The federate and the RTI of a federation as state machines without I/O.
//!
//! Their owner passes them times and decoded messages, polls them for output until there is none, and calls them again
//! at their [`Deadline`]. They never read a clock, open a socket, draw a random number, sleep or allocate.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "heap"))]
extern crate std;

mod address;
pub mod auth;
pub mod clock_sync;
pub mod code;
mod deadline;
pub mod federate;
mod flow;
#[cfg(feature = "heap")]
pub mod heap;
mod id;
pub mod peer;
pub mod rti;
mod tag;
mod tally;

pub use address::{Endpoint, IpAddress};
pub use deadline::Deadline;
pub use flow::{WINDOW, WINDOW_MAX};
pub use id::FederateId;
pub use tag::{from_wire, to_wire};
pub use tally::{Tally, Times};
