// SPDX-License-Identifier: Apache-2.0
//! A world of participants in virtual time with a seeded network, and federations of small programs in it.

pub(crate) mod federation;
pub(crate) mod keys;
pub(crate) mod lines;
pub(crate) mod node;
pub(crate) mod profiles;
pub(crate) mod raw;
