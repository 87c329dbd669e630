// SPDX-License-Identifier: Apache-2.0
//! A trace in LF's own binary format, for its tools (`trace_to_csv`, `trace_to_chrome`, `fedsd`).
//!
//! The format is the memory of the C runtime's structs, as a 64-bit computer with little-endian numbers has them:
//!
//! | part | content |
//! |---|---|
//! | header | start time: i64 of nanoseconds; number of traced objects: i32, 0 for an RTI |
//! | block | number of records: i32, at most 2048; the records |
//!
//! | offset in a record | content |
//! |---|---|
//! | 0 | kind of event: i32; 4 bytes of padding |
//! | 8 | object: 8 bytes, 0 |
//! | 16, 20 | who writes: i32, -1 for the RTI; the federate at the other end: i32, -1 if it is unknown |
//! | 24, 32 | tag: time, i64 of nanoseconds; microstep, u32; 4 bytes of padding |
//! | 40 | physical time: i64 of nanoseconds |
//! | 48, 56 | trigger: 8 bytes, 0; further delay: i64, 0 |

use std::io::{self, Write};

use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::MessageType;

use super::line::{Direction, Format, MessageLine};

/// LF's tools refuse longer blocks.
const BLOCK_RECORDS: usize = 2048;
const RECORD_BYTES: usize = 64;
/// The number of a participant without an id: the RTI.
const RTI: i32 = -1;
/// The difference between the numbers for sending and for receiving a message.
const RECEIVED: i32 = 23;

/// LF's binary format.
#[derive(Default)]
pub(super) struct Lft {
    /// The records of the block that is not written yet.
    block: Vec<u8>,
}

impl Lft {
    fn write_block(&mut self, file: &mut dyn Write) -> io::Result<()> {
        let records = i32::try_from(self.block.len() / RECORD_BYTES).map_err(io::Error::other)?;
        if records > 0 {
            file.write_all(&records.to_le_bytes())?;
            file.write_all(&self.block)?;
            self.block.clear();
        }
        Ok(())
    }
}

impl Format for Lft {
    fn begin(&mut self, file: &mut dyn Write, start: i64) -> io::Result<()> {
        file.write_all(&start.to_le_bytes())?;
        file.write_all(&0_i32.to_le_bytes())
    }

    fn line(&mut self, file: &mut dyn Write, line: &MessageLine, _: i64) -> io::Result<()> {
        let Some(event) = event(line.direction, line.kind) else { return Ok(()) };
        let tag = line.tag.unwrap_or(Tag::NEVER);
        let federate = line.federate.map_or(-1, i32::from);
        self.block.extend(event.to_le_bytes());
        self.block.extend([0; 4 + 8]);
        self.block.extend(RTI.to_le_bytes());
        self.block.extend(federate.to_le_bytes());
        self.block.extend(tag.time.as_nanos().to_le_bytes());
        self.block.extend(tag.microstep.0.to_le_bytes());
        self.block.extend([0; 4]);
        self.block.extend(line.now.as_nanos().to_le_bytes());
        self.block.extend([0; 8 + 8]);
        if self.block.len() == BLOCK_RECORDS * RECORD_BYTES { self.write_block(file) } else { Ok(()) }
    }

    fn end(&mut self, file: &mut dyn Write) -> io::Result<()> {
        self.write_block(file)
    }
}

/// Returns LF's number for a message; `None` for some of the handshake and of clock synchronization.
fn event(direction: Direction, kind: MessageType) -> Option<i32> {
    let sent = match kind {
        MessageType::Ack => 11,
        MessageType::Failed => 12,
        MessageType::Timestamp => 13,
        MessageType::NextEventTag => 14,
        MessageType::LatestTagComplete => 15,
        MessageType::StopRequest => 16,
        MessageType::StopReply => 17,
        MessageType::StopGranted => 18,
        MessageType::FedIds | MessageType::TransientFedIds => 19,
        MessageType::ProvisionalTagGrant => 20,
        MessageType::TagGrant => 21,
        MessageType::Reject => 22,
        MessageType::Resign => 23,
        MessageType::PortAbsent => 24,
        MessageType::TaggedMessage => 26,
        MessageType::AddressAdvertisement => 30,
        MessageType::AddressQuery => 31,
        MessageType::AddressQueryReply | MessageType::AddressQueryReplyIpv6 => 32,
        MessageType::DownstreamNextEventTag => 33,
        _ => return None,
    };
    Some(match direction {
        Direction::Sent => sent,
        Direction::Received => sent + RECEIVED,
    })
}

#[cfg(test)]
mod tests {
    use lf_linux::model::time::{Instant, Microstep};

    use super::*;

    const START: i64 = 1_700_000_000_000_000_000;

    fn line(direction: Direction, kind: MessageType, federate: Option<u16>, tag: Option<Tag>) -> MessageLine {
        MessageLine { now: Instant::from_nanos(START + 5), direction, federate, kind, tag, to: None, bytes: 0 }
    }

    fn written(lines: &[MessageLine]) -> Vec<u8> {
        let (mut file, mut format) = (Vec::new(), Lft::default());
        format.begin(&mut file, START).expect("a vector takes all");
        for line in lines {
            format.line(&mut file, line, START).expect("a vector takes all");
        }
        format.end(&mut file).expect("a vector takes all");
        file
    }

    /// Reads an integer at this offset, as a C program would.
    fn int(bytes: &[u8], offset: usize) -> i32 {
        i32::from_le_bytes(bytes[offset..offset + 4].try_into().expect("they are 4"))
    }

    fn long(bytes: &[u8], offset: usize) -> i64 {
        i64::from_le_bytes(bytes[offset..offset + 8].try_into().expect("they are 8"))
    }

    #[test]
    fn each_field_lies_where_the_c_runtime_has_it() {
        let tag = Tag { time: Instant::from_nanos(START + 3), microstep: Microstep(u32::MAX) };
        let bytes = written(&[
            line(Direction::Sent, MessageType::TagGrant, Some(7), Some(tag)),
            line(Direction::Received, MessageType::Resign, None, None),
        ]);
        assert_eq!((long(&bytes, 0), int(&bytes, 8)), (START, 0), "start time, traced objects");
        assert_eq!(int(&bytes, 12), 2, "records in the first block");
        assert_eq!(bytes.len(), 16 + 2 * 64);
        let (first, second) = bytes[16..].split_at(64);
        assert_eq!((int(first, 0), int(first, 4)), (21, 0), "event and padding");
        assert_eq!(long(first, 8), 0, "object");
        assert_eq!((int(first, 16), int(first, 20)), (-1, 7), "source and destination");
        assert_eq!(long(first, 24), START + 3, "logical time");
        assert_eq!((int(first, 32), int(first, 36)), (-1, 0), "microstep, all bits set, and padding");
        assert_eq!(long(first, 40), START + 5, "physical time");
        assert_eq!((long(first, 48), long(first, 56)), (0, 0), "trigger and further delay");
        assert_eq!((int(second, 0), int(second, 20)), (46, -1), "nobody has said who it is");
        assert_eq!((long(second, 24), int(second, 32)), (i64::MIN, 0), "no tag is NEVER");
    }

    #[test]
    fn blocks_are_no_longer_than_the_tools_take() {
        let lines: Vec<MessageLine> =
            (0..2049).map(|_| line(Direction::Sent, MessageType::TagGrant, Some(0), None)).collect();
        let bytes = written(&lines);
        let second = 12 + 4 + 2048 * 64;
        assert_eq!((int(&bytes, 12), int(&bytes, second)), (2048, 1));
        assert_eq!(bytes.len(), second + 4 + 64);
        assert_eq!(written(&lines[..2048]).len(), second, "no empty block follows a full one");
    }

    #[test]
    fn messages_without_a_number_are_left_out() {
        for kind in [MessageType::UdpPort, MessageType::NeighborStructure, MessageType::T1, MessageType::FedNonce] {
            assert_eq!(event(Direction::Received, kind), None);
        }
        assert_eq!(event(Direction::Received, MessageType::DownstreamNextEventTag), Some(56), "the last number");
        assert_eq!(written(&[]).len(), 12);
    }
}
