// SPDX-License-Identifier: Apache-2.0
//! The configuration of a Zephyr image, in any language of its program: Kconfig fragments and overlays.

mod kconfig;
mod network_buffers;

pub use kconfig::KEYS_HEADER;
pub(crate) use kconfig::{federate_kconfig, overlay, rti_kconfig};
