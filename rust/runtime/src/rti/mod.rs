// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI. It consists of parts:
//!
//! - [`connections`], each with a receiving and a sending side, and
//! - their [`table`], with a queue of those with something to do;
//! - [`ports`], which are open before it runs, and
//! - [`events`], the log.
//!
//! The [`event_loop`] calls them in order, and passes input to the machine.

mod connections;
mod event_loop;
mod events;
mod ports;
mod table;

pub use connections::{Inlet, Outgoing};
pub use event_loop::{RtiLoop, RtiSetup};
pub use events::log_rti_event;
pub use ports::RtiPorts;
