// SPDX-License-Identifier: Apache-2.0
//! Messages of another federate over a direct connection: values, absences, and nothing else. A value that comes too
//! late is delivered all the same, and counted.

use lf_coordination::federate::Needs;
use lf_coordination::from_wire;
use lf_model::time::{Instant, Tag};
use lf_model::{DeliverError, Delivery, InputId};
use lf_wire::{DecodeError, Message, MessageType};

use super::execution::{Execution, Failed};
use super::held::Held;
use super::late::Late;
use super::receiver::{Disposition, Policy, too_long};
use crate::error::{PeerFault, RunError};
use crate::platform::Platform;
use crate::trace::{Event, Recording, TracedMessage};

/// The parts that such a message changes.
pub(super) struct FromPeer<'x, 'a, 's, P, N: Needs> {
    pub(super) platform: &'x mut P,
    pub(super) recording: Recording<'x>,
    pub(super) execution: &'x mut Execution<'a, 's, N>,
    pub(super) late: &'x mut Late,
    /// The sender's id, and this federate's.
    pub(super) from: u16,
    pub(super) to: u16,
    /// Whether the sender has ended its physical connections.
    pub(super) physical_over: &'x mut bool,
    /// The federation's physical time.
    pub(super) now: Instant,
}

impl<P: Platform, N: Needs> Policy for FromPeer<'_, '_, '_, P, N> {
    fn expects(message_type: MessageType) -> bool {
        match message_type {
            MessageType::P2pMessage => N::UNTAGGED,
            MessageType::P2pTaggedMessage | MessageType::PortAbsent => true,
            _ => false,
        }
    }

    fn take(&mut self, message: Message<'_>, _: &Held) -> Result<Disposition, Failed> {
        let (port, federate, tag) = match message {
            Message::P2pMessage { port, federate, .. } if N::UNTAGGED => (port, federate, None),
            Message::P2pTaggedMessage { port, federate, tag, .. } => {
                let tag = from_wire(tag);
                if !tag.is_finite() {
                    return Err(self.fault(PeerFault::WrongTag { port }));
                }
                (port, federate, Some(tag))
            }
            Message::PortAbsent { port, federate, tag } => (port, federate, Some(from_wire(tag))),
            _ => return Err(self.fault(PeerFault::Unexpected(message.message_type()))),
        };
        let tables = self.execution.engine.tables();
        // The sender ends every connection separately.
        let is_end = matches!(message, Message::PortAbsent { .. }) && tag == Some(Tag::FOREVER);
        let fits = |input: &InputId| {
            let input = &tables.inputs[usize::from(input.0)];
            federate == self.to && input.federate == self.from && (is_end || input.physical == tag.is_none())
        };
        let Some(input) = tables.input_of(port).filter(fits) else {
            return Err(self.fault(PeerFault::WrongInput { federate, port }));
        };
        #[cfg(feature = "transients")]
        if let (Message::P2pTaggedMessage { .. }, Some(tag)) = (message, tag)
            && self.execution.machine.misses(tag)
        {
            return Ok(Disposition::Taken);
        }
        if !self.execution.engine.is_done() && self.execution.lacks_room(input, tag) {
            if self.recording.is_on() {
                self.recording.note(self.platform, Event::Held(TracedMessage::of(&message, self.from)));
            }
            return Ok(Disposition::Held(tag.unwrap_or(Tag::FOREVER), Some(input)));
        }
        self.recording.note_received(self.platform, &message, self.from);
        let Execution { engine, program, awaited, failure, .. } = &mut *self.execution;
        match (message, tag) {
            (Message::P2pTaggedMessage { payload, .. }, Some(tag)) => {
                let delivery = engine.deliver_tardy(&mut **program, input, tag, payload);
                let delivery = delivery.map_err(|error| fail(failure, error))?;
                awaited.learn(input.0, happens(delivery).unwrap_or(tag));
                let lateness = self.now.duration_since(tag.time);
                self.late.report(engine, self.to, input, (tag, lateness), delivery);
            }
            (Message::P2pMessage { payload, .. }, _) if N::UNTAGGED => {
                let delivery = engine.deliver_physical(&mut **program, input, self.now, payload);
                delivery.map_err(|error| fail(failure, error))?;
            }
            (_, Some(_)) if N::UNTAGGED && tables.inputs[usize::from(input.0)].physical => *self.physical_over = true,
            (_, Some(tag)) => awaited.learn(input.0, tag),
            (_, None) => {}
        }
        Ok(Disposition::Taken)
    }

    fn refuse(&mut self, bytes: &[u8], error: DecodeError) -> Failed {
        if let DecodeError::Unexpected { message } = error {
            return self.fault(PeerFault::Unexpected(message));
        }
        match too_long(bytes, error, &self.execution.engine) {
            Some(error) => self.execution.fail(error),
            None => self.fault(PeerFault::Bytes(error)),
        }
    }
}

impl<P, N: Needs> FromPeer<'_, '_, '_, P, N> {
    fn fault(&mut self, fault: PeerFault) -> Failed {
        self.execution.fail(RunError::Peer { federate: self.from, fault })
    }
}

/// Stores why a message cannot be delivered.
fn fail(failure: &mut Option<RunError>, error: DeliverError) -> Failed {
    *failure = Some(error.into());
    Failed
}

/// Returns the tag at which a message takes effect, if it does.
fn happens(delivery: Delivery) -> Option<Tag> {
    match delivery {
        Delivery::InTime(tag) | Delivery::Tardy(tag) => Some(tag),
        Delivery::AfterStop | Delivery::Lost => None,
    }
}
