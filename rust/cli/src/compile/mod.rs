// SPDX-License-Identifier: Apache-2.0
//! From a program to executables: where they go, what is written, how cargo is run, and what rustc says about it.

pub mod cargo;
pub mod files;
pub mod places;
pub mod progress;
pub mod rustc;
