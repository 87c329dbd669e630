// SPDX-License-Identifier: Apache-2.0
//! See ARCHITECTURE.md.
#![no_std]
#![forbid(unsafe_code)]
