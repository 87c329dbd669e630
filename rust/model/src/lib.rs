// SPDX-License-Identifier: Apache-2.0
//! The reactor model of one federate.
#![no_std]
#![forbid(unsafe_code)]

mod macros;
pub mod time;

#[doc(hidden)]
pub use macros::__private;
pub use time::{EventTag, Instant, Interval, Microstep, Offset, Tag};
