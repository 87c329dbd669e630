// SPDX-License-Identifier: Apache-2.0
//! An unfederated program as the compiler writes it: a timer, and a physical action that a thread schedules.
#![no_std]

pub mod federate;

lf::main!(federate::Main);
