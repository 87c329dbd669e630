// SPDX-License-Identifier: Apache-2.0
//! The state of one encrypted connection.

use core::fmt;

use lf_coordination::IpAddress;
use lf_secure::{Channel, ChannelStage, Participant, Role};

use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};

/// Whether a connection can be used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Soundness {
    /// It can, once its handshake is complete.
    Sound,
    /// It is not secure; the reason has been logged.
    Broken,
    /// This end has refused the other one, which may not have read why.
    Refused,
}

/// The memory of one encrypted connection.
pub struct SecureSlot<B> {
    pub(super) channel: Channel<B>,
    pub(super) socket: Option<SocketId>,
    pub(super) role: Role,
    pub(super) address: IpAddress,
    /// The interest of the event loop.
    pub(super) interest: Interest,
    /// The participant that has to be at the other end.
    pub(super) expected: Option<Participant>,
    /// Whether a wait has found the socket ready during the handshake.
    pub(super) is_ready: bool,
    /// Whether there is content that the event loop has not taken, because its buffer was full.
    pub(super) has_leftover: bool,
    pub(super) soundness: Soundness,
}

impl<B> fmt::Debug for SecureSlot<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SecureSlot")
            .field("channel", &self.channel)
            .field("socket", &self.socket)
            .finish_non_exhaustive()
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> SecureSlot<B> {
    /// Returns a vacant slot with these buffers, each of at least [`lf_secure::HANDSHAKE_BYTES`]. Records are at most
    /// as long as they are.
    pub const fn new(incoming: B, outgoing: B) -> Self {
        Self {
            channel: Channel::new(incoming, outgoing),
            socket: None,
            role: Role::Initiator,
            address: IpAddress::UNSPECIFIED,
            interest: Interest::NONE,
            expected: None,
            is_ready: false,
            has_leftover: false,
            soundness: Soundness::Sound,
        }
    }

    /// Takes the slot for a socket that is being connected.
    pub(super) fn open(&mut self, socket: SocketId, address: IpAddress) {
        self.close();
        (self.socket, self.address) = (Some(socket), address);
    }

    /// Frees the slot and erases the keys of its connection.
    pub(super) fn close(&mut self) {
        self.channel.end();
        (self.socket, self.interest, self.expected) = (None, Interest::NONE, None);
        (self.is_ready, self.has_leftover, self.soundness) = (false, false, Soundness::Sound);
    }

    /// Writes what the connection has to send. Returns `Bytes` when nothing is left.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> Result<Transfer, NetError> {
        let Some(socket) = self.socket else { return Err(NetError::Stale) };
        while !self.channel.pending().is_empty() {
            match platform.write(socket, self.channel.pending())? {
                Transfer::Bytes(count) => self.channel.sent(count),
                other => return Ok(other),
            }
        }
        Ok(Transfer::Bytes(0))
    }

    /// Returns what to wait for: during the handshake for what that needs, and then for what the event loop wants.
    pub(super) fn effective_interest(&self) -> Interest {
        match self.channel.stage() {
            ChannelStage::Handshake => Interest { readable: true, writable: !self.channel.pending().is_empty() },
            ChannelStage::Vacant | ChannelStage::Open | ChannelStage::Failed(_) => self.interest,
        }
    }
}
