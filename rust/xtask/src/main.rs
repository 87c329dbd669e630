// SPDX-License-Identifier: Apache-2.0
//! See ARCHITECTURE.md.
#![forbid(unsafe_code)]

fn main() {}
