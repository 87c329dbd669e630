// SPDX-License-Identifier: Apache-2.0
//! Measures RTIs side by side: latency, throughput, memory, and what a grant costs as a federation grows; clock
//! synchronization; and a raw connection to compare messages with. What is measured is printed row by row
//! ([`Measured`]); `scripts/lf_evaluate` makes tables and a page of it.
//!
//! In measurements of RTIs the federates are raw sockets that keep the rules of the protocol ([`Peer`]) and all live in
//! one thread ([`Swarm`]), so that every RTI gets the same input and the federates cost as little as possible.
#![forbid(unsafe_code)]

pub mod clock;
mod forwarder;
mod graph;
mod initial;
mod latency;
mod measured;
mod peer;
mod ping;
mod process;
mod samples;
mod swarm;

pub use forwarder::{Waiting, forward};
pub use graph::{Graph, Shape};
pub use initial::InitialExchanges;
pub use latency::{Latency, forwarder_latency, program_latency, rti_latency};
pub use measured::Measured;
pub use peer::{Load, Peer};
pub use ping::{answer_pings, ping};
pub use process::{Program, RunningRti, Usage};
pub use samples::{Samples, micros};
pub use swarm::{Swarm, Traffic};

/// The federation id of every federation here.
pub const FEDERATION: &str = "evaluate";

/// What went wrong, in a sentence.
pub type Error = Box<dyn std::error::Error>;
/// Of what can go wrong.
pub type Result<T> = std::result::Result<T, Error>;
