// SPDX-License-Identifier: Apache-2.0
//! Measures RTIs side by side: latency, throughput, memory, and the cost of a grant as a federation grows; clock
//! synchronization; and a raw connection to compare messages with. The program prints each value as a row
//! ([`Measured`]); `scripts/lf_evaluate` makes tables and a page of them.
//!
//! In measurements of RTIs the federates are raw sockets that keep the rules of the protocol ([`Peer`]) and share one
//! thread ([`Swarm`]), so that every RTI gets the same input and the federates cost as little as possible.
#![forbid(unsafe_code)]

pub mod clock;
mod forwarder;
mod graph;
mod initial;
mod latency;
mod link;
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
pub use link::{Access, write_keys};
pub use measured::Measured;
pub use peer::{Load, Peer};
pub use ping::{answer_pings, ping};
pub use process::{Program, RunningRti, Usage};
pub use samples::{Samples, micros};
pub use swarm::{Swarm, Traffic};

/// The federation id of every federation in these measurements.
pub const FEDERATION: &str = "evaluate";

/// The reason of a failure, as a sentence.
pub type Error = Box<dyn std::error::Error>;
/// The result of an operation that can fail.
pub type Result<T> = std::result::Result<T, Error>;
