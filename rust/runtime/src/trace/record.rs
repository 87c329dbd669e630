// SPDX-License-Identifier: Apache-2.0
//! Records as bytes: 32 of them, little-endian, the same on every system.
//!
//! | bytes | content |
//! |---|---|
//! | 0–7 | the time, in nanoseconds of the participant's clock |
//! | 8–15, 16–19 | the tag: its time and its microstep; or a time, or a number |
//! | 20–23 | a number of bytes |
//! | 24 | the kind |
//! | 25 | a detail of the kind: of a message, its type byte on the wire |
//! | 26–27 | a federate |
//! | 28–29 | an input, a trigger, a reaction, or the receiver of a value |
//! | 30–31 | a worker, or the input of that federate |
//!
//! A part of a value (kinds 16 and 17, the last part) has its bytes in 8–23 and 26–31, and their number in 25.

use lf_model::time::{Instant, Microstep, Tag};
use lf_model::{Part, TriggerId};
use lf_wire::MessageType;

use super::event::{CHUNK_BYTES, Chunk, Event, TracedMessage, WaitLimit, Waits, has_tag};
use super::header::{Bytes, Damage, RECORD_BYTES};

/// An event and its time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Record {
    /// The time of the participant's clock; [`Event::Clock`] relates it to the federation's time.
    pub at: Instant,
    /// The event.
    pub event: Event,
}

/// The fields of a record that an event fills.
#[derive(Default)]
struct Fields {
    kind: u8,
    detail: u8,
    time: i64,
    microstep: u32,
    bytes: u32,
    peer: u16,
    port: u16,
    lane: u16,
}

/// The kinds of a part of a value, and of its last one.
const DATA: u8 = 16;
const LAST_DATA: u8 = 17;

impl Fields {
    fn new(kind: u8) -> Self {
        Self { kind, ..Self::default() }
    }

    /// Sets the tag, or zeros.
    fn tag(self, tag: impl Into<Option<Tag>>) -> Self {
        let tag = tag.into();
        let (time, microstep) = tag.map_or((0, 0), |tag| (tag.time.as_nanos(), tag.microstep.0));
        Self { time, microstep, ..self }
    }

    fn message(kind: u8, message: TracedMessage) -> Self {
        let ((port, lane), detail) = (message.to, message.kind.byte());
        Self { detail, bytes: message.bytes, peer: message.peer, port, lane, ..Self::new(kind) }.tag(message.tag)
    }

    fn waits(waits: Waits) -> Self {
        let (detail, tag, port, lane) = match waits {
            Waits::Anything => (0, None, 0, 0),
            Waits::Time(tag) => (1, Some(tag), 0, 0),
            Waits::Start => (2, None, 0, 0),
            Waits::Grant(tag) => (3, Some(tag), 0, 0),
            Waits::Input(tag, input, limit) => (4, Some(tag), input, u16::from(limit == WaitLimit::Limited)),
            Waits::Room(tag, peer) => (5, Some(tag), peer, 0),
            Waits::End => (6, None, 0, 0),
        };
        Self { detail, port, lane, ..Self::new(9) }.tag(tag)
    }

    fn to_waits(&self) -> Option<Waits> {
        let tag = self.to_tag();
        Some(match self.detail {
            0 => Waits::Anything,
            1 => Waits::Time(tag),
            2 => Waits::Start,
            3 => Waits::Grant(tag),
            4 => Waits::Input(tag, self.port, if self.lane == 0 { WaitLimit::Endless } else { WaitLimit::Limited }),
            5 => Waits::Room(tag, self.port),
            6 => Waits::End,
            _ => return None,
        })
    }

    fn to_tag(&self) -> Tag {
        Tag { time: Instant::from_nanos(self.time), microstep: Microstep(self.microstep) }
    }

    fn to_message(&self) -> Option<TracedMessage> {
        let kind = MessageType::from_byte(self.detail)?;
        let tag = has_tag(kind).then(|| self.to_tag());
        Some(TracedMessage { kind, peer: self.peer, to: (self.port, self.lane), tag, bytes: self.bytes })
    }

    fn of(event: Event) -> Self {
        match event {
            Event::Clock(time) => Self { time: time.as_nanos(), ..Self::new(1) },
            Event::Starts(time, fast) => Self { time: time.as_nanos(), detail: fast.into(), ..Self::new(2) },
            Event::TagBegins(tag) => Self::new(3).tag(tag),
            Event::TagEnds(tag) => Self::new(4).tag(tag),
            Event::ReactionBegins(reaction, part, lane) => {
                let detail = match part {
                    Part::Body => 0,
                    Part::MissedDeadline => 1,
                    Part::Tardy => 2,
                };
                Self { detail, port: reaction, lane, ..Self::new(5) }
            }
            Event::ReactionEnds(port, lane) => Self { port, lane, ..Self::new(6) },
            Event::Sent(message) => Self::message(7, message),
            Event::Received(message) => Self::message(8, message),
            Event::WaitBegins(waits) => Self::waits(waits),
            Event::WaitEnds => Self::new(10),
            Event::Ends(failed) => Self { detail: failed.into(), ..Self::new(11) },
            Event::Lost(count) => Self { time: count.cast_signed(), ..Self::new(12) },
            Event::Seam => Self::new(13),
            Event::Due(time) => Self { time: time.as_nanos(), ..Self::new(14) },
            Event::Held(message) => Self::message(15, message),
            Event::Physical(trigger) => Self { port: trigger.0, ..Self::new(18) },
            // They have encodings of their own.
            Event::Begins(_) | Event::Data(_) => Self::default(),
        }
    }

    fn to_event(&self) -> Option<Event> {
        Some(match self.kind {
            1 => Event::Clock(Instant::from_nanos(self.time)),
            2 => Event::Starts(Instant::from_nanos(self.time), self.detail != 0),
            3 => Event::TagBegins(self.to_tag()),
            4 => Event::TagEnds(self.to_tag()),
            5 => {
                let part = match self.detail {
                    0 => Part::Body,
                    1 => Part::MissedDeadline,
                    2 => Part::Tardy,
                    _ => return None,
                };
                Event::ReactionBegins(self.port, part, self.lane)
            }
            6 => Event::ReactionEnds(self.port, self.lane),
            7 => Event::Sent(self.to_message()?),
            8 => Event::Received(self.to_message()?),
            9 => Event::WaitBegins(self.to_waits()?),
            10 => Event::WaitEnds,
            11 => Event::Ends(self.detail != 0),
            12 => Event::Lost(self.time.cast_unsigned()),
            13 => Event::Seam,
            14 => Event::Due(Instant::from_nanos(self.time)),
            15 => Event::Held(self.to_message()?),
            18 => Event::Physical(TriggerId(self.port)),
            _ => return None,
        })
    }
}

impl Record {
    /// Returns the record as bytes; of [`Event::Begins`], the header.
    pub fn to_bytes(self) -> [u8; RECORD_BYTES] {
        match self.event {
            Event::Begins(header) => return header.to_bytes(),
            Event::Data(chunk) => return chunk_to_bytes(self.at, &chunk),
            _ => {}
        }
        let mut bytes = Bytes([0; RECORD_BYTES]);
        let fields = Fields::of(self.event);
        bytes.put(0, self.at.as_nanos().to_le_bytes());
        bytes.put(8, fields.time.to_le_bytes());
        bytes.put(16, fields.microstep.to_le_bytes());
        bytes.put(20, fields.bytes.to_le_bytes());
        bytes.put(24, [fields.kind, fields.detail]);
        bytes.put(26, fields.peer.to_le_bytes());
        bytes.put(28, fields.port.to_le_bytes());
        bytes.put(30, fields.lane.to_le_bytes());
        bytes.0
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`Damage::Kind`] when its kind is unknown.
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Result<Self, Damage> {
        let bytes = Bytes(*bytes);
        let at = Instant::from_nanos(i64::from_le_bytes(bytes.get(0)));
        if let DATA | LAST_DATA = bytes.0[24] {
            return Ok(Self { at, event: Event::Data(chunk_from(&bytes).ok_or(Damage::Kind(bytes.0[24]))?) });
        }
        let number = |at| u16::from_le_bytes(bytes.get(at));
        let fields = Fields {
            time: i64::from_le_bytes(bytes.get(8)),
            microstep: u32::from_le_bytes(bytes.get(16)),
            bytes: u32::from_le_bytes(bytes.get(20)),
            kind: bytes.0[24],
            detail: bytes.0[25],
            peer: number(26),
            port: number(28),
            lane: number(30),
        };
        let event = fields.to_event().ok_or(Damage::Kind(fields.kind))?;
        Ok(Self { at, event })
    }
}

/// Returns a part of a value as bytes.
fn chunk_to_bytes(at: Instant, chunk: &Chunk) -> [u8; RECORD_BYTES] {
    let (mut bytes, mut part) = (Bytes([0; RECORD_BYTES]), [0; CHUNK_BYTES]);
    let len = chunk.bytes().len();
    part[..len].copy_from_slice(chunk.bytes());
    bytes.put(0, at.as_nanos().to_le_bytes());
    bytes.0[8..24].copy_from_slice(&part[..16]);
    // A part has at most this many bytes.
    bytes.put(24, [if chunk.is_last { LAST_DATA } else { DATA }, u8::try_from(len).unwrap_or(u8::MAX)]);
    bytes.0[26..].copy_from_slice(&part[16..]);
    bytes.0
}

/// Reads a part of a value; `None` if its length exceeds a record.
fn chunk_from(bytes: &Bytes) -> Option<Chunk> {
    let mut part = [0; CHUNK_BYTES];
    part[..16].copy_from_slice(&bytes.0[8..24]);
    part[16..].copy_from_slice(&bytes.0[26..]);
    Some(Chunk::new(part.get(..usize::from(bytes.0[25]))?, bytes.0[24] == LAST_DATA))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::header::{Header, Role};
    use super::*;

    proptest! {
        /// Every record survives writing and reading, and no bytes make reading panic.
        #[test]
        fn records_are_the_same_when_they_are_read_again(
            mut bytes: [u8; RECORD_BYTES],
            kind in 0u8..20,
            detail in 0u8..32,
        ) {
            (bytes[24], bytes[25]) = (kind, detail);
            if let Ok(record) = Record::from_bytes(&bytes) {
                prop_assert_eq!(Record::from_bytes(&record.to_bytes()), Ok(record));
            }
        }

        /// A value of any length is the same after its parts are joined.
        #[test]
        fn a_value_is_the_same_when_its_parts_are_read_again(value in proptest::collection::vec(0u8.., 0..100)) {
            let mut found = std::vec::Vec::new();
            let mut ends = 0;
            for chunk in Chunk::of(&value) {
                let record = Record { at: Instant::from_nanos(5), event: Event::Data(chunk) };
                let read = Record::from_bytes(&record.to_bytes());
                prop_assert_eq!(read, Ok(record));
                prop_assert_eq!(ends, 0, "nothing follows the last part");
                found.extend(chunk.bytes());
                ends += usize::from(chunk.is_last);
            }
            prop_assert_eq!((found, ends), (value, 1));
        }

        #[test]
        fn headers_are_the_same_when_they_are_read_again(id: u16, role in 0..3, sizes: [u16; 3]) {
            let role = [Role::Federate(id), Role::Rti, Role::Program][usize::try_from(role).unwrap_or(0)];
            let header = Header { role, sizes };
            prop_assert_eq!(Header::from_bytes(&header.to_bytes()), Ok(header));
        }
    }

    /// Files of older releases are read by these numbers.
    #[test]
    fn every_event_has_a_kind_of_its_own_and_is_read_again() {
        let (time, tag) = (Instant::from_nanos(7), Tag { time: Instant::from_nanos(8), microstep: Microstep(9) });
        let kind = MessageType::TaggedMessage;
        let message = TracedMessage { kind, peer: 1, to: (2, 3), tag: Some(tag), bytes: 4 };
        let waits = [
            Waits::Anything,
            Waits::Time(tag),
            Waits::Start,
            Waits::Grant(tag),
            Waits::Input(tag, 5, WaitLimit::Limited),
            Waits::Room(tag, 6),
            Waits::End,
            Waits::Input(tag, 5, WaitLimit::Endless),
        ];
        let parts = [Part::Body, Part::MissedDeadline, Part::Tardy];
        let events = [
            (1, Event::Clock(time)),
            (2, Event::Starts(time, true)),
            (2, Event::Starts(time, false)),
            (3, Event::TagBegins(tag)),
            (4, Event::TagEnds(tag)),
            (6, Event::ReactionEnds(5, 6)),
            (7, Event::Sent(message)),
            (8, Event::Received(message)),
            (10, Event::WaitEnds),
            (11, Event::Ends(true)),
            (11, Event::Ends(false)),
            (12, Event::Lost(u64::MAX)),
            (13, Event::Seam),
            (14, Event::Due(time)),
            (15, Event::Held(message)),
            (16, Event::Data(Chunk::new(&[1; CHUNK_BYTES], false))),
            (17, Event::Data(Chunk::new(&[2], true))),
            (18, Event::Physical(TriggerId(5))),
        ];
        let reactions = parts.map(|part| (5, Event::ReactionBegins(5, part, 6)));
        let waits = waits.map(|waits| (9, Event::WaitBegins(waits)));
        for (kind, event) in events.into_iter().chain(reactions).chain(waits) {
            let record = Record { at: Instant::from_nanos(3), event };
            let bytes = record.to_bytes();
            assert_eq!((Record::from_bytes(&bytes), bytes[24]), (Ok(record), kind));
        }
        let header = Header { role: Role::Federate(1), sizes: [2, 3, 4] };
        let begins = Record { at: Instant::from_nanos(3), event: Event::Begins(header) };
        assert_eq!(begins.to_bytes(), header.to_bytes());
    }

    #[test]
    fn a_message_of_every_type_is_read_again_with_its_tag() {
        let some = Tag::at(Instant::from_nanos(7));
        for kind in MessageType::ALL.iter().copied() {
            let message = TracedMessage { kind, peer: 1, to: (2, 3), tag: has_tag(kind).then_some(some), bytes: 4 };
            let record = Record { at: Instant::from_nanos(9), event: Event::Received(message) };
            assert_eq!(Record::from_bytes(&record.to_bytes()), Ok(record));
        }
    }
}
