// SPDX-License-Identifier: Apache-2.0
//! The platform for Zephyr, and the library of generated images.
//!
//! It calls C, so it contains `unsafe`, like `lf-c`, and `lf-embedded` for static memory, but no other crate. bindgen
//! makes the bindings of these calls from the very headers that the image is compiled with. This crate does not
//! allocate: sockets and threads have static slots whose numbers Kconfig sets.
//!
//! A generated crate names this one `lf`. It is linked as a static library, and declares its program with [`main!`] and
//! its RTI with [`rti!`]; the application's `main()` runs both through the C API of `c_api`.
#![no_std]

#[cfg(CONFIG_LF_NETWORK)]
mod address;
mod c_api;
pub mod clock;
#[doc(hidden)]
pub mod console;
mod critical;
pub mod devices;
pub mod kconfig;
#[cfg(not(CONFIG_LF_NETWORK))]
mod local;
mod logger;
mod macros;
mod mutex;
#[cfg(CONFIG_LF_NETWORK)]
mod net;
mod outside;
mod panic;
mod pause;
#[cfg(CONFIG_LF_NETWORK)]
mod platform;
pub mod prelude;
mod raw;
#[doc(hidden)]
pub mod recording;
#[cfg(CONFIG_LF_RTI)]
#[doc(hidden)]
pub mod rti;
#[cfg(CONFIG_LF_SECURITY)]
mod security;
pub mod settings;
pub mod thread;
#[cfg(feature = "traces")]
mod trace;
mod wake;

pub use c_api::Federate;
#[doc(hidden)]
pub use lf_embedded::run;
#[cfg(feature = "c")]
pub mod c;
pub use lf_model as model;
pub use lf_runtime as runtime;
#[cfg(not(CONFIG_LF_NETWORK))]
pub use local::{LocalPlatform as ZephyrPlatform, LocalPlatform as ImagePlatform};
pub use log;
#[cfg(CONFIG_LF_NETWORK)]
pub use platform::ZephyrPlatform;
#[cfg(all(CONFIG_LF_NETWORK, not(CONFIG_LF_SECURITY)))]
pub use platform::ZephyrPlatform as ImagePlatform;
#[cfg(CONFIG_LF_SECURITY)]
pub use security::EncryptedPlatform as ImagePlatform;
pub use thread::SpawnPhysicalThread;
pub use wake::wake;
