// SPDX-License-Identifier: Apache-2.0
//! What the tests and tools of several crates share, and no product contains.
#![forbid(unsafe_code)]

pub mod golden;
pub mod messages;
#[cfg(feature = "network")]
pub mod network;
pub mod random;
#[cfg(feature = "network")]
pub mod trace;
