// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI, made of parts:
//!
//! - [`connections`], each with a receiving and a sending side, and
//! - their [`table`], with a queue of those that something is to be done for;
//! - [`events`], for people.
//!
//! The [`event_loop`] calls them in order, and gives the machine what comes.

mod connections;
mod event_loop;
mod events;
mod table;

pub use connections::{Inlet, Outgoing};
pub use event_loop::{RtiLoop, RtiSetup, run_rti};
pub use events::log_rti_event;
