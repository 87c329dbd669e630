// SPDX-License-Identifier: Apache-2.0
//! The tests of federations of processes. One program is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod attacks;
mod authentication;
mod boards;
mod centralized;
mod clocks;
mod decentralized;
mod devices;
mod direct;
mod encrypted;
mod failures;
mod faults;
mod flow;
mod guide;
mod ipv6;
mod launch;
mod limits;
mod links;
mod modes;
mod names;
mod oscilloscope;
mod other_rti;
mod places;
mod programs;
mod recording;
mod rti;
mod rti_survives;
mod security;
mod statuses;
mod terminal;
mod traces;
mod transients;
