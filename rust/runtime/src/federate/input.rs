// SPDX-License-Identifier: Apache-2.0
//! What comes from the RTI, and the messages that have to wait for room.
//!
//! All comes on one connection, so the grant that lets a full queue empty itself may lie behind messages for that very
//! queue. Therefore a message without room is held where it lies, and what comes behind it is looked at: messages for
//! other queues and what the RTI says of the federation are taken out of their turn, and a grant counts at once up to
//! just before the earliest message that is held. This changes nothing that the program sees, since events are ordered
//! by tag and no tag is begun before all of its messages are in their queues. Nor does it change what the RTI is told:
//! the earliest message that is held counts for the next event like those in the queues.
//!
//! When the buffer is full of held messages and none of them can move, no grant can ever be read: that is certain, and
//! an error that names the input.

use lf_coordination::federate::{Awaited, Disconnected, Event, Federate, FederateError};
use lf_coordination::{from_wire, to_wire};
use lf_model::time::{EventTag, Instant, Tag};
use lf_model::{DeliverError, Engine, InputId, Program};
use lf_wire::{DecodeError, Decoded, InBuffer, Limits, Message, decode, destination_in_header};

use super::link::Arrival;
use super::peers::Peers;
use super::{FederateLoop, is_decentralized};
use crate::error::RunError;
use crate::platform::Platform;

/// The messages at the front of the input buffer that have been looked at, and wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// How many bytes they have.
    bytes: usize,
    /// The earliest of their tags.
    earliest: Tag,
    /// The input for which the first of them is.
    input: Option<InputId>,
    /// Some of them are for something else.
    mixed: bool,
    /// Some of them may have room now.
    stale: bool,
    /// A grant behind them reaches their earliest tag.
    granted: bool,
}

impl Held {
    /// Nothing is held.
    pub(super) const NONE: Self =
        Self { bytes: 0, earliest: Tag::FOREVER, input: None, mixed: false, stale: false, granted: false };

    /// A tag has been begun, which takes its events out of their queues: there is room for others.
    ///
    /// All that is held is then looked at from the front. As room comes about in no other way, a message never
    /// overtakes an earlier one for the same input.
    pub(super) fn look_again(&mut self) {
        self.stale = self.input.is_some();
    }

    /// Lets go what is held, if it may have room now. How many bytes at the front all are messages for one input, so
    /// that none of them has room when the first has not: a long queue of them need not be looked at after each tag.
    pub(super) fn release(&mut self) -> usize {
        if !self.stale {
            return 0;
        }
        let alike = if self.mixed { 0 } else { self.bytes };
        *self = Self::NONE;
        alike
    }

    /// The earliest tag of a message that is held; FOREVER if none is.
    pub(super) fn earliest(&self) -> Tag {
        self.earliest
    }

    /// The input for which the first message is that is held.
    pub(super) fn input(&self) -> Option<InputId> {
        self.input
    }

    /// Whether a grant behind the held messages reaches their earliest tag.
    pub(super) fn is_granted(&self) -> bool {
        self.granted
    }

    /// Whether [`FederateLoop::handle_messages`] is to be called though nothing has come.
    pub(super) fn is_stale(&self) -> bool {
        self.stale
    }

    /// How many bytes are held.
    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }

    /// The message stays where it is.
    pub(super) fn hold(&mut self, bytes: usize, tag: Tag, input: Option<InputId>) {
        self.mixed |= self.bytes > 0 && self.input != input;
        self.bytes += bytes;
        self.earliest = self.earliest.min(tag);
        self.input = self.input.or(input);
    }
}

/// What is to become of a message now.
enum Turn {
    /// It is handled.
    Take,
    /// It waits for room in the queue of its input.
    Hold(Tag, InputId),
    /// It is a grant, of which this much counts already.
    Partly(Tag),
    /// It waits until all before it is handled.
    Wait,
    /// It says up to which tag nothing comes at an input, and this much of that counts already.
    PartlyAbsent(u16, Tag),
}

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Reads what has come and handles it, as far as there is room for it.
    pub(super) fn receive(&mut self) -> Result<(), RunError> {
        let arrival = self.link.fill(self.platform);
        self.handle_messages()?;
        if arrival == Arrival::End {
            // What is still held is of no use any more: nothing can be granted.
            match self.machine.handle_disconnected()? {
                Disconnected::ConnectAgain => self.link.begin_anew(self.platform),
                Disconnected::Ended => self.link.close(self.platform),
            }
        }
        Ok(())
    }

    /// Handles the messages in the input buffer that have not been looked at; bounded by its size.
    fn handle_messages(&mut self) -> Result<(), RunError> {
        // What lies between the messages for inputs has to be looked at in any case.
        self.held.release();
        let now = self.platform.now();
        loop {
            let input = &self.link.buffers.input;
            let next = next_at(input, self.held.bytes, &self.limits).map_err(|error| {
                let bytes = input.bytes().get(self.held.bytes..).unwrap_or_default();
                let phase = self.machine.phase();
                too_long(bytes, error, &self.engine).unwrap_or(RunError::Bytes { error, phase })
            });
            let Some((message, length)) = next? else { return Ok(()) };
            match turn(&message, &self.engine, self.program, &self.held, self.machine.granted()) {
                Turn::Hold(tag, input) => self.held.hold(length, tag, Some(input)),
                Turn::Partly(tag) => {
                    self.machine.handle_message(now, Message::TagGrant(to_wire(tag)))?;
                    self.held.granted = true;
                    self.held.hold(length, Tag::FOREVER, None);
                }
                Turn::Wait => self.held.hold(length, Tag::FOREVER, None),
                Turn::PartlyAbsent(port, tag) => {
                    self.awaited.learn(port, tag);
                    self.held.hold(length, Tag::FOREVER, None);
                }
                Turn::Take => {
                    let mut hands = Hands {
                        platform: &mut *self.platform,
                        machine: &mut self.machine,
                        awaited: &mut self.awaited,
                        engine: &mut self.engine,
                        program: &mut *self.program,
                        peers: &mut self.peers,
                        peers_out: self.federation.peers_out,
                        meeting: &mut self.meeting,
                    };
                    let last_tag_changed = hands.take(now, message)?;
                    self.link.buffers.input.remove(self.held.bytes, length);
                    if last_tag_changed && self.held.input.is_some() {
                        // What is held may be for after the last tag now, and then needs no room.
                        self.held = Held::NONE;
                    }
                    self.say_early();
                }
            }
        }
    }
}

/// The message behind the first `offset` bytes, if it is whole.
pub(super) fn next_at<'b>(
    buffer: &'b InBuffer<&mut [u8]>,
    offset: usize,
    limits: &Limits,
) -> Result<Option<(Message<'b>, usize)>, DecodeError> {
    if offset == 0 {
        return buffer.next(limits);
    }
    match decode(buffer.bytes().get(offset..).unwrap_or_default(), limits)? {
        Decoded::Complete { message, len } => Ok(Some((message, len))),
        Decoded::Incomplete { .. } => Ok(None),
    }
}

/// What is to become of a message behind held ones, when so much is granted.
fn turn(message: &Message<'_>, engine: &Engine<'_>, program: &mut dyn Program, held: &Held, granted: Tag) -> Turn {
    let (behind, held) = (held.bytes > 0, held.earliest);
    match *message {
        Message::TaggedMessage { port, tag, .. } => {
            let (tag, input) = (from_wire(tag), InputId(port));
            // What comes after the last tag needs no room, and for an input that is not there it is an error.
            let needs_room = tag <= engine.stop_tag() && usize::from(port) < engine.tables().inputs.len();
            if needs_room && !engine.has_room(program, input) { Turn::Hold(tag, input) } else { Turn::Take }
        }
        // It takes back what was granted before, which may be among what is held.
        Message::ProvisionalTagGrant(tag) if behind && from_wire(tag) <= granted => Turn::Wait,
        Message::TagGrant(tag) | Message::ProvisionalTagGrant(tag) => {
            let tag = from_wire(tag);
            if tag < held || held == Tag::FOREVER { Turn::Take } else { Turn::Partly(held.before()) }
        }
        Message::PortAbsent { port, tag, .. } => {
            // One of the held messages may be for this very input.
            let tag = from_wire(tag);
            if tag < held || held == Tag::FOREVER { Turn::Take } else { Turn::PartlyAbsent(port, held.before()) }
        }
        _ => Turn::Take,
    }
}

/// A message that comes too late or too early is reported with the name of its connection, which tells more than the
/// number of the input.
fn name_input(error: FederateError, engine: &Engine<'_>) -> RunError {
    let named = |port: u16| engine.tables().inputs.get(usize::from(port)).map(|input| input.name);
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

/// What is true of a message that is too long for the receive buffer: it is a message, and no value of its input.
pub(super) fn too_long(bytes: &[u8], error: DecodeError, engine: &Engine<'_>) -> Option<RunError> {
    if !matches!(error, DecodeError::OverLimit { .. } | DecodeError::LargerThanBuffer { .. }) {
        return None;
    }
    let header = destination_in_header(bytes)?;
    let (port, bytes) = (header.port, header.payload_bytes);
    match engine.tables().inputs.get(usize::from(port)) {
        Some(input) => Some(RunError::TooLong { input: input.name, bytes, max: input.max_len }),
        None => Some(DeliverError::NoSuchPort { port }.into()),
    }
}

/// The parts of the loop that a message changes, apart from the buffer in which it lies.
struct Hands<'a, 'c, 's, P> {
    platform: &'a mut P,
    machine: &'a mut Federate<'c>,
    awaited: &'a mut Awaited<'s>,
    engine: &'a mut Engine<'s>,
    program: &'a mut dyn Program,
    peers: &'a mut Peers<'s>,
    peers_out: &'a [u16],
    meeting: &'a mut Option<usize>,
}

impl<P: Platform> Hands<'_, '_, '_, P> {
    /// Handles a message. Gives whether the last tag may be another one now.
    fn take(&mut self, now: Instant, message: Message<'_>) -> Result<bool, RunError> {
        match self.machine.handle_message(now, message).map_err(|error| name_input(error, self.engine))? {
            Event::Message { port, tag, payload } => {
                self.deliver(InputId(port), tag, payload)?;
                self.awaited.learn(port, tag);
            }
            Event::PortAbsent { port, tag } | Event::MessageAfterStop { port, tag } => self.awaited.learn(port, tag),
            Event::ClockCorrected(estimate) => {
                log::debug!("initial clock synchronization: {estimate}");
                self.platform.set_correction(self.machine.clock());
            }
            Event::PeerFound { federate, address } => {
                let index = self.peers_out.iter().position(|peer| *peer == federate.0);
                log::debug!("connecting to federate {federate} at {address}");
                *self.meeting = index;
                self.peers.connect(self.platform, index.unwrap_or(usize::MAX), address);
            }
            Event::Started(start) => self.start(start),
            Event::StopGranted(tag) => {
                log::debug!("the federation stops at {tag}");
                self.engine.set_stop_tag(tag);
                return Ok(true);
            }
            Event::Accepted => log::debug!("the RTI has accepted this federate"),
            Event::None | Event::Granted(_) | Event::GrantedProvisionally(_) | Event::StopRequested(_) => {}
        }
        Ok(false)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, payload: &[u8]) -> Result<(), RunError> {
        let start = self.engine.start_time();
        self.engine.deliver(self.program, input, tag, payload).map_err(|error| match error {
            DeliverError::Late { input, tag, current } => {
                let (tag, current) = (EventTag::relative(tag, start), EventTag::relative(current, start));
                RunError::Late { input, tag, current }
            }
            error => error.into(),
        })
    }

    fn start(&mut self, start: Instant) {
        log::debug!("the federation starts");
        self.engine.start(start);
        if self.engine.stop_tag() < Tag::FOREVER {
            self.machine.limit_stop(self.engine.stop_tag());
        }
        if is_decentralized(self.machine.coordination()) {
            let inputs = self.engine.tables().inputs;
            self.awaited.start(Tag::at(start), |port| inputs.get(usize::from(port)).and_then(|input| input.delay));
        }
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use lf_model::{
        Interval, NetworkInput, PortId, PortInfo, Settings, Storage, Tables, TriggerId, TriggerInfo, TriggerKind,
    };

    use super::*;

    const TABLES: Tables = Tables {
        reactions: &[],
        triggers: &[TriggerInfo { name: "b.y", kind: TriggerKind::NetworkInput { fills: PortId(0) }, reactions: &[] }],
        ports: &[PortInfo { name: "b.y", reactions: &[], delays: &[] }],
        outputs: &[],
        inputs: &[NetworkInput {
            name: "a.x -> b.y",
            trigger: TriggerId(0),
            federate: 0,
            delay: None,
            max_len: 4,
            level: 0,
            awaited: true,
            physical: false,
            tardy: false,
            max_wait: Interval::ZERO,
            absent_after: Interval::ZERO,
            readers: &[],
        }],
        absence: &[],
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
