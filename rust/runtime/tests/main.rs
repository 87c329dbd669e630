// SPDX-License-Identifier: Apache-2.0
//! The tests of the event loops. One program is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod alone;
mod cycles;
mod decentralized;
mod departures;
mod direct;
mod ending;
mod exchanges;
mod flow;
#[cfg(feature = "transients")]
mod handovers;
mod raw;
mod recordings;
mod releases;
mod secure;
#[cfg(feature = "datagrams")]
mod secure_datagrams;
mod strangers;
mod support;
mod traces;
mod waiting;
mod words;
mod wrong_words;
