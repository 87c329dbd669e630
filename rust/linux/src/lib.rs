// SPDX-License-Identifier: Apache-2.0
//! The Linux platform, and the library of generated programs for this computer.
//!
//! Generated code names this crate `lf`, and its bodies see [`prelude`]. The crate also runs the RTI for the `lfz`
//! program.
#![forbid(unsafe_code)]

mod adaptive_spin;
mod arguments;
mod clock;
mod credentials;
pub mod devices;
pub mod keys;
mod logger;
mod main_program;
mod max_length;
mod noise;
mod outside;
mod panics;
mod parameters;
mod physical_time;
mod platform;
pub mod rti;
mod rti_commands;
mod sockets;
mod thread;
#[cfg(feature = "tls")]
pub mod tls;
mod trace_file;
pub mod virtual_network;
mod wake;
mod words;
#[cfg(feature = "workers")]
mod workers;

#[cfg(feature = "c")]
pub mod c;
pub use credentials::{Credentials, CredentialsError};
pub use lf_model as model;
pub use lf_runtime as runtime;
pub use log;
pub use logger::install as install_logger;
pub use main_program::{RTI_VARIABLE, main};
pub use max_length::MaxLength;
pub use panics::{Lines, name_lf_lines};
pub use parameters::{Parameter, ParameterKind, Parameters};
pub use physical_time::PhysicalTime;
pub use platform::Linux;
pub use thread::SpawnPhysicalThread;
pub use wake::interruption_status;
#[cfg(feature = "workers")]
pub use workers::Threads;

/// The names that reaction bodies and preambles see without an import.
pub mod prelude {
    #[cfg(feature = "devices")]
    pub use crate::device;
    pub use crate::{PhysicalTime, SpawnPhysicalThread};
    pub use lf_model::prelude::*;
    // Both spellings work: `info!` and `log::info!`.
    pub use log::{self, debug, error, info, log_enabled, trace, warn};
}
