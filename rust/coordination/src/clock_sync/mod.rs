// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization between a federate and the RTI.
//!
//! The RTI's clock is the federation's. An exchange is four instants: the RTI sends T1, which the federate receives at
//! T2 by its own clock; the federate sends T3; the RTI receives it at T4, by its own clock, and tells the federate.
//!
//! Before the start there are some exchanges over TCP, from which the [`Estimator`] works out how far the federate's
//! clock is behind; the correction begins with that. With `clock-sync: on`, rounds over UDP follow as long as the
//! federation runs: the RTI begins one per period and federate ([`Poll`]), the [`Responder`] takes part in them, and
//! the [`Tracker`] works out offset and drift. [`ClockCorrection`] turns readings of the federate's own clock into the
//! federation's physical time.
//!
//! Nothing here reads a clock or knows which socket an exchange went over.

mod correction;
mod estimator;
mod line;
mod poll;
mod responder;
mod tracker;
mod trouble;

use lf_model::time::Interval;

pub use correction::{ClockCorrection, DRIFT_PPB_MAX, SLEW_PPB_MAX};
pub use estimator::{Estimate, Estimator, Exchange};
pub use line::Line;
pub use poll::Poll;
pub use responder::{Heard, Responder, Round};
pub use tracker::Tracker;
pub use trouble::Trouble;

/// Whether a correction can change while the federation runs. Otherwise it is an offset, and small.
pub(crate) const DATAGRAMS: bool = cfg!(feature = "datagrams");
/// The UDP port of an RTI, if it is free; federates answer to where a T1 came from.
pub const RTI_UDP_PORT: u16 = 15061;
/// The period of the rounds of an RTI that is told none, as the stock RTI's.
pub const PERIOD: Interval = Interval::from_millis(10);
/// The `attenuation` of a federate that is told none.
pub const ATTENUATION: u16 = 10;
/// The longest that the RTI waits for T3 before it begins the next round with a federate. What comes later than that
/// can be taken for the answer to another T1.
pub const ROUND_TIME_OUT: Interval = Interval::from_secs(1);
