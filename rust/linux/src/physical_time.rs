// SPDX-License-Identifier: Apache-2.0
//! Points in physical time that code reads without a reaction's context.

use lf_model::Instant;
use lf_model::Outside as _;

use crate::outside::HostOutside;

/// The clock as a function of `Instant`, as in `std`; it is in the prelude.
pub trait PhysicalTime {
    /// Returns the physical time.
    fn now() -> Self;
}

impl PhysicalTime for Instant {
    fn now() -> Self {
        HostOutside::of_program().physical_time()
    }
}
