// SPDX-License-Identifier: Apache-2.0
//! Observes the connections between federates: the messages that were sent, and the time at which each had arrived.

use std::collections::{BTreeMap, VecDeque};

use lf_coordination::from_wire;
use lf_model::Payload as _;
use lf_model::time::Tag;
use lf_wire::{Decoded, Limits, Message, decode};

use super::Violation;
use crate::program::Value;

/// A message from federate to federate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sent {
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) port: usize,
    pub(crate) tag: Tag,
    /// The number of its value.
    pub(crate) number: u64,
    /// The virtual times at which its last byte arrived in the receiver's socket, and at which the receiver read it.
    pub(crate) arrives: u64,
    pub(crate) read: Option<u64>,
    /// The position of its end in the stream.
    end: usize,
}

/// The numbers of messages that a write completed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Written {
    pub(super) data: u64,
    pub(super) absent: u64,
}

#[derive(Debug, Default)]
struct Stream {
    from: usize,
    to: usize,
    /// The bytes of an incomplete message, and the number of bytes before them.
    bytes: Vec<u8>,
    passed: usize,
    read: usize,
    /// Messages that were not read yet.
    unread: VecDeque<usize>,
}

/// All connections between federates.
#[derive(Debug, Default)]
pub(crate) struct Direct {
    streams: BTreeMap<usize, Stream>,
    /// The messages in the order in which they were written.
    pub(crate) sent: Vec<Sent>,
}

impl Direct {
    pub(super) fn begin(&mut self, connection: usize, from: usize, to: usize) {
        self.streams.insert(connection, Stream { from, to, ..Stream::default() });
    }

    pub(super) fn has(&self, connection: usize) -> bool {
        self.streams.contains_key(&connection)
    }

    /// Notes bytes that the sender has written, and the time at which they arrive.
    pub(super) fn write(
        &mut self,
        connection: usize,
        bytes: &[u8],
        (now, arrives): (u64, u64),
        prints: bool,
    ) -> Result<Written, Violation> {
        let mut written = Written::default();
        let Some(stream) = self.streams.get_mut(&connection) else { return Ok(written) };
        stream.bytes.extend_from_slice(bytes);
        let mut at = 0;
        loop {
            let decoded = decode(&stream.bytes[at..], &Limits::NONE);
            let decoded = decoded.map_err(|error| Violation::Bytes { federate: stream.from, error: error.to_string() });
            let Decoded::Complete { message, len } = decoded? else { break };
            at += len;
            if prints {
                println!("{now:12} f{} -> f{} {message:?}, arrives {arrives}", stream.from, stream.to);
            }
            match message {
                Message::P2pTaggedMessage { port, tag: wire, payload, .. } => {
                    written.data += 1;
                    stream.unread.push_back(self.sent.len());
                    self.sent.push(Sent {
                        from: stream.from,
                        to: stream.to,
                        port: usize::from(port),
                        tag: from_wire(wire),
                        number: Value::decode(payload).map_or(0, Value::number),
                        arrives,
                        read: None,
                        end: stream.passed + at,
                    });
                }
                Message::PortAbsent { .. } => written.absent += 1,
                Message::P2pSendingFedId { .. } => {}
                other => {
                    let error = format!("{} came from another federate", other.name());
                    return Err(Violation::Bytes { federate: stream.from, error });
                }
            }
        }
        stream.passed += at;
        stream.bytes.drain(..at);
        Ok(written)
    }

    /// Notes that the receiver has read this number of bytes.
    pub(super) fn read(&mut self, connection: usize, count: usize, now: u64) {
        let Some(stream) = self.streams.get_mut(&connection) else { return };
        stream.read += count;
        while let Some(message) = stream.unread.front().map(|index| &mut self.sent[*index])
            && message.end <= stream.read
        {
            message.read = Some(now);
            stream.unread.pop_front();
        }
    }
}
