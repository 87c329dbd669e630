// SPDX-License-Identifier: Apache-2.0
//! The event loop of the RTI, made of parts:
//!
//! - [`connections`], each with a receiving and a sending side, and
//! - their [`table`], with a queue of those that something is to be done for;
//! - [`notices`], for people.
//!
//! The [`event_loop`] calls them in order, and gives the machine what comes.

mod connections;
mod event_loop;
mod notices;
mod table;

pub use connections::{Inlet, Outgoing};
pub use event_loop::{RtiLoop, RtiSetup};
pub use notices::log_notice;
