// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization between a federate and the RTI.
//!
//! The RTI's clock is the federation's. An exchange is four instants: the RTI sends T1, which the federate receives at
//! T2 by its own clock; the federate sends T3, taken when the bytes are written; the RTI receives it at T4, by its own
//! clock, and tells the federate. From several exchanges the [`Estimator`] works out how far the federate's clock is
//! behind, and [`ClockCorrection`] turns readings of the federate's own clock into the federation's physical time.
//!
//! Nothing here reads a clock or knows which socket an exchange went over.

mod correction;
mod estimator;

pub use correction::{ClockCorrection, SLEW_PPB_MAX};
pub use estimator::{Estimate, Estimator, Exchange};
