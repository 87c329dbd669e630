// SPDX-License-Identifier: Apache-2.0
//! Messages of the RTI.
//!
//! All of them come on one connection, so the grant that lets a full queue empty itself may lie behind messages for
//! that very queue. Therefore messages for other queues and control messages are handled out of order, and a grant
//! counts at once up to just before the earliest held message. This does not change what the RTI learns: the earliest
//! held message counts for the next event like those in the queues.
//!
//! When the buffer is full of held messages and none of them can move, no grant can ever be read: that is certain, and
//! an error that names the input.

use lf_coordination::federate::{Event, FederateError, Needs};
use lf_coordination::{Endpoint, FederateId, from_wire, to_wire};
use lf_model::time::{EventTag, Instant, Tag};
use lf_model::{DeliverError, Engine};
use lf_wire::{DecodeError, Message, MessageType};
#[cfg(feature = "transients")]
use lf_wire::{HANDED_OVER_PORT, destination_in_header};

use super::clock_sync::set_correction;
use super::execution::{Execution, Failed};
use super::held::Held;
use super::receiver::{Disposition, Policy, too_long};
use crate::error::RunError;
use crate::platform::Platform;
use crate::trace::{Event as Traced, RTI, Recording};

/// The parts that such a message changes.
pub(super) struct FromRti<'x, 'a, 's, P, N: Needs> {
    pub(super) platform: &'x mut P,
    pub(super) recording: Recording<'x>,
    pub(super) execution: &'x mut Execution<'a, 's, N>,
    /// A federate to connect to, when the RTI has sent its address.
    pub(super) found: &'x mut Option<(FederateId, Endpoint)>,
    /// A transient federate to which this one sends directly, and whether it has come or left.
    #[cfg(feature = "transients")]
    pub(super) peer: &'x mut Option<(FederateId, bool)>,
    /// Whether the RTI has refused this federate, because its id is in use.
    pub(super) refused: &'x mut bool,
    pub(super) now: Instant,
}

impl<P: Platform, N: Needs> Policy for FromRti<'_, '_, '_, P, N> {
    const HOLDS: bool = N::INPUTS;

    fn expects(message_type: MessageType) -> bool {
        match message_type {
            MessageType::TaggedMessage => N::INPUTS || N::TRANSIENTS,
            // This is also the answer to the question by which the federate limits its flow.
            MessageType::PortAbsent => N::CENTRALIZED,
            MessageType::RtiResponse => N::AUTHENTICATION,
            MessageType::T1 | MessageType::T4 => N::CLOCK_SYNC,
            #[cfg(feature = "ipv6")]
            MessageType::AddressQueryReplyIpv6 => true,
            #[cfg(feature = "transients")]
            MessageType::UpstreamConnected
            | MessageType::Stop
            | MessageType::OutboundConnected
            | MessageType::OutboundDisconnected => N::TRANSIENTS,
            MessageType::Reject
            | MessageType::Ack
            | MessageType::Timestamp
            | MessageType::TagGrant
            | MessageType::ProvisionalTagGrant
            | MessageType::DownstreamNextEventTag
            | MessageType::UpstreamDisconnected
            | MessageType::StopRequest
            | MessageType::StopGranted
            | MessageType::AddressQueryReply
            | MessageType::Failed => true,
            _ => false,
        }
    }

    #[cfg(feature = "transients")]
    fn awaits_effective_start(&self) -> bool {
        self.execution.machine.start_time().is_none() && self.execution.machine.is_transient()
    }

    fn take(&mut self, message: Message<'_>, held: &Held) -> Result<Disposition, Failed> {
        let (behind, earliest) = (held.bytes > 0, held.earliest);
        let is_before = |tag: Tag| tag < earliest || earliest == Tag::FOREVER;
        match message {
            #[cfg(feature = "transients")]
            Message::TaggedMessage { port: HANDED_OVER_PORT, payload, .. } if N::TRANSIENTS => {
                self.execution.take_over(payload);
                return Ok(Disposition::Taken);
            }
            _ if !N::INPUTS => {}
            Message::TaggedMessage { port, tag, .. } => {
                let tag = from_wire(tag);
                // For an input that does not exist it is an error.
                if let Some(input) = self.execution.engine.tables().input_of(port)
                    && self.execution.lacks_room(input, Some(tag))
                {
                    return Ok(Disposition::Held(tag, Some(input)));
                }
            }
            // It revokes earlier grants, which may be among the held messages.
            Message::ProvisionalTagGrant(tag)
                if N::CYCLES && behind && from_wire(tag) <= self.execution.machine.granted() =>
            {
                return Ok(Disposition::Held(Tag::FOREVER, None));
            }
            // This much of it counts already.
            Message::TagGrant(tag) | Message::ProvisionalTagGrant(tag) if !is_before(from_wire(tag)) => {
                let granted = Message::TagGrant(to_wire(earliest.before()));
                let result = self.execution.machine.handle_message(self.now, granted);
                result.map_err(|error| self.execution.fail(error.into()))?;
                return Ok(Disposition::HeldGrant);
            }
            // Some of the held messages may come from the federate that has left.
            Message::UpstreamDisconnected { federate } if N::CYCLES && !is_before(Tag::FOREVER) => {
                self.learn_from(federate, earliest.before());
                return Ok(Disposition::Held(Tag::FOREVER, None));
            }
            // It takes effect at once, and again behind the departure before it, which may be held.
            #[cfg(feature = "transients")]
            Message::UpstreamConnected { federate } if N::CYCLES && !is_before(Tag::FOREVER) => {
                self.execution.upstream_comes(federate);
                return Ok(Disposition::Held(Tag::FOREVER, None));
            }
            // One of the held messages may be for this very input.
            Message::PortAbsent { port, tag, .. } if !is_before(from_wire(tag)) => {
                self.learn(port, earliest.before());
                return Ok(Disposition::Held(Tag::FOREVER, None));
            }
            _ => {}
        }
        self.handle(message)
    }

    #[cfg(feature = "transients")]
    fn skips(&self, bytes: &[u8]) -> Option<usize> {
        let header = destination_in_header(bytes).filter(|header| N::TRANSIENTS && header.port == HANDED_OVER_PORT)?;
        log::warn!("the instance that this one replaces hands over a state which is too long for this one");
        let payload = usize::try_from(header.payload_bytes).unwrap_or(usize::MAX);
        Some(MessageType::TaggedMessage.fixed_bytes().saturating_add(payload))
    }

    fn refuse(&mut self, bytes: &[u8], error: DecodeError) -> Failed {
        let phase = self.execution.phase();
        if let DecodeError::Unexpected { message } = error {
            return self.execution.fail(FederateError::Unexpected { message, phase }.into());
        }
        let too_long = if N::INPUTS { too_long(bytes, error, &self.execution.engine) } else { None };
        self.execution.fail(too_long.unwrap_or(RunError::Bytes { error, phase }))
    }
}

impl<P: Platform, N: Needs> FromRti<'_, '_, '_, P, N> {
    fn handle(&mut self, message: Message<'_>) -> Result<Disposition, Failed> {
        self.recording.note_received(self.platform, &message, RTI);
        let result = self.execution.machine.handle_message(self.now, message);
        let event = result.map_err(|error| {
            let error = if N::INPUTS { name_input(error, &self.execution.engine) } else { error.into() };
            self.execution.fail(error)
        })?;
        let Execution { machine, engine, .. } = &mut *self.execution;
        match event {
            Event::Message { .. } | Event::PortAbsent { .. } | Event::MessageAfterStop { .. } if !N::INPUTS => {}
            Event::Message { port, tag, payload } => {
                self.deliver(port, tag, payload)?;
                self.learn(port, tag);
            }
            Event::PortAbsent { port, tag } | Event::MessageAfterStop { port, tag } => self.learn(port, tag),
            Event::UpstreamLeft(_) if !N::CYCLES => {}
            Event::UpstreamLeft(federate) => self.learn_from(federate.0, Tag::FOREVER),
            Event::ClockCorrected(estimate) => {
                log::debug!("initial clock synchronization: {estimate}");
                set_correction(self.platform, &mut self.recording, machine.clock());
            }
            Event::PeerFound { federate, address } => *self.found = Some((federate, address)),
            Event::Started(start) => {
                self.platform.outside().starts(start);
                self.recording.note(self.platform, Traced::Starts(start, engine.settings().fast));
                self.execution.start(start);
            }
            #[cfg(feature = "transients")]
            Event::Joined { start, tag } => {
                self.platform.outside().starts(start);
                self.recording.note(self.platform, Traced::Starts(start, engine.settings().fast));
                self.execution.join(start, tag);
            }
            #[cfg(feature = "transients")]
            Event::GrantedProvisionally(tag) if self.execution.machine.misses(tag) => {
                self.execution.passed = Some((tag, 0));
            }
            #[cfg(feature = "transients")]
            Event::UpstreamCame(federate) => self.execution.upstream_comes(federate.0),
            #[cfg(feature = "transients")]
            Event::Replaced => {
                log::info!("the RTI tells this federate to leave: it stops alone");
                self.execution.stop_alone(self.now);
            }
            #[cfg(feature = "transients")]
            Event::PeerCame(federate) => *self.peer = Some((federate, true)),
            #[cfg(feature = "transients")]
            Event::PeerLeft(federate) => *self.peer = Some((federate, false)),
            Event::StopGranted(tag) => {
                self.execution.stop(self.now, tag);
                // Held messages may be for after the last tag now.
                return Ok(Disposition::TakenForAll);
            }
            Event::IdInUse => {
                *self.refused = true;
            }
            Event::Accepted => log::debug!("the RTI has accepted this federate"),
            Event::None | Event::Granted(_) | Event::GrantedProvisionally(_) | Event::StopRequested(_) => {}
        }
        Ok(Disposition::Taken)
    }

    /// Records that a port is known up to this tag.
    fn learn(&mut self, port: u16, tag: Tag) {
        if let Some(input) = self.execution.engine.tables().input_of(port) {
            self.execution.awaited.learn(input.0, tag);
        }
    }

    /// Records that all inputs from a federate are known up to this tag.
    fn learn_from(&mut self, federate: u16, tag: Tag) {
        let inputs = (0..).zip(self.execution.engine.tables().inputs);
        for (input, _) in inputs.filter(|(_, input)| input.federate == federate) {
            self.execution.awaited.learn(input, tag);
        }
    }

    fn deliver(&mut self, port: u16, tag: Tag, payload: &[u8]) -> Result<(), Failed> {
        let Execution { engine, program, .. } = &mut *self.execution;
        let start = engine.start_time();
        let input = engine.tables().input_of(port).ok_or(DeliverError::NoSuchPort { port });
        let result = input.and_then(|input| engine.deliver(&mut **program, input, tag, payload));
        result.map_err(|error| {
            self.execution.fail(match error {
                DeliverError::Late { input, tag, current } => {
                    let (tag, current) = (EventTag::relative(tag, start), EventTag::relative(current, start));
                    RunError::Late { input, tag, current }
                }
                error => error.into(),
            })
        })
    }
}

/// Names the connection of a message that comes too late or too early, which says more than the number of the input.
fn name_input(error: FederateError, engine: &Engine<'_>) -> RunError {
    let tables = engine.tables();
    let named = |port: u16| tables.input_of(port).map(|input| tables.inputs[usize::from(input.0)].name);
    match error {
        FederateError::LateMessage { port, tag, current } => {
            named(port).map_or(error.into(), |input| RunError::Late { input, tag, current })
        }
        FederateError::BeforeStart { port, by } => {
            named(port).map_or(error.into(), |input| RunError::BeforeStart { input, by })
        }
        _ => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use lf_model::{
        EngineStorage as _, NetworkInput, PortId, PortInfo, Settings, Storage, Tables, TriggerInfo, TriggerKind,
    };

    use super::*;

    const TABLES: Tables = Tables {
        triggers: &[TriggerInfo { name: "b.y", kind: TriggerKind::NetworkInput { fills: PortId(0) }, reactions: &[] }],
        ports: &[PortInfo { name: "b.y", reactions: &[], delays: &[] }],
        inputs: &[NetworkInput { name: "a.x -> b.y", max_len: 4, level: 0, awaited: true, ..NetworkInput::DEFAULT }],
        ..Tables::DEFAULT
    };
    const _: () = TABLES.check();

    #[test]
    fn a_late_message_is_named_by_its_connection() {
        let mut storage = Storage::<1, 1, 1, 1>::new();
        let engine = Engine::new(&TABLES, &mut storage, Settings::DEFAULT);
        let (tag, current) = (EventTag::new(Duration::ZERO, 0), EventTag::new(Duration::ZERO, 1));
        let named = name_input(FederateError::LateMessage { port: 0, tag, current }, &engine);
        assert_eq!(named, RunError::Late { input: "a.x -> b.y", tag, current });
        let unknown = FederateError::LateMessage { port: 7, tag, current };
        assert_eq!(name_input(unknown, &engine), RunError::Federate(unknown));
        assert_eq!(name_input(FederateError::RtiFailed, &engine), RunError::Federate(FederateError::RtiFailed));
    }
}
