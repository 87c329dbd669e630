// SPDX-License-Identifier: Apache-2.0
//! One raw federate: it has an event in every period, sends messages at each, and waits for its grants.

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{SystemTime, UNIX_EPOCH};

use lf_wire::{DELAY_NONE, Decoded, Limits, Message, NeighborStructure, Tag, UDP_PORT_CLOCK_SYNC_OFF, decode};

use crate::link::Link;
use crate::{Access, FEDERATION, Graph, Result};

/// The maximum number of bytes in one read.
const READ_BYTES: usize = 1 << 14;

/// The load that every federate produces.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// The time from one event to the next, in nanoseconds of logical time.
    pub period_ns: i64,
    /// The number of messages over each connection at each event.
    pub messages: u32,
    /// The number of rounds of events by which federates without upstream federates may be ahead of the slowest one. It
    /// stands for physical time, for which they would wait.
    pub rounds_ahead: u64,
}

/// One raw federate.
#[derive(Debug)]
pub struct Peer {
    link: Link,
    load: Load,
    waits_for_grants: bool,
    downstream: Vec<(u16, i64)>,
    input: Vec<u8>,
    output: Vec<u8>,
    start: i64,
    /// The tags of messages that have arrived and are not handled.
    arrived: BTreeSet<Tag>,
    granted: Tag,
    announced: Option<Tag>,
    current: Tag,
    /// The number of completed rounds of events.
    pub(crate) round: u64,
    /// The number of received messages.
    pub(crate) received: u64,
    /// The number of received TAGs and PTAGs.
    pub(crate) grants: u64,
    /// Whether it has resigned.
    pub(crate) left: bool,
    /// Whether the RTI has closed the connection.
    pub(crate) ended: bool,
}

impl Peer {
    /// Connects and performs the handshake, up to the start barrier.
    ///
    /// # Errors
    /// When the RTI does not answer as it should.
    pub fn join(rti: Access, id: u16, graph: &Graph, load: Load) -> Result<Self> {
        let link = Link::new(rti, id)?;
        let (upstream, downstream) = (graph.upstream(id), graph.downstream(id));
        let mut peer = Self {
            link,
            load,
            waits_for_grants: !upstream.is_empty(),
            downstream,
            input: Vec::new(),
            output: Vec::new(),
            start: 0,
            arrived: BTreeSet::new(),
            granted: Tag::NEVER,
            announced: None,
            current: Tag::NEVER,
            round: 0,
            received: 0,
            grants: 0,
            left: false,
            ended: false,
        };
        peer.say(&Message::FedIds { federate: id, federation_id: FEDERATION.as_bytes() })?;
        peer.write_all()?;
        let mut answer = [0];
        peer.link.read_exact(&mut answer)?;
        if decode(&answer, &Limits::NONE) != Ok(Decoded::Complete { message: Message::Ack, len: 1 }) {
            return Err(format!("the RTI does not accept federate {id}").into());
        }
        let ids: Vec<u16> = peer.downstream.iter().map(|(id, _)| *id).collect();
        peer.say(&Message::NeighborStructure(NeighborStructure::new(&upstream, &ids)))?;
        peer.say(&Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF))?;
        peer.write_all()?;
        Ok(peer)
    }

    /// Sends the time of its clock.
    ///
    /// # Errors
    /// When the connection broke.
    pub fn send_clock(&mut self) -> Result<()> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos();
        self.say(&Message::Timestamp(i64::try_from(now)?))?;
        self.write_all()
    }

    /// Waits for the start time.
    ///
    /// # Errors
    /// When something else comes, or nothing.
    pub fn await_start(&mut self) -> Result<()> {
        let mut bytes = [0; 9];
        self.link.read_exact(&mut bytes)?;
        match decode(&bytes, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::Timestamp(start), .. }) => {
                self.start = start;
                Ok(())
            }
            other => Err(format!("the RTI does not tell the start time, but {other:?}").into()),
        }
    }

    /// Returns its connection, for what is said without its rules.
    pub(crate) fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    pub(crate) fn stream(&self) -> &TcpStream {
        self.link.stream()
    }

    /// Returns whether only the others' progress keeps it from its next event.
    pub(crate) fn is_source(&self) -> bool {
        !self.waits_for_grants
    }

    pub(crate) fn has_output(&self) -> bool {
        !self.output.is_empty()
    }

    /// Returns the tag of its own event of a round.
    pub(crate) fn tag_of(&self, round: u64) -> Tag {
        let rounds = i64::try_from(round).unwrap_or(i64::MAX);
        Tag::new(self.start.saturating_add(rounds.saturating_mul(self.load.period_ns)), 0)
    }

    pub(crate) fn say(&mut self, message: &Message<'_>) -> Result<()> {
        let end = self.output.len();
        self.output.resize(end + message.encoded_len(), 0);
        message.encode(&mut self.output[end..])?;
        Ok(())
    }

    /// Reads the received bytes.
    pub(crate) fn read(&mut self) -> Result<()> {
        let mut buffer = [0; READ_BYTES];
        match self.link.read(&mut buffer) {
            Ok(0) => self.ended = true,
            Ok(count) if self.input.is_empty() => {
                let rest = self.hear_all(&buffer[..count])?;
                self.input.extend_from_slice(&buffer[count - rest..count]);
            }
            Ok(count) => {
                let mut input = std::mem::take(&mut self.input);
                input.extend_from_slice(&buffer[..count]);
                let rest = self.hear_all(&input)?;
                input.drain(..input.len() - rest);
                self.input = input;
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            // The RTI closes a connection that has resigned, whatever is unread.
            Err(_) if self.left => self.ended = true,
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    /// Writes as much of the output as the system accepts.
    pub(crate) fn write(&mut self) -> Result<()> {
        while !self.output.is_empty() {
            match self.link.write(&self.output) {
                Ok(count) if count == self.output.len() => self.output.clear(),
                Ok(count) => drop(self.output.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) if self.left => self.output.clear(),
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    fn write_all(&mut self) -> Result<()> {
        self.link.write_all(&self.output)?;
        self.output.clear();
        Ok(())
    }

    /// Handles all whole messages. Returns the number of bytes that are left.
    fn hear_all(&mut self, mut bytes: &[u8]) -> Result<usize> {
        while let Decoded::Complete { message, len } = decode(bytes, &Limits::NONE)? {
            self.hear(&message)?;
            bytes = &bytes[len..];
        }
        Ok(bytes.len())
    }

    fn hear(&mut self, message: &Message<'_>) -> Result<()> {
        match *message {
            Message::TaggedMessage { tag, .. } => {
                if tag <= self.current {
                    return Err(format!("a message at {tag} comes after {}", self.current).into());
                }
                self.received += 1;
                self.arrived.insert(tag);
            }
            Message::TagGrant(tag) | Message::ProvisionalTagGrant(tag) => {
                self.grants += 1;
                self.granted = self.granted.max(tag);
            }
            Message::StopRequest(tag) => {
                let reply = tag.max(Tag::new(self.current.time, self.current.microstep + 1));
                self.say(&Message::StopReply(reply))?;
            }
            Message::StopGranted(_) => {
                self.say(&Message::NextEventTag(Tag::FOREVER))?;
                self.say(&Message::Resign)?;
                self.left = true;
            }
            Message::DownstreamNextEventTag(_) | Message::UpstreamDisconnected { .. } => {}
            ref other => return Err(format!("the RTI should not send {}", other.name()).into()),
        }
        Ok(())
    }

    /// Requests a stop of the federation.
    pub(crate) fn ask_to_stop(&mut self) -> Result<()> {
        self.say(&Message::StopRequest(Tag::new(self.current.time, self.current.microstep + 1)))
    }

    /// Runs all tags that it may run; a federate without a limit from upstream does not go beyond a round.
    pub(crate) fn advance(&mut self, last_round: u64) -> Result<()> {
        while !self.left {
            let timer = self.tag_of(self.round);
            let next = self.arrived.first().map_or(timer, |arrived| timer.min(*arrived));
            let may = if self.waits_for_grants { next <= self.granted } else { self.round <= last_round };
            if !may {
                if self.announced != Some(next) {
                    self.announced = Some(next);
                    self.say(&Message::NextEventTag(next))?;
                }
                return Ok(());
            }
            self.handle(next, timer)?;
        }
        Ok(())
    }

    fn handle(&mut self, tag: Tag, timer: Tag) -> Result<()> {
        self.current = tag;
        let had_input = self.arrived.remove(&tag);
        if tag == timer {
            self.round += 1;
            for index in 0..self.downstream.len() {
                let (federate, delay) = self.downstream[index];
                let arrival = if delay == DELAY_NONE { tag } else { Tag::new(tag.time + delay, 0) };
                for _ in 0..self.load.messages {
                    let payload = &[0; 8];
                    self.say(&Message::TaggedMessage { port: 0, federate, tag: arrival, payload })?;
                }
            }
        }
        if had_input {
            self.say(&Message::LatestTagComplete(tag))?;
        }
        if !self.waits_for_grants {
            // A federate with an unlimited grant announces each event, because those downstream wait for it.
            let next = self.tag_of(self.round);
            self.announced = Some(next);
            self.say(&Message::NextEventTag(next))?;
        }
        Ok(())
    }
}
