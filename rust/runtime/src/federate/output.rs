// SPDX-License-Identifier: Apache-2.0
//! Where the engine sends to, and what it sees of the world, while a tag runs.

use lf_coordination::federate::Federate;
use lf_model::{Env, Outgoing, Outside, SendError};
use lf_wire::{PushError, Tag};

use super::link::Link;
use crate::description::{CONTROL_BYTES, TAGGED_MESSAGE_HEADER_BYTES};
use crate::platform::Platform;

/// The connection to the RTI as the engine's environment.
pub(super) struct Output<'a, 's, 'c, P> {
    platform: &'a mut P,
    link: &'a mut Link<'s>,
    machine: &'a mut Federate<'c>,
    /// Nothing is sent any more.
    silent: bool,
}

impl<'a, 's, 'c, P: Platform> Output<'a, 's, 'c, P> {
    pub(super) fn new(
        platform: &'a mut P,
        link: &'a mut Link<'s>,
        machine: &'a mut Federate<'c>,
        silent: bool,
    ) -> Self {
        Self { platform, link, machine, silent }
    }
}

impl<P: Platform> Env for Output<'_, '_, '_, P> {
    fn outside(&self) -> &'static dyn Outside {
        self.platform.outside()
    }

    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError> {
        if self.silent || !self.machine.may_send(message.tag) {
            // Nobody gets as far as this tag.
            return Ok(());
        }
        let longest = message.output.max_len.saturating_add(TAGGED_MESSAGE_HEADER_BYTES);
        if self.link.buffers.output.room() < longest.saturating_add(CONTROL_BYTES) {
            self.link.flush(self.platform);
            if self.link.buffers.output.room() < longest.saturating_add(CONTROL_BYTES) {
                return Err(SendError::NoRoom);
            }
        }
        let tag = Tag { time: message.tag.time.as_nanos(), microstep: message.tag.microstep.0 };
        let output = message.output;
        let pushed =
            self.link
                .buffers
                .output
                .push_tagged_with(output.port, output.federate, tag, output.max_len, |bytes| message.encode(bytes));
        match pushed {
            Ok(_) => {
                self.machine.sent(message.tag);
                Ok(())
            }
            Err(PushError::Payload(error)) => Err(SendError::Payload(error)),
            Err(PushError::Encode(_) | PushError::PayloadOverrun { .. }) => Err(SendError::NoRoom),
        }
    }
}
