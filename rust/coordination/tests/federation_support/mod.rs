// SPDX-License-Identifier: Apache-2.0
//! Random federations of this crate's federates.

pub(crate) mod graph;
pub(crate) mod participant;
