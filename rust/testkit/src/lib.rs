// SPDX-License-Identifier: Apache-2.0
//! Code that the tests and tools of several crates share, and that no product contains.
#![forbid(unsafe_code)]

#[cfg(feature = "coordination")]
pub mod federate;
pub mod golden;
#[cfg(feature = "host")]
pub mod host;
pub mod messages;
#[cfg(feature = "network")]
pub mod network;
#[cfg(feature = "coordination")]
pub mod parts;
#[cfg(any(feature = "coordination", feature = "network"))]
pub mod profiles;
pub mod random;
#[cfg(feature = "coordination")]
pub mod rti;
#[cfg(feature = "network")]
pub mod trace;
#[cfg(feature = "network")]
pub mod world;
