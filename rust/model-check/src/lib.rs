// SPDX-License-Identifier: Apache-2.0
//! A model check of the RTI's grants: the RTI of `lf-coordination` itself, together with federates that keep the
//! protocol and choose freely what the protocol leaves open, in every order in which their messages can arrive.
//!
//! One [`Model`] is one graph of up to five federates. The check examines in every reachable state:
//!
//! - **safety**: no message arrives for a tag that its receiver has been granted; a provisional grant leaves open only
//!   messages of the same cycle without delay; grants rise;
//! - **liveness**: the federates handle every event eventually. All runs are finite, so the check is: a state without
//!   successors has no event left;
//! - **memory**: the tags of messages in transit fit into the memory of the RTI.
//!
//! [stateright] explores the states; [`Model::actions`](stateright::Model::actions) leaves out orders that cannot make
//! a difference.
#![forbid(unsafe_code)]

mod bounds;
mod check;
mod federate;
mod graph;
mod messages;
mod model;
mod reduction;
mod rti;
mod small_tag;
mod state;
mod step;
mod world;

pub use bounds::{Bounds, Fault};
pub use check::{Finding, Report, check};
pub use graph::{Delay, FEDERATES_MAX, Graph, all_graphs, some_graphs};
pub use messages::Violation;
pub use model::Model;
pub use small_tag::SmallTag;
pub use state::State;
pub use step::Action;
