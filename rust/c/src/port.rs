// SPDX-License-Identifier: Apache-2.0
//! Ports, and the queues that fill them.
use lf_model as model;
use lf_model::{
    Full, ModeCell, PayloadError, Placed, PortId, ReactionContext, Tag, TriggerCell, TriggerId, Undelivered,
};

use crate::ffi;
use crate::running::physical_time;
use crate::token::Token;

/// A reference to a port, which lies in C.
#[derive(Clone, Copy, Debug)]
pub struct Port {
    id: PortId,
}

impl Port {
    /// Returns the port with this number.
    ///
    /// # Panics
    /// When C has no such port.
    pub fn new(id: PortId) -> Self {
        // SAFETY: generated code has this constant.
        let count = unsafe { ffi::lf_port_count };
        assert!(id.0 < count, "C has no port {}", id.0);
        Self { id }
    }

    fn is_present(self) -> bool {
        // SAFETY: there is such a port.
        unsafe { ffi::lf_c_port_is_present(self.id.0) }
    }

    /// Drops the value, for [`model::Program::clear_port`].
    pub fn clear(self) {
        // SAFETY: there is such a port.
        unsafe { ffi::lf_c_port_clear(self.id.0) };
    }

    /// Writes the value as bytes, as the C runtime sends it; returns their number.
    ///
    /// # Errors
    /// When there is no value, or the bytes do not fit.
    pub fn encode(self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        if !self.is_present() {
            return Err(PayloadError::Absent);
        }
        let available = bytes.len();
        // SAFETY: there is such a port, and this much room behind the pointer.
        let needed = unsafe { ffi::lf_c_port_encode(self.id.0, bytes.as_mut_ptr(), available) };
        if needed > available { Err(PayloadError::NoRoom { needed, available }) } else { Ok(needed) }
    }

    /// Shows the value of a queue, which was intended for a tag.
    fn fill(self, value: Option<Token>, intended: Tag) {
        if let Some(token) = value {
            // SAFETY: there is such a port, and it gets the share of `token`.
            unsafe { ffi::lf_c_port_fill(self.id.0, token.into_raw(), intended.into()) };
        }
    }

    /// Returns the value of a port for the connection with a delay that ends here.
    fn capture(self, source: Self, trigger: TriggerId) -> Result<Token, PayloadError> {
        // SAFETY: there are such ports and such a trigger; the source is present, and passes on a share of its value.
        let token = unsafe { Token::from_raw(ffi::lf_c_port_capture(source.id.0, self.id.0, trigger.0)) };
        token.ok_or(PayloadError::Absent)
    }

    /// Returns the value in the bytes of a message.
    fn decode(self, trigger: TriggerId, bytes: &[u8]) -> Result<Token, PayloadError> {
        let (mut expected, found) = (0, bytes.len());
        // SAFETY: there is such a port, and the pointer and the length are those of a slice.
        match unsafe { ffi::lf_c_port_check(self.id.0, bytes.as_ptr(), found, &raw mut expected) } {
            ffi::BYTES_GOOD => {}
            ffi::BYTES_LENGTH => return Err(PayloadError::Length { expected, found }),
            ffi::BYTES_REMAINDER => return Err(PayloadError::Remainder { element: expected, found }),
            _ => return Err(PayloadError::Nul),
        }
        let arrival = physical_time().as_nanos();
        // SAFETY: the same; the bytes are good, and C passes on the only share of the value.
        let token =
            unsafe { Token::from_raw(ffi::lf_c_port_decode(self.id.0, trigger.0, bytes.as_ptr(), found, arrival)) };
        token.ok_or(PayloadError::NotDeserialized)
    }
}

/// Sets a port to the value of another one, if that has one: a connection in a mode.
pub fn copy(ctx: &mut ReactionContext<'_>, from: Port, to: Port) {
    if from.is_present() {
        // SAFETY: there are such ports, and the first one is present.
        unsafe { ffi::lf_c_port_copy(from.id.0, to.id.0) };
        ctx.mark_present(to.id);
    }
}

/// A port with the model's queue of the same name, which fills it.
macro_rules! queued_port {
    ($(#[$attribute:meta])* $name:ident) => {
        $(#[$attribute])*
        pub struct $name<const N: usize> {
            port: Port,
            trigger: TriggerId,
            queue: model::$name<Token, N>,
        }

        impl<const N: usize> $name<N> {
            /// Returns an empty queue; the ids are those of the port that it fills and of its own.
            ///
            /// # Panics
            /// When C has no such port or queue.
            pub fn new(port: PortId, trigger: TriggerId) -> Self {
                assert!(ffi::lf_c_has_trigger(trigger.0), "C has no queue {}", trigger.0);
                Self { port: Port::new(port), trigger, queue: model::$name::new(port) }
            }
        }

        impl<const N: usize> TriggerCell for $name<N> {
            fn activate(&mut self, tag: Tag) -> Option<Tag> {
                let next = self.queue.activate(tag);
                self.port.fill(self.queue.port.take(), self.intended().unwrap_or(tag));
                next
            }
            /// Does nothing: the engine clears the port as a port.
            fn clear(&mut self) {}
            fn pending(&self) -> Option<Tag> {
                TriggerCell::pending(&self.queue)
            }
            fn has_room(&self) -> bool {
                self.queue.has_room()
            }
            fn intended(&self) -> Option<Tag> {
                TriggerCell::intended(&self.queue)
            }
        }
    };
}

queued_port!(
    /// A port with the queue that fills it: the end of a connection with `after`, or of one from another federate.
    QueuedPort
);

queued_port!(
    /// A port with the queue that fills it: the end of a connection from another federate whose messages can be tardy.
    TardyInput
);

impl<const N: usize> QueuedPort<N> {
    /// Takes the value of the connection's source, to arrive at `tag` or, when another one does, a microstep later.
    ///
    /// # Errors
    /// When the queue is full.
    pub fn capture(&mut self, tag: Tag, source: &Port) -> Result<(), Full> {
        if !source.is_present() {
            return Ok(());
        }
        let (port, trigger) = (self.port, self.trigger);
        match self.queue.put(tag, || port.capture(*source, trigger)) {
            Err(Undelivered::Full(full)) => Err(full),
            _ => Ok(()),
        }
    }

    /// Takes a message from another federate, to arrive at `tag` or, when another one does, a microstep later.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        let (port, trigger) = (self.port, self.trigger);
        self.queue.put(tag, || port.decode(trigger, bytes))
    }
}

impl<const N: usize> ModeCell for QueuedPort<N> {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.queue.shift(from, to)
    }
    fn discard(&mut self) {
        self.queue.discard();
    }
}

impl<const N: usize> TardyInput<N> {
    /// Takes a message from another federate, to take effect at `tag`; see [`model::TardyInput::deliver_tardy`].
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver_tardy(&mut self, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        let (port, trigger) = (self.port, self.trigger);
        self.queue.put(tag, intended, || port.decode(trigger, bytes))
    }

    /// Takes a message that is in time.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.deliver_tardy(tag, tag, bytes).map(|_| ())
    }
}
