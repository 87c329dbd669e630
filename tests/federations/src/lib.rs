// SPDX-License-Identifier: Apache-2.0
//! Shared code of the end-to-end tests: the `lfz` program, and watched processes.
//!
//! Tests wait for lines and for ends of processes, never for a time. [`TIME_OUT`] only keeps a broken program from
//! blocking a test run without end.
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

/// A limit far longer than any test takes, compiling on a busy computer included.
pub const TIME_OUT: Duration = Duration::from_secs(600);
