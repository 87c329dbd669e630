// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization between a federate and the RTI.
//!
//! The RTI's clock is the federation's. An exchange consists of four instants: the RTI sends T1, which the federate
//! receives at T2 by its own clock; the federate sends T3; the RTI receives it at T4, by its own clock, and sends T4 to
//! the federate.
//!
//! Before the start there are some exchanges over TCP, from which the [`Estimator`] computes the offset of the
//! federate's clock; the correction begins with that. With `clock-sync: on`, rounds over UDP follow while the
//! federation runs: the RTI begins one per period and federate ([`Poll`]), the [`Responder`] answers, and the
//! [`Tracker`] computes offset and drift. [`ClockCorrection`] converts readings of the federate's own clock to the
//! federation's physical time.
//!
//! This module neither reads a clock nor knows the socket of an exchange.

mod clock_fault;
mod correction;
mod estimator;
mod line;
mod poll;
mod responder;
mod tracker;

use lf_model::time::Interval;

pub use clock_fault::ClockFault;
pub use correction::{ClockCorrection, DRIFT_PPB_MAX, SLEW_PPB_MAX};
pub use estimator::{Estimate, Estimator, Exchange};
pub use line::Line;
pub use poll::Poll;
pub use responder::{Responder, Response, Round};
pub use tracker::Tracker;

/// Whether a correction can change while the federation runs. Otherwise it is an offset, and small.
pub(crate) const DATAGRAMS: bool = cfg!(feature = "datagrams");
/// The UDP port of an RTI, if it is free; federates send their answer to the source of T1.
pub const RTI_UDP_PORT: u16 = 15061;
/// The default period of an RTI's rounds, as in the stock RTI.
pub const PERIOD: Interval = Interval::from_millis(10);
/// The default `attenuation` of a federate.
pub const ATTENUATION: u16 = 10;
/// The longest time that the RTI waits for T3 before it begins the next round with a federate. A later T3 can be taken
/// for the answer to another T1.
pub const ROUND_TIME_OUT: Interval = Interval::from_secs(1);
