// SPDX-License-Identifier: Apache-2.0
//! Serial lines.

use core::fmt;

use embedded_io::{ErrorType, Read, ReadReady, Write};
use lf_model::{PhysicalActionRef, PhysicalLink, ReactionContext};

use crate::error::{Device, DeviceError, Problem};
use crate::interrupt::{self, EventPoster, EventValue};

/// The platform's interface of a serial line.
pub trait SerialLine: Device {
    /// A value that ends the interrupts of a line when it is dropped.
    type Watch: fmt::Debug;

    /// Checks that it can be used.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    fn is_ready(&self) -> Result<(), Problem>;
    /// Sends bytes, and waits until the hardware has them.
    ///
    /// # Errors
    /// When its driver reports one.
    fn send(&self, bytes: &[u8]) -> Result<(), Problem>;
    /// Returns a received byte.
    ///
    /// # Errors
    /// When its driver reports one.
    fn receive(&self) -> Result<Option<u8>, Problem>;
    /// Lets others run while the caller waits for a byte.
    fn pause(&self);
    /// Posts each received byte, until the result is dropped, which also keeps the link. Posts without room are counted
    /// and logged.
    ///
    /// # Errors
    /// When its driver has no interrupts, or there is no room for another watch.
    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem>;
}

/// A serial line, at the speed of the devicetree.
///
/// It implements the traits `Read`, `ReadReady` and `Write` of `embedded_io`. `read` waits for a byte, and the event
/// loop with it; most programs use [`on_byte`](Uart::on_byte).
#[derive(Debug)]
pub struct Uart<L: SerialLine> {
    line: L,
    next: Option<u8>,
    watch: Option<L::Watch>,
}

impl<L: SerialLine> Uart<L> {
    /// Opens the line.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    pub fn new(line: L) -> Result<Self, DeviceError> {
        line.named(line.is_ready())?;
        Ok(Self { line, next: None, watch: None })
    }

    /// Schedules the action for each received byte from now on, at the time of its interrupt. The byte can no longer be
    /// read.
    ///
    /// A byte without room in the action's queue is counted, and the event loop logs it. While this lives, a program
    /// without events does not end.
    ///
    /// # Errors
    /// When the driver has no interrupts, or there is no room for another device with interrupts.
    pub fn on_byte<T: EventValue<u8>>(
        &mut self,
        ctx: &ReactionContext<'_>,
        action: &PhysicalActionRef<T>,
    ) -> Result<(), DeviceError> {
        interrupt::begin(&mut self.watch, ctx, action, |link, poster| self.line.named(self.line.watch(link, poster)))
    }

    /// Stops scheduling at bytes.
    pub fn ignore_bytes(&mut self) {
        self.watch = None;
    }

    fn peek(&mut self) -> Result<Option<u8>, DeviceError> {
        if self.next.is_none() && self.watch.is_none() {
            self.next = self.line.named(self.line.receive())?;
        }
        Ok(self.next)
    }
}

impl<L: SerialLine> ErrorType for Uart<L> {
    type Error = DeviceError;
}

impl<L: SerialLine> ReadReady for Uart<L> {
    fn read_ready(&mut self) -> Result<bool, DeviceError> {
        self.peek().map(|next| next.is_some())
    }
}

impl<L: SerialLine> Read for Uart<L> {
    /// # Errors
    /// When the driver reports one, or each byte schedules an action, so that none will come here.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, DeviceError> {
        let mut count = 0;
        while count < buffer.len() {
            if let Some(byte) = self.peek()? {
                buffer[count] = byte;
                self.next = None;
                count += 1;
            } else if count > 0 {
                break;
            } else if self.watch.is_some() {
                return self.line.named(Err(Problem::BytesAreEvents));
            } else {
                self.line.pause();
            }
        }
        Ok(count)
    }
}

impl<L: SerialLine> Write for Uart<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, DeviceError> {
        self.line.named(self.line.send(bytes))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }
}
