// SPDX-License-Identifier: Apache-2.0
//! The RTI (run-time infrastructure): the centre of a federation.

mod delay;
mod graph;
mod in_transit;
