// SPDX-License-Identifier: Apache-2.0
//! An unfederated program with bodies in C: a timer, a physical action that a thread and an interrupt schedule, and a
//! logical one whose values are arrays.
#![no_std]

pub mod federate;

lf::main!(federate::Main);
