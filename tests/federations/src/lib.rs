// SPDX-License-Identifier: Apache-2.0
//! What the end-to-end tests have in common: the `lfz` program, and processes that are watched.
//!
//! Tests wait for lines and for ends of processes, never for a time. [`TIME_OUT`] only keeps a broken program from
//! blocking a test run for ever.
#![forbid(unsafe_code)]

mod guide;
mod lfz;
mod processes;
mod run;

use std::time::Duration;

pub use guide::table;
pub use lfz::{Lfz, TIME_LIMIT, programs};
pub use processes::{Participant, wait_for_ends};
pub use run::{Finished, Run, is_of_build};

/// Far longer than anything takes here, compiling on a busy computer included.
pub const TIME_OUT: Duration = Duration::from_secs(600);
