// SPDX-License-Identifier: Apache-2.0
//! Bodies in C. Queues, tags and order are the model's; ports, actions and the reactors' state lie in C, where
//! generated C code and its bodies see them.
//!
//! A program has an owner struct in Rust like every generated program, with the ports, queues and actions of this
//! crate, whose values are [`Token`]s. [`react`] runs a body by its number. The bodies' API lies beside this crate, in
//! `include/lf.h` and `src/*.c`: these are compiled with the program, by the crate `lf-c-build` or by Zephyr's build.
//!
//! One thread runs an event loop, and one program is in a process: its ports are C's global variables.
#![no_std]
#![expect(unsafe_code, reason = "bodies and cells in C; each block says why it is sound")]

mod api;
mod ffi;
mod port;
mod running;
mod token;
mod trigger;

pub use port::{Port, QueuedPort, TardyInput, copy};
#[cfg(feature = "workers")]
pub use running::ReactorCells;
pub use running::{Bodies, construct, give_parameter, handle_tardy, miss_deadline, react, reset_mode};
#[cfg(feature = "transients")]
pub use running::{hand_over, take_over};
pub use token::Token;
pub use trigger::{LogicalAction, PhysicalAction, PhysicalInbox, Timer, Watchdog};
