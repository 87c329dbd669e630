// SPDX-License-Identifier: Apache-2.0
//! The event loops that bind the reactor model and the coordination machines to a platform.
//!
//! One loop runs one participant: a federate, the RTI, or an unfederated main reactor. It polls all of its sockets
//! and its wake-up until the next event's time or the next time-out, and runs the reactions itself. Nothing here
//! reads a clock or touches a socket but through [`platform::Platform`].
#![no_std]
#![forbid(unsafe_code)]

pub mod platform;
