// SPDX-License-Identifier: Apache-2.0
//! The base of an image for any system without a heap: a federate and an RTI in static memory, of sizes that are known
//! at compile time, and their status for C.
//!
//! This crate is independent of the system. The system's crate implements [`Platform`](lf_runtime::platform::Platform),
//! declares the program of an image with [`run!`], and supplies its settings: the federation to join, the RTI's
//! address, and the minimum sizes of buffers.
#![no_std]

#[cfg(test)]
extern crate std;

#[expect(unsafe_code, reason = "memory that is static and not constant; each block says why it is sound")]
mod cell;
pub mod federate;
mod outcome;
pub mod rti;
#[cfg(feature = "security")]
mod security;
mod text;

pub use outcome::{in_words, status};
#[cfg(feature = "security")]
pub use security::SecureMemory;
pub use text::{Text, whole_characters};
