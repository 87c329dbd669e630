// SPDX-License-Identifier: Apache-2.0
//! What an RTI reads and writes, as a table of messages, in LF's own format or as text.
//!
//! The trace is taken between the event loop and the sockets: it shows what was on the wire and when, and costs nothing
//! where there is none. The datagrams of clock synchronization are written down later, because their times count.

mod csv;
mod lft;
mod table;

use std::collections::BTreeMap;
use std::path::PathBuf;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};
use lf_runtime::trace::{Event, Header};
use lf_wire::{DecodeError, Decoded, Limits, Message, QueryEnd, decode};

use csv::Csv;
use lft::Lft;
use table::{Direction, Format, Table};

/// A file that the messages are written into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// Where it is; a file that is there already is replaced.
    pub file: PathBuf,
    /// What it looks like.
    pub format: TraceFormat,
}

/// What a trace looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceFormat {
    /// The binary format that LF's own tools read; `trace/lft.rs` says what is in it.
    Lft,
    /// Comma-separated values; `trace/csv.rs` says which.
    Csv,
}

/// The file that cannot be written, and why not.
pub(crate) type TraceError = (PathBuf, std::io::Error);

/// A platform whose connections are traced.
pub(crate) struct Traced<P> {
    platform: P,
    /// By the place of the socket.
    connections: BTreeMap<u16, Connection>,
    /// Which federate has which UDP port.
    ports: BTreeMap<Endpoint, u16>,
    /// Datagrams that are not in the table yet, oldest first.
    datagrams: Vec<Datagram>,
    table: Table,
}

/// What is known of one connection.
struct Connection {
    address: IpAddress,
    federate: Option<u16>,
    received: Stream,
    sent: Stream,
}

/// One direction: the beginning of a message that has not gone through as a whole.
#[derive(Default)]
struct Stream {
    bytes: Vec<u8>,
    query_end: QueryEnd,
    /// What came was no message, so nothing behind it can be told apart.
    unreadable: bool,
}

/// A datagram and when it came or went.
struct Datagram {
    now: Instant,
    direction: Direction,
    peer: Endpoint,
    bytes: Vec<u8>,
}

impl<P: Platform> Traced<P> {
    /// Traces into new files.
    ///
    /// # Errors
    /// When one of them cannot be written.
    pub(crate) fn new(platform: P, traces: &[Trace]) -> Result<Self, TraceError> {
        let mut table = Table::default();
        for Trace { file, format } in traces {
            let format: Box<dyn Format> = match format {
                TraceFormat::Lft => Box::new(Lft::default()),
                TraceFormat::Csv => Box::new(Csv),
            };
            table.add_file(file, format).map_err(|error| (file.clone(), error))?;
        }
        let (connections, ports) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { platform, connections, ports, datagrams: Vec::new(), table })
    }

    /// Writes down the datagrams that have come and gone; what is no message has come from a stranger.
    fn note_datagrams(&mut self) {
        for Datagram { now, direction, peer, bytes } in self.datagrams.drain(..) {
            if let Ok(Decoded::Complete { message, len }) = decode(&bytes, &Limits::NONE)
                && len == bytes.len()
            {
                self.table.add(now, direction, self.ports.get(&peer).copied(), &message);
            }
        }
    }

    /// Notes the messages that are whole with these bytes.
    fn note(&mut self, socket: SocketId, direction: Direction, bytes: &[u8]) {
        self.note_datagrams();
        let now = self.platform.now();
        let Some(connection) = self.connections.get_mut(&socket.index) else { return };
        let Connection { address, federate, received, sent } = connection;
        let stream = match direction {
            Direction::Received => received,
            Direction::Sent => sent,
        };
        if stream.unreadable {
            return;
        }
        stream.bytes.extend_from_slice(bytes);
        let mut rest = &stream.bytes[..];
        loop {
            rest = &rest[stream.query_end.take(rest)..];
            let length = match decode(rest, &Limits::NONE) {
                Ok(Decoded::Complete { message, len }) => {
                    if let Message::FedIds { federate: id, .. }
                    | Message::TransientFedIds { federate: id, .. }
                    | Message::FedNonce { federate: id, .. } = message
                    {
                        *federate = Some(id);
                    }
                    if let (Message::UdpPort(port), Some(federate)) = (message, *federate) {
                        self.ports.insert(Endpoint::new(*address, port), federate);
                    }
                    self.table.add(now, direction, *federate, &message);
                    stream.query_end.follow(&message);
                    len
                }
                // The RTI skips such a byte, too.
                Err(DecodeError::UnknownType { .. }) => 1,
                Ok(Decoded::Incomplete { .. }) => break,
                Err(_) => {
                    stream.unreadable = true;
                    break;
                }
            };
            rest = &rest[length..];
        }
        let done = stream.bytes.len() - rest.len();
        stream.bytes.drain(..done);
    }
}

impl<P: Platform> Platform for Traced<P> {
    fn now(&mut self) -> Instant {
        self.platform.now()
    }

    fn outside(&self) -> &'static dyn Outside {
        self.platform.outside()
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        self.platform.set_correction(correction);
    }

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        self.platform.random(buffer)
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        self.platform.connect(address)
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.platform.connected(socket)
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.platform.listen(port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.platform.bind(port)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        let received = self.platform.receive_from(socket, buffer)?;
        if let Some((count, peer)) = received {
            let now = self.platform.now();
            self.datagrams.push(Datagram { now, direction: Direction::Received, peer, bytes: buffer[..count].into() });
        }
        Ok(received)
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.platform.send_to(socket, to, bytes)?;
        let now = self.platform.now();
        self.datagrams.push(Datagram { now, direction: Direction::Sent, peer: to, bytes: bytes.into() });
        Ok(())
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.platform.local_port(listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let accepted = self.platform.accept(listener)?;
        if let Some((socket, address)) = accepted {
            let (received, sent) = (Stream::default(), Stream::default());
            self.connections.insert(socket.index, Connection { address, federate: None, received, sent });
        }
        Ok(accepted)
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        let transfer = self.platform.read(socket, buffer)?;
        if let Transfer::Bytes(count) = transfer {
            self.note(socket, Direction::Received, &buffer[..count]);
        }
        Ok(transfer)
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        let transfer = self.platform.write(socket, bytes)?;
        if let Transfer::Bytes(count) = transfer {
            self.note(socket, Direction::Sent, &bytes[..count]);
        }
        Ok(transfer)
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        self.platform.shut_down_writing(socket);
    }

    fn close(&mut self, socket: SocketId) {
        self.note_datagrams();
        self.connections.remove(&socket.index);
        self.platform.close(socket);
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.platform.set_interest(socket, interest);
    }

    fn expect(&mut self, time: Deadline) {
        self.platform.expect(time);
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        self.note_datagrams();
        self.platform.wait(until, ready);
    }

    fn trace_begins(&mut self, header: Header) {
        self.platform.trace_begins(header);
    }

    fn trace(&mut self, at: Instant, event: Event) {
        self.platform.trace(at, event);
    }

    fn interrupted(&mut self) -> bool {
        self.platform.interrupted()
    }
}
