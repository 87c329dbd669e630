// SPDX-License-Identifier: Apache-2.0
//! The names that reaction bodies and preambles see without an import.

pub use crate::SpawnPhysicalThread;
pub use crate::{device, eprint, eprintln, print, println};
pub use lf_model::prelude::*;
// Both spellings work: `info!` and `log::info!`.
pub use log::{self, debug, error, info, log_enabled, trace, warn};
