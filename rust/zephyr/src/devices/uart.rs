// SPDX-License-Identifier: Apache-2.0
//! Serial lines by Zephyr's drivers.

use core::ffi::c_int;

use lf_devices::{Device, DeviceError, EventPoster, Problem, SerialLine};
use lf_model::PhysicalLink;

use super::interrupts::{Source, Watch};
use super::spec::{Spec, outcome};
use crate::raw;

/// A serial line: see [`lf_devices::Uart`].
pub type Uart = lf_devices::Uart<UartNode>;

/// A serial line of the devicetree.
#[derive(Clone, Copy, Debug)]
pub struct UartNode {
    name: &'static str,
    device: &'static Spec<*const raw::device>,
}

impl UartNode {
    pub(crate) const fn new(name: &'static str, device: &'static Spec<*const raw::device>) -> Self {
        Self { name, device }
    }

    /// Opens the line.
    ///
    /// # Errors
    /// When its driver is missing or is not ready.
    pub fn uart(self) -> Result<Uart, DeviceError> {
        Uart::new(self)
    }
}

impl Device for UartNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl SerialLine for UartNode {
    type Watch = Watch<Bytes>;

    fn is_ready(&self) -> Result<(), Problem> {
        // SAFETY: it has no precondition.
        outcome(unsafe { raw::lf_device_ready(self.device.device()) }).map(drop)
    }

    fn send(&self, bytes: &[u8]) -> Result<(), Problem> {
        // SAFETY: its driver is ready; so it is in all calls here.
        outcome(unsafe { raw::lf_uart_send(self.device.device(), bytes.as_ptr(), bytes.len()) }).map(drop)
    }

    fn receive(&self) -> Result<Option<u8>, Problem> {
        // SAFETY: see above.
        let result = unsafe { raw::lf_uart_receive(self.device.device()) };
        // SAFETY: it has no precondition.
        if unsafe { raw::lf_uart_is_empty(result) } {
            return Ok(None);
        }
        outcome(result).map(|byte| u8::try_from(byte).ok())
    }

    fn pause(&self) {
        // SAFETY: reactions run on a thread.
        unsafe { raw::k_usleep(100) };
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem> {
        Watch::new(self.name, Bytes(self.device), link, poster)
    }
}

/// The bytes that come on a line.
#[derive(Debug)]
pub struct Bytes(&'static Spec<*const raw::device>);

impl Source for Bytes {
    fn begin(&self, slot: usize, handler: raw::lf_device_handler) -> c_int {
        // SAFETY: the driver is ready, and the handler can be called at any time.
        unsafe { raw::lf_uart_watch(slot, self.0.device(), handler) }
    }

    fn end(&self, _: usize) {
        // SAFETY: this line is watched.
        unsafe { raw::lf_uart_unwatch(self.0.device()) };
    }
}
