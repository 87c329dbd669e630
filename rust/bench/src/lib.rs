// SPDX-License-Identifier: Apache-2.0
//! Measures RTIs side by side: latency, throughput, memory, and what a grant costs as a federation grows; and the
//! applications of this repository, as programs and as images.
//!
//! In measurements of RTIs the federates are raw sockets that keep the rules of the protocol ([`Peer`]) and all live in
//! one thread ([`Swarm`]), so that every RTI gets the same input and the federates cost as little as possible.

pub mod applications;
pub mod clock;
mod forwarder;
mod graph;
mod initial;
mod latency;
pub mod page;
mod peer;
mod pins;
mod process;
pub mod results;
mod samples;
mod swarm;

pub use forwarder::{Waiting, forward};
pub use graph::{Graph, Shape};
pub use initial::{InitialExchanges, SPREAD_MAX};
pub use latency::{Latency, forwarder_latency, program_latency, rti_latency};
pub use peer::{Load, Peer};
pub use pins::{Pins, read_pins};
pub use process::{Program, RunningRti, Usage};
pub use samples::{Samples, micros};
pub use swarm::{Swarm, Traffic};

/// The federation id of every federation here.
pub const FEDERATION: &str = "evaluate";

/// What went wrong, in a sentence.
pub type Error = Box<dyn std::error::Error>;
/// Of what can go wrong.
pub type Result<T> = std::result::Result<T, Error>;
