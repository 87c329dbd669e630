// SPDX-License-Identifier: Apache-2.0
//! What an image for any system without a heap needs: a federate and an RTI in static memory, of sizes that are known
//! when it is compiled, and what C is told of how they end.
//!
//! Nothing here is of one system. Its crate has the [`Platform`](lf_runtime::platform::Platform), says with
//! [`run!`] what the program of an image is, and gives what its settings are: which federation to join, where the RTI
//! is, how large buffers are at least.
#![no_std]
#![deny(unsafe_code)]

#[cfg(test)]
extern crate std;

#[expect(unsafe_code, reason = "memory that is static and not constant; each block says why it is sound")]
mod cell;
pub mod federate;
mod outcome;
pub mod rti;
mod text;

pub use outcome::{in_words, status};
pub use text::{Text, whole_characters};
