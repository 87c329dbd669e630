// SPDX-License-Identifier: Apache-2.0
//! One end of an encrypted connection: bytes of the network on one side, the federation's bytes on the other.
//!
//! Each direction begins with [`MARK`], which no message of the federation protocol begins with, and the version. Then
//! come frames: a length of two bytes, the most significant one first, and as many bytes. The first ones are the
//! messages of the handshake, all others are records: encrypted, with a tag of 16 bytes, numbered by their place. A
//! length of 0 and one byte more says without proof why the other end refuses the connection.
//!
//! A record is decrypted in place. The two buffers belong to the owner; the receiver tells the sender in the handshake
//! how long a record may be.

use core::fmt;

use crate::cipher::TAG_BYTES;
#[cfg(feature = "datagrams")]
use crate::datagram::DatagramKeys;
use crate::error::{ChannelError, Hint};
use crate::handshake::{Handshake, HandshakeKeys, Session};
use crate::keyring::{Keyring, Participant};
use crate::keys::StaticSecret;
use crate::pattern::{Pattern, Role};

/// The first byte of each direction. No message of the federation protocol begins with it.
pub const MARK: u8 = 0xE5;
/// The version of what follows.
const VERSION: u8 = 1;
/// The bytes that both ends have to agree upon before their handshake.
const PROLOGUE: &[u8] = &[MARK, VERSION];
/// The length of the length of a frame.
const LENGTH_BYTES: usize = 2;
/// The number of bytes that a record is longer than its content.
pub const RECORD_OVERHEAD: usize = LENGTH_BYTES + TAG_BYTES;
/// The longest content of a record whose length two bytes can tell.
const CONTENT_BYTES_MAX: usize = u16::MAX as usize - TAG_BYTES;
/// The number of records of one direction after which its key is replaced.
pub const REKEY_RECORDS: u64 = 1 << 16;
/// The length of [`Told`].
const TOLD_BYTES: usize = 8;
/// The length of a buffer that holds every message of the handshake: an ephemeral key, an encrypted static key and what
/// is told, after the mark and the version.
pub const HANDSHAKE_BYTES: usize = PROLOGUE.len() + LENGTH_BYTES + 32 + 32 + TAG_BYTES + TOLD_BYTES + TAG_BYTES;

static PATTERN: Pattern = Pattern::XX_PSK0;

/// The stage of a channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ChannelStage {
    /// There is no connection.
    Vacant,
    /// The ends prove to each other who they are.
    Handshake,
    /// It carries bytes.
    Open,
    /// It carries nothing any more.
    Failed(ChannelError),
}

enum Stage {
    Vacant,
    Handshake(Handshake),
    Open(Session),
    Failed(ChannelError),
}

/// The properties that an end tells of itself in the handshake.
#[derive(Clone, Copy)]
struct Told {
    /// The longest content of a record that it takes.
    content_max: u16,
    /// The name of its connection in datagrams for it.
    name: u32,
    /// The port for them, or 0.
    port: u16,
}

impl Told {
    fn bytes(self) -> [u8; TOLD_BYTES] {
        let mut bytes = [0; TOLD_BYTES];
        bytes[..2].copy_from_slice(&self.content_max.to_be_bytes());
        bytes[2..6].copy_from_slice(&self.name.to_be_bytes());
        bytes[6..].copy_from_slice(&self.port.to_be_bytes());
        bytes
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let (content_max, rest) = bytes.split_first_chunk()?;
        let (name, rest) = rest.split_first_chunk()?;
        let content_max = u16::from_be_bytes(*content_max);
        let port = u16::from_be_bytes(*rest.first_chunk()?);
        Some(Self { content_max, name: u32::from_be_bytes(*name), port })
    }
}

/// A part of a buffer, as offsets.
#[derive(Clone, Copy, Default)]
struct Part {
    start: usize,
    end: usize,
}

impl Part {
    fn len(self) -> usize {
        self.end - self.start
    }
}

/// One end of a connection, or a slot for one. Its buffers are the owner's, who may reuse it for the next connection.
pub struct Channel<B> {
    stage: Stage,
    role: Role,
    incoming: B,
    /// The bytes that have come and are not decrypted; behind [`Channel::plain`].
    raw: Part,
    /// The bytes that are decrypted and not taken.
    plain: Part,
    /// Whether the mark and the version have come.
    is_marked: bool,
    /// Whether they have been written.
    has_marked: bool,
    outgoing: B,
    /// The bytes to be sent.
    pending: Part,
    /// The number of bytes in the record that is being sent.
    sealed: usize,
    /// The longest content of a record that the other end takes.
    content_max: usize,
    /// The participant that has to be at the other end, if the owner expects one.
    expected: Option<Participant>,
    peer: Option<Participant>,
    #[cfg(feature = "datagrams")]
    datagrams: Option<DatagramKeys>,
    /// The name of this connection in datagrams that come, and the port for them, which the other end is told.
    own_address: (u32, u16),
    /// The same of the other end.
    remote_address: (u32, u16),
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Channel<B> {
    /// Returns a slot with two buffers of at least [`HANDSHAKE_BYTES`]. Records have at most the length of the shorter
    /// buffer of sender and receiver.
    pub const fn new(incoming: B, outgoing: B) -> Self {
        const NONE: Part = Part { start: 0, end: 0 };
        Self {
            stage: Stage::Vacant,
            role: Role::Responder,
            incoming,
            raw: NONE,
            plain: NONE,
            is_marked: false,
            has_marked: false,
            outgoing,
            pending: NONE,
            sealed: 0,
            content_max: 0,
            expected: None,
            peer: None,
            #[cfg(feature = "datagrams")]
            datagrams: None,
            own_address: (0, 0),
            remote_address: (0, 0),
        }
    }

    /// Begins a connection. `ephemeral` are random bytes that are never used again. `name` and `port` are where the
    /// other end sends datagrams of this connection, if it sends any; the port is 0 if none is open.
    ///
    /// The initiator then has bytes to send.
    pub fn begin(&mut self, role: Role, keyring: &Keyring<'_>, ephemeral: [u8; 32], name: u32, port: u16) {
        self.end();
        self.role = role;
        self.own_address = (name, port);
        let ephemeral = StaticSecret::new(ephemeral);
        let handshake = Handshake::new(&PATTERN, role, PROLOGUE, credentials(keyring), ephemeral, None);
        self.stage = Stage::Handshake(handshake);
        if role == Role::Initiator
            && let Err(error) = self.write_handshake(keyring)
        {
            self.stage = Stage::Failed(error);
        }
    }

    /// Ends the connection and erases everything of it.
    pub fn end(&mut self) {
        self.stage = Stage::Vacant;
        (self.raw, self.plain, self.pending) = Default::default();
        (self.is_marked, self.has_marked, self.sealed, self.content_max) = (false, false, 0, 0);
        (self.expected, self.peer, self.remote_address) = (None, None, (0, 0));
        self.forget_datagrams();
    }

    /// Lets the handshake fail if another participant than this one is at the other end.
    pub fn expect(&mut self, participant: Participant) {
        self.expected = Some(participant);
    }

    #[cfg_attr(
        not(feature = "datagrams"),
        expect(clippy::unused_self, clippy::needless_pass_by_ref_mut, reason = "there are none")
    )]
    fn forget_datagrams(&mut self) {
        #[cfg(feature = "datagrams")]
        {
            self.datagrams = None;
        }
    }

    /// Returns the stage.
    pub fn stage(&self) -> ChannelStage {
        match &self.stage {
            Stage::Vacant => ChannelStage::Vacant,
            Stage::Handshake(_) => ChannelStage::Handshake,
            Stage::Open(_) => ChannelStage::Open,
            Stage::Failed(error) => ChannelStage::Failed(*error),
        }
    }

    /// Returns the participant at the other end, which has proved to be it, once the connection is open.
    pub fn peer(&self) -> Option<Participant> {
        self.peer.filter(|_| matches!(self.stage, Stage::Open(_)))
    }

    /// Returns the keys of datagrams, once the connection is open.
    #[cfg(feature = "datagrams")]
    pub fn datagrams(&mut self) -> Option<&mut DatagramKeys> {
        self.datagrams.as_mut()
    }

    /// Returns the port to which the other end wants datagrams, or 0.
    pub fn remote_port(&self) -> u16 {
        self.remote_address.1
    }

    /// Returns the space for the next bytes of the network; empty only while [`Channel::has_content`].
    pub fn space(&mut self) -> &mut [u8] {
        if self.plain.len() == 0 && self.raw.start > 0 {
            let part = self.raw.start..self.raw.end;
            self.incoming.as_mut().copy_within(part, 0);
            (self.plain, self.raw) = (Part::default(), Part { start: 0, end: self.raw.len() });
        }
        self.incoming.as_mut().get_mut(self.raw.end..).unwrap_or_default()
    }

    /// Handles that the first `count` bytes of [`Channel::space`] have come from the network. Afterwards there may be
    /// bytes to send, and content to take.
    ///
    /// # Errors
    /// The reason why the connection has failed.
    pub fn filled(&mut self, count: usize, keyring: &Keyring<'_>) -> Result<(), ChannelError> {
        if let Stage::Failed(error) = self.stage {
            return Err(error);
        }
        self.raw.end = (self.raw.end + count).min(self.incoming.as_ref().len());
        while let Stage::Handshake(handshake) = &self.stage
            && !handshake.is_writer()
            && !handshake.is_complete()
        {
            match self.read_handshake(keyring) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => return self.fail(error),
            }
        }
        Ok(())
    }

    /// Returns whether [`Channel::take`] has something to return: content, or an error.
    pub fn has_content(&self) -> bool {
        match &self.stage {
            Stage::Open(_) => self.plain.len() > 0 || !matches!(self.frame(), Ok(None)),
            Stage::Failed(_) => true,
            Stage::Vacant | Stage::Handshake(_) => false,
        }
    }

    /// Decrypts what has come and moves it into `buffer`, as far as there is room. Returns the number of bytes.
    ///
    /// # Errors
    /// The reason why the connection has failed. What came before has been returned then.
    pub fn take(&mut self, buffer: &mut [u8]) -> Result<usize, ChannelError> {
        if let Stage::Failed(error) = self.stage {
            return Err(error);
        }
        let mut count = 0;
        while count < buffer.len() {
            if self.plain.len() == 0 {
                match self.open_record() {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(_) if count > 0 => break,
                    Err(error) => return self.fail(error).map(|()| 0),
                }
            }
            let bytes = self.plain.len().min(buffer.len() - count);
            let from = self.plain.start..self.plain.start + bytes;
            if let (Some(to), Some(from)) = (buffer.get_mut(count..count + bytes), self.incoming.as_ref().get(from)) {
                to.copy_from_slice(from);
            }
            self.plain.start += bytes;
            count += bytes;
        }
        Ok(count)
    }

    /// Encrypts as much of `content` as one record carries, if the connection is open and nothing is to be sent.
    /// Afterwards there are bytes to send. Returns whether it has done so.
    pub fn seal(&mut self, content: &[u8]) -> bool {
        let outgoing = self.outgoing.as_mut();
        let room = outgoing.len().saturating_sub(RECORD_OVERHEAD).min(self.content_max).min(CONTENT_BYTES_MAX);
        let count = content.len().min(room);
        let Stage::Open(session) = &mut self.stage else { return false };
        if self.pending.len() > 0 || self.sealed > 0 || count == 0 {
            return false;
        }
        let Some((head, rest)) = outgoing.split_first_chunk_mut::<LENGTH_BYTES>() else { return false };
        let Some((text, rest)) = rest.split_at_mut_checked(count) else { return false };
        let Some((tag, _)) = rest.split_first_chunk_mut::<TAG_BYTES>() else { return false };
        *head = u16::try_from(count + TAG_BYTES).unwrap_or(u16::MAX).to_be_bytes();
        text.copy_from_slice(content.get(..count).unwrap_or_default());
        *tag = session.sending.encrypt(&[], text);
        if session.sending.count() % REKEY_RECORDS == 0 {
            session.sending.rekey();
        }
        (self.pending, self.sealed) = (Part { start: 0, end: count + RECORD_OVERHEAD }, count);
        true
    }

    /// Returns the bytes to be sent to the network.
    pub fn pending(&self) -> &[u8] {
        self.outgoing.as_ref().get(self.pending.start..self.pending.end).unwrap_or_default()
    }

    /// Handles that the first `count` bytes of [`Channel::pending`] have been sent.
    pub fn sent(&mut self, count: usize) {
        self.pending.start += count.min(self.pending.len());
    }

    /// Returns the number of bytes of content in the record that has been sent completely, once; 0 if there is none.
    pub fn take_sent(&mut self) -> usize {
        if self.pending.len() > 0 { 0 } else { core::mem::take(&mut self.sealed) }
    }

    /// Returns the bytes of the frame at the front of what has come, behind its length; `None` if it is incomplete.
    fn frame(&self) -> Result<Option<Part>, ChannelError> {
        let start = self.raw.start + LENGTH_BYTES;
        let raw = self.incoming.as_ref().get(self.raw.start..self.raw.end).unwrap_or_default();
        let Some((length, rest)) = raw.split_first_chunk() else { return Ok(None) };
        let length = u16::from_be_bytes(*length);
        let bytes = usize::from(length);
        if length == 0 {
            return rest.first().map_or(Ok(None), |byte| Err(ChannelError::Refused(Hint::from_byte(*byte))));
        }
        if bytes + LENGTH_BYTES > self.incoming.as_ref().len() {
            return Err(ChannelError::Length(length));
        }
        Ok((rest.len() >= bytes).then_some(Part { start, end: start + bytes }))
    }

    /// Decrypts the next record, if it is complete.
    fn open_record(&mut self) -> Result<bool, ChannelError> {
        if !matches!(self.stage, Stage::Open(_)) {
            return Ok(false);
        }
        let Some(frame) = self.frame()? else { return Ok(false) };
        let Stage::Open(session) = &mut self.stage else { return Ok(false) };
        let bytes = self.incoming.as_mut().get_mut(frame.start..frame.end).unwrap_or_default();
        let length = bytes.len();
        // A record without content is none that is ever sent.
        let Some((text, tag)) = bytes.split_last_chunk_mut().filter(|(text, _)| !text.is_empty()) else {
            return Err(ChannelError::Length(u16::try_from(length).unwrap_or(u16::MAX)));
        };
        session.receiving.decrypt(&[], text, tag).map_err(|_| ChannelError::Forged)?;
        if session.receiving.count() % REKEY_RECORDS == 0 {
            session.receiving.rekey();
        }
        self.plain = Part { start: frame.start, end: frame.end - TAG_BYTES };
        self.raw.start = frame.end;
        Ok(true)
    }

    /// Reads a message of the handshake, and answers it. Returns `false` if it is incomplete.
    fn read_handshake(&mut self, keyring: &Keyring<'_>) -> Result<bool, ChannelError> {
        if !self.is_marked {
            let raw = self.incoming.as_ref().get(self.raw.start..self.raw.end).unwrap_or_default();
            match *raw {
                [first, ..] if first != MARK => return Err(ChannelError::Plain(first)),
                [_, version, ..] if version != VERSION => return Err(ChannelError::Version(version)),
                [] | [_] => return Ok(false),
                [..] => {}
            }
            self.raw.start += PROLOGUE.len();
            self.is_marked = true;
        }
        let Some(frame) = self.frame()? else { return Ok(false) };
        let Stage::Handshake(handshake) = &mut self.stage else { return Ok(false) };
        let bytes = self.incoming.as_mut().get_mut(frame.start..frame.end).unwrap_or_default();
        let told = handshake.read(credentials(keyring), bytes).map_err(|_| ChannelError::Handshake)?;
        self.raw.start = frame.end;
        if let Some(key) = handshake.remote().copied() {
            let Told { content_max, name, port } = Told::read(told).ok_or(ChannelError::Handshake)?;
            (self.content_max, self.remote_address) = (content_max.into(), (name, port));
            if self.content_max == 0 {
                return Err(ChannelError::Handshake);
            }
            let found = keyring.owner_of(&key).ok_or(ChannelError::UnknownKey(key))?;
            if let Some(expected) = self.expected.filter(|expected| *expected != found) {
                return Err(ChannelError::Other { expected, found });
            }
            self.peer = Some(found);
        }
        if handshake.is_writer() {
            self.write_handshake(keyring)?;
        }
        self.complete();
        Ok(true)
    }

    /// Writes a message of the handshake behind what is to be sent.
    fn write_handshake(&mut self, keyring: &Keyring<'_>) -> Result<(), ChannelError> {
        let content = self.incoming.as_ref().len().saturating_sub(RECORD_OVERHEAD);
        let Stage::Handshake(handshake) = &mut self.stage else { return Ok(()) };
        let outgoing = self.outgoing.as_mut();
        self.pending = Part::default();
        let is_first = !core::mem::replace(&mut self.has_marked, true);
        let mark = if is_first { PROLOGUE.len() } else { 0 };
        let (name, port) = self.own_address;
        let told = Told { content_max: u16::try_from(content).unwrap_or(u16::MAX), name, port }.bytes();
        // The first message can be replayed, so it tells nothing.
        let told = if is_first && self.role == Role::Initiator { &[][..] } else { &told };
        let start = mark + LENGTH_BYTES;
        let message = outgoing.get_mut(start..).ok_or(ChannelError::Handshake)?;
        let count = handshake.write(credentials(keyring), told, message).map_err(|_| ChannelError::Handshake)?;
        outgoing.get_mut(..mark).unwrap_or_default().copy_from_slice(&PROLOGUE[..mark]);
        let length = u16::try_from(count).unwrap_or(u16::MAX).to_be_bytes();
        outgoing.get_mut(mark..start).unwrap_or_default().copy_from_slice(&length);
        self.pending.end = start + count;
        Ok(())
    }

    /// Opens the connection, if the handshake is complete.
    fn complete(&mut self) {
        if let Stage::Handshake(handshake) = &self.stage
            && let Some(session) = handshake.session()
        {
            #[cfg(feature = "datagrams")]
            {
                self.datagrams = handshake.datagram_keys(self.remote_address.0);
            }
            self.stage = Stage::Open(session);
        }
    }

    /// Ends the connection for this reason, which the other end is told.
    fn fail(&mut self, error: ChannelError) -> Result<(), ChannelError> {
        self.stage = Stage::Failed(error);
        (self.raw, self.plain) = (Part::default(), Part::default());
        self.forget_datagrams();
        // Behind a part of a frame nothing else can be sent.
        if self.pending.len() == 0
            && let Some(hint) = error.hint()
        {
            let frame = [MARK, VERSION, 0, 0, hint.byte()];
            let frame = frame.get(if self.has_marked { PROLOGUE.len() } else { 0 }..).unwrap_or_default();
            if let Some(bytes) = self.outgoing.as_mut().get_mut(..frame.len()) {
                bytes.copy_from_slice(frame);
                self.pending = Part { start: 0, end: frame.len() };
            }
        }
        Err(error)
    }
}

impl<B> fmt::Debug for Channel<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Channel").field("role", &self.role).field("peer", &self.peer).finish_non_exhaustive()
    }
}

fn credentials<'a>(keyring: &'a Keyring<'_>) -> HandshakeKeys<'a> {
    HandshakeKeys { secret: keyring.own(), public: keyring.public(), federation: keyring.federation() }
}
