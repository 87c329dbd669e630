// SPDX-License-Identifier: Apache-2.0
//! The tests of the engine. One program is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod bench;
mod bodies;
mod derive;
mod joining;
mod modes;
mod network;
mod open_tag;
mod payload;
mod physical_time;
mod reference;
mod reference_model;
mod scheduling;
mod stopping;
mod tables;
mod tardy;
mod time;
mod watchdog;
