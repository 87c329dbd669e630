// SPDX-License-Identifier: Apache-2.0
//! A world of participants in virtual time with a seeded network, and federations of small programs in it.
#![allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::missing_panics_doc,
    clippy::unwrap_used,
    reason = "a helper of tests"
)]

pub mod federation;
pub mod lines;
pub mod node;
pub mod raw;
