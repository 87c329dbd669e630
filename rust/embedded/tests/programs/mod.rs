// SPDX-License-Identifier: Apache-2.0
//! A federation in the shape that the compiler generates: a timer's count goes from one federate to another.

use lf_embedded::rti::{ClockSync, Description};
use lf_model::time::Interval;
use log::LevelFilter;

pub(crate) mod alone;
pub(crate) mod receiver;
pub(crate) mod sender;

/// The bytes of the longest value on the connection: more than a count needs, so that buffers are large.
const VALUE_BYTES: usize = 800;

/// The RTI's description of the federation.
pub(crate) static RTI: Description = Description {
    federation_id: "images",
    authentication: None,
    clock_sync: ClockSync::On { trials: 3, period: Interval::from_millis(5) },
    dnet: true,
    log_waits: None,
    logging: LevelFilter::Info,
    payload_bytes_max: VALUE_BYTES,
};
