// SPDX-License-Identifier: Apache-2.0
//! A platform whose connections are encrypted and authenticated: a layer between those of another platform and the
//! messages.
//!
//! An event loop sees the same connections as without it. What it writes before both ends have proved who they are
//! waits, and a connection on which they do not, or on which anything was changed, ends like one that broke; the log
//! has the reason. Datagrams belong to the connection of their sender, and are encrypted under keys of that.

#[cfg(feature = "datagrams")]
mod datagrams;
mod event;
mod slot;

use core::fmt;

use lf_coordination::clock_sync::ClockCorrection;
use lf_coordination::{Deadline, Endpoint, IpAddress, Tally};
use lf_model::Outside;
use lf_model::time::{Instant, Interval};
use lf_secure::{ChannelError, ChannelStage, Keyring, Participant, Role};
use lf_wire::{Message, RejectCode};
use log::Level;

pub use event::{Insecurity, SecurityEvent};
pub use slot::SecureSlot;
use slot::Soundness;

use crate::log_event::report;
use crate::platform::{Interest, NetError, Platform, RandomError, SocketId, Transfer};

/// The number of bytes to read at once from a refused peer.
const PIECE_BYTES: usize = 64;

/// A platform with encrypted connections, if it has keys; without any it is the platform below.
pub struct SecurePlatform<'k, P, B> {
    platform: P,
    keyring: Option<Keyring<'k>>,
    /// The connections, each at the index of its socket modulo their number, or at the next free place.
    slots: &'k mut [SecureSlot<B>],
    /// The port for datagrams, or 0.
    port: u16,
    /// Whether a connection may have content that no wait of the platform below reports.
    has_leftovers: bool,
    /// The number of connections that were not secure.
    insecure: Tally,
    /// The number of datagrams that were not authentic.
    #[cfg(feature = "datagrams")]
    forged: Tally,
}

impl<P, B> fmt::Debug for SecurePlatform<'_, P, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SecurePlatform").field("has_keys", &self.keyring.is_some()).finish_non_exhaustive()
    }
}

impl<'k, P: Platform, B: AsRef<[u8]> + AsMut<[u8]>> SecurePlatform<'k, P, B> {
    /// Returns a platform with these keys. It needs a slot for each connection that is open at once.
    pub fn new(platform: P, keyring: Option<Keyring<'k>>, slots: &'k mut [SecureSlot<B>]) -> Self {
        Self {
            platform,
            keyring,
            slots,
            port: 0,
            has_leftovers: false,
            insecure: Tally::NOTHING,
            #[cfg(feature = "datagrams")]
            forged: Tally::NOTHING,
        }
    }

    /// Returns the platform below.
    pub fn inner(&mut self) -> &mut P {
        &mut self.platform
    }

    /// Returns the index of a connection's slot; `None` for other sockets, and without keys.
    fn index_of(&self, socket: SocketId) -> Option<usize> {
        index_of(self.slots, socket, Some(socket)).filter(|_| self.keyring.is_some())
    }

    /// Takes a slot for a new socket, if there are keys.
    fn take_slot(&mut self, socket: SocketId, address: IpAddress) -> Result<(), NetError> {
        if self.keyring.is_none() {
            return Ok(());
        }
        let Some(index) = index_of(self.slots, socket, None) else {
            self.platform.close(socket);
            return Err(NetError::NoSocketLeft);
        };
        self.slots[index].open(socket, address);
        Ok(())
    }

    /// Begins the handshake of a connection.
    fn begin(&mut self, socket: SocketId, role: Role) -> Result<(), NetError> {
        let Some(index) = self.index_of(socket) else { return Ok(()) };
        let Self { platform, keyring: Some(keyring), slots, port, .. } = self else { return Ok(()) };
        let slot = &mut slots[index];
        let mut ephemeral = [0; 32];
        if let Err(error) = platform.random(&mut ephemeral) {
            report(Level::Error, &SecurityEvent::NoRandom(error));
            return Err(NetError::Insecure);
        }
        slot.role = role;
        slot.channel.begin(role, keyring, ephemeral, name_of(socket), *port);
        if let Some(expected) = slot.expected {
            slot.channel.expect(expected);
        }
        let _ = slot.flush(platform);
        platform.set_interest(socket, slot.effective_interest());
        Ok(())
    }

    /// Reads once from the network, and lets the connection answer. Returns the outcome of the read.
    fn pump(&mut self, index: usize) -> Result<Transfer, NetError> {
        let Self { platform, keyring: Some(keyring), slots, .. } = self else { return Ok(Transfer::WouldBlock) };
        let Some((slot, socket)) = slots.get_mut(index).and_then(|slot| slot.socket.map(|socket| (slot, socket)))
        else {
            return Err(NetError::Stale);
        };
        let transfer = platform.read(socket, slot.channel.space())?;
        if let Transfer::Bytes(count) = transfer {
            if let Err(error) = slot.channel.filled(count, keyring) {
                return Err(self.give_up(index, error));
            }
            let _ = slot.flush(platform);
        }
        Ok(transfer)
    }

    /// Logs why a connection is not secure, once, tells the other end, and ends our direction.
    fn give_up(&mut self, index: usize, error: ChannelError) -> NetError {
        let Self { platform, slots, insecure, .. } = self;
        let Some(slot) = slots.get_mut(index).filter(|slot| slot.soundness == Soundness::Sound) else {
            return NetError::Insecure;
        };
        let Some(socket) = slot.socket else { return NetError::Insecure };
        let refuses = slot.role == Role::Responder && error.ends_handshake();
        slot.soundness = if refuses { Soundness::Refused } else { Soundness::Broken };
        let times = insecure.count();
        if times.is_logged() {
            let (address, why) = (slot.address, Insecurity(error));
            report(Level::Warn, &SecurityEvent::Connection { address, why, times });
        }
        let mut reject = [0; 2];
        if let ChannelError::Plain(_) = error
            && slot.role == Role::Responder
            && Message::Reject(RejectCode::Insecure).encode(&mut reject).is_ok()
        {
            let _ = platform.write(socket, &reject);
        }
        let _ = slot.flush(platform);
        platform.shut_down_writing(socket);
        NetError::Insecure
    }

    /// Reads and drops what the other end of a refused connection sends, until it ends: a socket that is closed with
    /// unread bytes resets the connection, and the reason may be lost. The event loop closes one that does not end.
    fn discard(&mut self, socket: SocketId) -> Result<Transfer, NetError> {
        match self.platform.read(socket, &mut [0; PIECE_BYTES])? {
            Transfer::Bytes(_) | Transfer::WouldBlock => Ok(Transfer::WouldBlock),
            Transfer::Closed => Ok(Transfer::Closed),
        }
    }

    /// Advances the handshakes whose sockets are ready, and reports those that have ended.
    fn advance(&mut self, ready: &mut dyn FnMut(SocketId, Interest)) {
        for index in 0..self.slots.len() {
            if !core::mem::take(&mut self.slots[index].is_ready) {
                continue;
            }
            let outcome = self.pump(index);
            let Self { platform, slots, .. } = self;
            let slot = &mut slots[index];
            let Some(socket) = slot.socket else { continue };
            let is_made =
                slot.flush(platform).is_ok() && matches!(outcome, Ok(Transfer::Bytes(_) | Transfer::WouldBlock));
            if !is_made || slot.channel.stage() != ChannelStage::Handshake {
                ready(socket, Interest { readable: true, writable: true });
            }
            platform.set_interest(socket, slot.effective_interest());
        }
    }
}

/// Returns the first place, from that of a socket's index on, that has this socket or, with `None`, is free.
fn index_of<B>(slots: &[SecureSlot<B>], socket: SocketId, wanted: Option<SocketId>) -> Option<usize> {
    let (before, behind) = slots.split_at(usize::from(socket.index) % slots.len().max(1));
    let is_it = |slot: &SecureSlot<B>| slot.socket == wanted;
    let found = behind.iter().position(is_it).map(|index| before.len() + index);
    found.or_else(|| before.iter().position(is_it))
}

/// Returns the name of a connection in datagrams for it.
fn name_of(socket: SocketId) -> u32 {
    u32::from(socket.index) << 16 | u32::from(socket.generation)
}

impl<P: Platform, B: AsRef<[u8]> + AsMut<[u8]>> Platform for SecurePlatform<'_, P, B> {
    const DATAGRAMS: bool = P::DATAGRAMS;
    const NAMES: bool = P::NAMES;
    const TURN_TIME: Interval = P::TURN_TIME;

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
        let socket = self.platform.connect(address)?;
        self.take_slot(socket, address.ip)?;
        Ok(socket)
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.platform.connected(socket)?;
        self.begin(socket, Role::Initiator)
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.platform.listen(port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        let socket = self.platform.bind(port)?;
        self.port = self.platform.local_port(socket)?;
        Ok(socket)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        if self.keyring.is_none() {
            return self.platform.receive_from(socket, buffer);
        }
        #[cfg(not(feature = "datagrams"))]
        return Err(NetError::Insecure);
        #[cfg(feature = "datagrams")]
        self.receive_datagram(socket, buffer)
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        if self.keyring.is_none() {
            return self.platform.send_to(socket, to, bytes);
        }
        #[cfg(not(feature = "datagrams"))]
        return Err(NetError::Insecure);
        #[cfg(feature = "datagrams")]
        self.send_datagram(socket, to, bytes)
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.platform.local_port(listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let Some((socket, address)) = self.platform.accept(listener)? else { return Ok(None) };
        self.take_slot(socket, address)?;
        if let Err(error) = self.begin(socket, Role::Responder) {
            self.close(socket);
            return Err(error);
        }
        Ok(Some((socket, address)))
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        let Some(index) = self.index_of(socket) else { return self.platform.read(socket, buffer) };
        let mut transfer = Transfer::WouldBlock;
        if !self.slots[index].channel.has_content() {
            match self.pump(index) {
                Ok(outcome) => transfer = outcome,
                Err(_) if self.slots[index].soundness == Soundness::Refused => return Ok(Transfer::WouldBlock),
                Err(error) => return Err(error),
            }
        }
        if self.slots[index].soundness == Soundness::Refused {
            return self.discard(socket);
        }
        let slot = &mut self.slots[index];
        match slot.channel.take(buffer) {
            Ok(0) => Ok(if transfer == Transfer::Closed { transfer } else { Transfer::WouldBlock }),
            Ok(count) => {
                slot.has_leftover = slot.channel.has_content();
                self.has_leftovers |= slot.has_leftover;
                Ok(Transfer::Bytes(count))
            }
            Err(error) => {
                slot.has_leftover = false;
                Err(self.give_up(index, error))
            }
        }
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        let Some(index) = self.index_of(socket) else { return self.platform.write(socket, bytes) };
        let Self { platform, slots, .. } = self;
        let slot = &mut slots[index];
        loop {
            match slot.flush(platform)? {
                Transfer::WouldBlock => return Ok(Transfer::WouldBlock),
                Transfer::Closed => return Ok(Transfer::Closed),
                Transfer::Bytes(_) => {}
            }
            // What was encrypted is at the front of what is pending, because the caller has not been told that it went.
            match slot.channel.take_sent() {
                0 => {}
                count => return Ok(Transfer::Bytes(count)),
            }
            match slot.channel.stage() {
                ChannelStage::Failed(_) => return Err(NetError::Insecure),
                _ if slot.channel.seal(bytes) => {}
                _ => return Ok(Transfer::WouldBlock),
            }
        }
    }

    fn require(&mut self, socket: SocketId, participant: Participant) {
        match self.index_of(socket) {
            Some(index) => self.slots[index].expected = Some(participant),
            None => self.platform.require(socket, participant),
        }
    }

    fn may_be(&self, socket: SocketId, participant: Participant) -> bool {
        match self.keyring {
            Some(_) => self.index_of(socket).and_then(|index| self.slots[index].channel.peer()) == Some(participant),
            None => self.platform.may_be(socket, participant),
        }
    }

    fn failure(&self, socket: SocketId) -> Option<NetError> {
        match self.index_of(socket) {
            Some(index) => (self.slots[index].soundness != Soundness::Sound).then_some(NetError::Insecure),
            None => self.platform.failure(socket),
        }
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        self.platform.shut_down_writing(socket);
    }

    fn close(&mut self, socket: SocketId) {
        if let Some(index) = self.index_of(socket) {
            self.slots[index].close();
        }
        self.platform.close(socket);
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        let mut effective = interest;
        if let Some(index) = self.index_of(socket) {
            self.slots[index].interest = interest;
            effective = self.slots[index].effective_interest();
        }
        self.platform.set_interest(socket, effective);
    }

    fn expect(&mut self, time: Deadline) {
        self.platform.expect(time);
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        let mut until = until;
        if core::mem::take(&mut self.has_leftovers) {
            for slot in self.slots.iter().filter(|slot| slot.has_leftover) {
                self.has_leftovers = true;
                if let Some(socket) = slot.socket.filter(|_| slot.interest.readable) {
                    ready(socket, Interest::READ);
                    until = Deadline::Now;
                }
            }
        }
        let Self { platform, slots, .. } = self;
        let mut shakes_hands = false;
        platform.wait(until, &mut |socket, interest| match index_of(slots, socket, Some(socket))
            .map(|index| &mut slots[index])
        {
            Some(slot) if slot.channel.stage() == ChannelStage::Handshake => {
                (slot.is_ready, shakes_hands) = (true, true);
            }
            _ => ready(socket, interest),
        });
        if shakes_hands {
            self.advance(ready);
        }
    }

    fn interrupted(&mut self) -> bool {
        self.platform.interrupted()
    }
}
