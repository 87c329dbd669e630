// SPDX-License-Identifier: Apache-2.0
//! Numbers that the image's Kconfig sets.
#![allow(clippy::unreadable_literal, reason = "the build script wrote them")]

include!(concat!(env!("OUT_DIR"), "/kconfig.rs"));
