// SPDX-License-Identifier: Apache-2.0
//! The calls of a participant, and the answers to them, as bytes on a local socket.

use std::io::{self, Read, Write};
use std::net::SocketAddr;

use lf_coordination::Deadline;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, NetError, SocketId, Transfer};

/// The length of the part before the bytes.
const HEAD: usize = 17;
/// The length of one socket in a list of those that are ready.
const READY: usize = 5;

/// A call of a participant. The functions are those of [`lf_runtime::platform::Platform`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Call {
    /// Names the participant by its number. Answered at the beginning of its first turn.
    Begin,
    Random,
    Connect,
    Connected,
    Listen,
    Bind,
    ReceiveFrom,
    SendTo,
    LocalPort,
    Accept,
    Read,
    Write,
    /// Not answered, like the next two.
    ShutDownWriting,
    Close,
    SetInterest,
    WaitUntil,
    /// Waits without a limit.
    Wait,
}

impl Call {
    const ALL: [Self; 17] = [
        Self::Begin,
        Self::Random,
        Self::Connect,
        Self::Connected,
        Self::Listen,
        Self::Bind,
        Self::ReceiveFrom,
        Self::SendTo,
        Self::LocalPort,
        Self::Accept,
        Self::Read,
        Self::Write,
        Self::ShutDownWriting,
        Self::Close,
        Self::SetInterest,
        Self::WaitUntil,
        Self::Wait,
    ];

    /// Returns the call that a frame is, if it is one.
    pub(super) fn of(frame: &Frame) -> Option<Self> {
        Self::ALL.get(usize::from(frame.kind)).copied()
    }
}

/// Outcomes in answers.
const DONE: u8 = 0;
const NOTHING: u8 = 1;
const CLOSED: u8 = 2;
const INTERRUPTED: u8 = 3;
const REFUSED: u8 = 4;
const RESET: u8 = 5;
const UNREACHABLE: u8 = 6;
const ADDRESS_IN_USE: u8 = 7;
const NO_SOCKET_LEFT: u8 = 8;
const STALE: u8 = 9;
const INSECURE: u8 = 10;
const OS: u8 = 11;

/// A call or an answer; what it does not need is zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Frame {
    kind: u8,
    pub(super) socket: (u16, u16),
    /// A time in nanoseconds, a length, a port, an interest, or an error of the system.
    pub(super) number: i64,
    pub(super) bytes: Vec<u8>,
}

impl Frame {
    pub(super) fn call(call: Call) -> Self {
        Self { kind: call as u8, ..Self::default() }
    }

    /// Returns an answer without an error.
    pub(super) fn done() -> Self {
        Self { kind: DONE, ..Self::default() }
    }

    pub(super) fn nothing() -> Self {
        Self { kind: NOTHING, ..Self::default() }
    }

    pub(super) fn failed(error: NetError) -> Self {
        let number = if let NetError::Os(number) = error { number.into() } else { 0 };
        let kind = match error {
            NetError::Refused => REFUSED,
            NetError::Reset => RESET,
            NetError::Unreachable => UNREACHABLE,
            NetError::AddressInUse => ADDRESS_IN_USE,
            NetError::NoSocketLeft => NO_SOCKET_LEFT,
            NetError::Stale => STALE,
            NetError::Insecure => INSECURE,
            NetError::Os(_) => OS,
        };
        Self { kind, number, ..Self::default() }
    }

    pub(super) fn moved(transfer: Transfer) -> Self {
        match transfer {
            Transfer::Bytes(count) => Self::done().with_number(count),
            Transfer::WouldBlock => Self::nothing(),
            Transfer::Closed => Self { kind: CLOSED, ..Self::default() },
        }
    }

    pub(super) fn about(mut self, socket: SocketId) -> Self {
        self.socket = (socket.index, socket.generation);
        self
    }

    /// Adds a length or a port, which are far below the limit.
    pub(super) fn with_number(mut self, number: usize) -> Self {
        self.number = i64::try_from(number).unwrap_or(i64::MAX);
        self
    }

    pub(super) fn with_time(mut self, time: Instant) -> Self {
        self.number = time.as_nanos();
        self
    }

    pub(super) fn with_bytes(mut self, bytes: &[u8]) -> Self {
        self.bytes = bytes.to_vec();
        self
    }

    /// Adds an address before the bytes.
    pub(super) fn with_address(mut self, address: Endpoint) -> Self {
        let text = SocketAddr::from(address).to_string();
        self.bytes.splice(0..0, text.into_bytes().into_iter().chain([0]));
        self
    }

    pub(super) fn with_interest(mut self, interest: Interest) -> Self {
        self.number = coded(interest).into();
        self
    }

    pub(super) fn interrupted_if(mut self, is_interrupted: bool) -> Self {
        self.kind = if is_interrupted { INTERRUPTED } else { self.kind };
        self
    }

    /// Adds a socket to the list of those that are ready.
    pub(super) fn add_ready(&mut self, socket: SocketId, interest: Interest) {
        self.bytes.extend(socket.index.to_le_bytes());
        self.bytes.extend(socket.generation.to_le_bytes());
        self.bytes.push(coded(interest));
    }

    pub(super) fn socket(&self) -> SocketId {
        SocketId { index: self.socket.0, generation: self.socket.1 }
    }

    pub(super) fn time(&self) -> Instant {
        Instant::from_nanos(self.number)
    }

    pub(super) fn deadline(&self) -> Deadline {
        Deadline::At(self.time())
    }

    pub(super) fn interest(&self) -> Interest {
        decoded(self.number.to_le_bytes()[0])
    }

    pub(super) fn port(&self) -> u16 {
        u16::try_from(self.number).unwrap_or_default()
    }

    pub(super) fn is_interrupted(&self) -> bool {
        self.kind == INTERRUPTED
    }

    pub(super) fn is_nothing(&self) -> bool {
        self.kind == NOTHING
    }

    /// Returns a length, which no answer exceeds that follows it.
    pub(super) fn length(&self) -> usize {
        const MOST: usize = 1 << 20;
        usize::try_from(self.number).unwrap_or(0).min(MOST)
    }

    pub(super) fn transfer(&self) -> Transfer {
        match self.kind {
            NOTHING => Transfer::WouldBlock,
            CLOSED => Transfer::Closed,
            _ => Transfer::Bytes(self.length()),
        }
    }

    /// Returns the address before the bytes, and these.
    pub(super) fn address(&self) -> Option<(Endpoint, &[u8])> {
        let end = self.bytes.iter().position(|byte| *byte == 0)?;
        let address: SocketAddr = std::str::from_utf8(&self.bytes[..end]).ok()?.parse().ok()?;
        Some((address.into(), &self.bytes[end + 1..]))
    }

    /// Returns the sockets that are ready.
    pub(super) fn ready(&self) -> impl Iterator<Item = (SocketId, Interest)> {
        self.bytes.chunks_exact(READY).map(|bytes| {
            let half = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
            (SocketId { index: half(0), generation: half(2) }, decoded(bytes[4]))
        })
    }

    /// Returns the answer, or the error that it is.
    ///
    /// # Errors
    /// Those of the network.
    pub(super) fn outcome(self) -> Result<Self, NetError> {
        Err(match self.kind {
            REFUSED => NetError::Refused,
            RESET => NetError::Reset,
            UNREACHABLE => NetError::Unreachable,
            ADDRESS_IN_USE => NetError::AddressInUse,
            NO_SOCKET_LEFT => NetError::NoSocketLeft,
            STALE => NetError::Stale,
            INSECURE => NetError::Insecure,
            OS => NetError::Os(i32::try_from(self.number).unwrap_or_default()),
            _ => return Ok(self),
        })
    }

    /// # Errors
    /// When the other end is gone.
    pub(super) fn write(&self, mut stream: impl Write) -> io::Result<()> {
        let length = u32::try_from(self.bytes.len()).map_err(io::Error::other)?;
        let mut all = Vec::with_capacity(HEAD + self.bytes.len());
        all.push(self.kind);
        all.extend(self.socket.0.to_le_bytes());
        all.extend(self.socket.1.to_le_bytes());
        all.extend(self.number.to_le_bytes());
        all.extend(length.to_le_bytes());
        all.extend(&self.bytes);
        stream.write_all(&all)
    }

    /// # Errors
    /// When the other end is gone.
    pub(super) fn read(mut stream: impl Read) -> io::Result<Self> {
        let mut head = [0; HEAD];
        stream.read_exact(&mut head)?;
        let mut rest = &head[..];
        let [kind] = take(&mut rest);
        let index = u16::from_le_bytes(take(&mut rest));
        let generation = u16::from_le_bytes(take(&mut rest));
        let number = i64::from_le_bytes(take(&mut rest));
        let length = u32::from_le_bytes(take(&mut rest));
        let mut bytes = vec![0; usize::try_from(length).map_err(io::Error::other)?];
        stream.read_exact(&mut bytes)?;
        Ok(Self { kind, socket: (index, generation), number, bytes })
    }
}

/// Takes bytes from the front of a head, which has them.
fn take<const N: usize>(rest: &mut &[u8]) -> [u8; N] {
    let (front, behind) = rest.split_first_chunk().unwrap_or((&[0; N], &[]));
    *rest = behind;
    *front
}

fn coded(interest: Interest) -> u8 {
    u8::from(interest.readable) | u8::from(interest.writable) << 1
}

fn decoded(code: u8) -> Interest {
    Interest { readable: code & 1 != 0, writable: code & 2 != 0 }
}
