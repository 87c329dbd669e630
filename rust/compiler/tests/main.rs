// SPDX-License-Identifier: Apache-2.0
//! The tests of the compiler. One program is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod characters;
mod documents;
mod fail;
mod foreign;
mod format;
mod last_tag;
mod many;
mod names;
mod native;
mod nesting;
mod plans;
mod robust;
mod security;
mod wide;
