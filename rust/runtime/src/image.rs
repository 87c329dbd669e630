// SPDX-License-Identifier: Apache-2.0
//! The errors that end the program of an image for a board early, or an RTI.
//!
//! The image is not this crate's, but its sentences are here, so that the computer beside it can decode them.

use core::fmt;

use lf_coordination::rti::{Outcome, SetupError};
use lf_texts::say;

use crate::error::RunError;
use crate::platform::NetError;

/// An error that ends the program of an image early.
#[derive(Debug)]
pub enum ImageError {
    /// Zephyr has no event descriptor left, which wakes the event loop up.
    Descriptor,
    /// A setting is invalid.
    Settings(SettingsError),
    /// The event loop ended early.
    Run(RunError),
    /// The program was started before, and its memory is in use.
    Running,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Descriptor => {
                say!(
                    f,
                    "no event descriptor is left, as other code of the image has them: raise CONFIG_ZVFS_EVENTFD_MAX"
                )
            }
            Self::Settings(error) => error.fmt(f),
            Self::Run(error) => error.fmt(f),
            Self::Running => say!(f, "lf_main() can be called only once"),
        }
    }
}

impl core::error::Error for ImageError {}

/// A setting that cannot be used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SettingsError {
    /// The address of the RTI is not an address of a family that the image has.
    RtiAddress,
    /// The port of the RTI is not one.
    RtiPort(u32),
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RtiAddress => {
                say!(
                    f,
                    "CONFIG_LF_RTI_ADDRESS (-lf-rti-address) has to be an address such as 10.0.0.1, or fd00::1 in an \
                     image with CONFIG_NET_IPV6"
                )
            }
            Self::RtiPort(port) => say!(f, "the RTI's port is {port}, but has to be one of 1 to 65535"),
        }
    }
}

impl core::error::Error for SettingsError {}

/// An error that ends an RTI early.
#[derive(Debug)]
pub enum RtiError {
    /// A setting is invalid.
    Settings(SettingsError),
    /// The port cannot be listened on.
    Listen {
        /// The port.
        port: u16,
        /// The system's error.
        error: NetError,
    },
    /// No UDP port can be opened for clock synchronization.
    Bind(NetError),
    /// Its configuration and memory do not fit together.
    Setup(SetupError),
    /// The federation did not end in order.
    Ended(Outcome),
    /// The steps were called in a wrong order, or twice.
    Order,
}

impl fmt::Display for RtiError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settings(error) => error.fmt(f),
            Self::Listen { port, error } => {
                say!(
                    f,
                    "the RTI cannot listen on TCP port {port}: {error}; choose another one (-p, CONFIG_LF_RTI_PORT)"
                )
            }
            Self::Bind(error) => say!(f, "the RTI cannot open a UDP port for clock synchronization: {error}"),
            Self::Setup(error) => error.fmt(f),
            Self::Ended(outcome) => outcome.fmt(f),
            Self::Order => say!(f, "lf_rti_listen() and lf_rti_main() can be called only once, in this order"),
        }
    }
}

impl core::error::Error for RtiError {}
