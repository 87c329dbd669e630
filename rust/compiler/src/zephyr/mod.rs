// SPDX-License-Identifier: Apache-2.0
//! What Zephyr is told about an image, whatever its program is written in: Kconfig fragments and overlays.

mod kconfig;
mod network_buffers;

pub(crate) use kconfig::{federate_kconfig, overlay, rti_kconfig};
