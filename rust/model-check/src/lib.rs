// SPDX-License-Identifier: Apache-2.0
//! A model check of the RTI's grants: the RTI of `lf-coordination` itself, together with federates that keep the
//! protocol and choose freely what the protocol leaves open, in every order in which their messages can arrive.
//!
//! One [`Model`] is one graph of up to four federates. What is checked in every state that can be reached:
//!
//! - **safety**: no message comes for a tag that its receiver has been granted; a provisional grant leaves open only
//!   what the same cycle without delay can still cause; grants rise;
//! - **liveness**: whatever happens, every event is handled in the end. No federate runs for ever, so this is: a state
//!   from which nothing leads on has no event left;
//! - **memory**: no more tags of messages are under way than the RTI was given room for.
//!
//! The states are found by [stateright]; [`Model::actions`](stateright::Model::actions) leaves out orders that cannot
//! make a difference.
#![forbid(unsafe_code)]

mod bounds;
mod check;
mod federate;
mod graph;
mod model;
mod moment;
mod reduction;
mod rti;
mod state;
mod step;
mod words;
mod world;

pub use bounds::{Bounds, Fault};
pub use check::{Finding, Report, check};
pub use graph::{Delay, FEDERATES_MAX, Graph, all_graphs, some_graphs};
pub use model::Model;
pub use moment::Moment;
pub use state::State;
pub use step::Action;
pub use words::Broken;
