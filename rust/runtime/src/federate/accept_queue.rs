// SPDX-License-Identifier: Apache-2.0
//! Incoming connections before the start, until the peer has sent its id.
//!
//! These connections use none of the slots of the other federates. They have few slots of their own; when these are in
//! use and another connection comes, it replaces the oldest, however short its time was: a federate introduces itself
//! at once.

use lf_coordination::peer::{Introduction, IntroductionVerdict};
use lf_coordination::{Deadline, FederateId, IpAddress, Tally, Times};
use lf_model::time::{Instant, Interval};
use lf_wire::{Message, RejectCode};

use crate::listener::Listener;
use crate::log_event::{PeerEvent, report};
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};
use log::Level;

/// The maximum number of such connections. The compiler counts their sockets, too.
const UNIDENTIFIED_MAX: usize = 2;
/// The time within which a peer has to send its id.
const INTRODUCTION_TIME_OUT: Interval = Interval::from_secs(10);
/// The same time while other connections wait for its slot.
const FULL_TIME_OUT: Interval = Interval::from_millis(250);
/// The number of bytes of an introduction to read at once.
const PIECE_BYTES: usize = 64;
/// The maximum number of bytes to read from a refused peer.
const UNREAD_BYTES_MAX: usize = 1024;

#[derive(Debug)]
struct Unidentified {
    socket: SocketId,
    address: IpAddress,
    introduction: Introduction,
    since: Instant,
    readable: bool,
}

/// A peer that has sent its id.
#[derive(Clone, Copy, Debug)]
pub(super) struct Introduced {
    pub(super) federate: FederateId,
    /// Whether it declares to be transient.
    pub(super) is_transient: bool,
    pub(super) socket: SocketId,
    pub(super) address: IpAddress,
}

/// The listener and the accepted connections without an id.
#[derive(Debug, Default)]
pub(super) struct AcceptQueue {
    listener: Listener,
    slots: [Option<Unidentified>; UNIDENTIFIED_MAX],
    /// The number of connections that ended without an id.
    unidentified: Tally,
    /// The number of refused connections.
    pub(super) refused: Tally,
}

impl AcceptQueue {
    /// Opens the port for connections; returns its number.
    pub(super) fn listen<P: Platform>(&mut self, platform: &mut P) -> Result<u16, NetError> {
        let listener = platform.listen(0)?;
        self.listener = Listener::new(listener);
        platform.local_port(listener)
    }

    /// Accepts pending connections, and returns a peer that has sent its id. Call it until it returns `None`.
    pub(super) fn receive<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8]) -> Option<Introduced> {
        let now = platform.now();
        self.accept(platform, now);
        for slot in &mut self.slots {
            let Some(peer) = slot else { continue };
            match peer.read(platform, federation_id) {
                ReadOutcome::Waits if peer.since + INTRODUCTION_TIME_OUT > now => {}
                ReadOutcome::Waits | ReadOutcome::Ended => {
                    drop_unidentified(platform, peer, self.unidentified.count());
                    *slot = None;
                }
                ReadOutcome::Refused(code) => {
                    refuse(platform, peer.socket, peer.address, code, self.refused.count());
                    *slot = None;
                }
                ReadOutcome::Is(federate, is_transient) => {
                    let introduced = Introduced { federate, is_transient, socket: peer.socket, address: peer.address };
                    *slot = None;
                    return Some(introduced);
                }
            }
        }
        None
    }

    /// Accepts pending connections, while there are slots or the time of an accepted one is over.
    fn accept<P: Platform>(&mut self, platform: &mut P, now: Instant) {
        while self.listener.has_pending(now)
            && let Some(slot) = self.slot(now)
            && let Some((socket, address)) = self.listener.accept(platform, now)
        {
            let introduction = Introduction::default();
            let peer = Unidentified { socket, address, introduction, since: now, readable: true };
            if let Some(before) = self.slots[slot].replace(peer) {
                drop_unidentified(platform, &before, self.unidentified.count());
            }
        }
    }

    /// Returns a slot for one more: a free one, or that of the oldest connection once its time is over.
    fn slot(&self, now: Instant) -> Option<usize> {
        let free = self.slots.iter().position(Option::is_none);
        free.or_else(|| self.oldest().filter(|(since, _)| *since + FULL_TIME_OUT <= now).map(|(_, slot)| slot))
    }

    fn oldest(&self) -> Option<(Instant, usize)> {
        let accept_queue = self.slots.iter().enumerate();
        accept_queue.filter_map(|(index, slot)| slot.as_ref().map(|peer| (peer.since, index))).min()
    }

    /// Sets what to wait for.
    pub(super) fn set_interest<P: Platform>(&self, platform: &mut P) {
        // A wait need not report a pending connection again.
        self.listener.set_interest(platform, !self.listener.is_known());
        for peer in self.slots.iter().flatten() {
            platform.set_interest(peer.socket, Interest::READ);
        }
    }

    /// Handles that a wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId) {
        self.listener.handle_ready(ready);
        for peer in self.slots.iter_mut().flatten().filter(|peer| peer.socket == ready) {
            peer.readable = true;
        }
    }

    /// Returns when there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&self) -> Deadline {
        let has_slot = self.slots.iter().any(Option::is_none);
        let accepts = self.listener.poll_timeout(has_slot);
        let Some((since, _)) = self.oldest() else { return accepts };
        let is_full = self.listener.is_known() && !has_slot;
        accepts.min(Deadline::At(since + if is_full { FULL_TIME_OUT } else { INTRODUCTION_TIME_OUT }))
    }

    /// Closes all connections, and the port.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        for peer in self.slots.iter_mut().filter_map(Option::take) {
            platform.close(peer.socket);
        }
        self.listener.close(platform);
    }
}

/// The outcome of reading an introduction.
enum ReadOutcome {
    /// It is incomplete.
    Waits,
    /// The peer has left.
    Ended,
    /// It is this federate, and whether it declares to be transient.
    Is(FederateId, bool),
    Refused(RejectCode),
}

impl Unidentified {
    /// Reads its introduction as far as it has come, and not a byte more.
    fn read<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8]) -> ReadOutcome {
        loop {
            let missing = match self.introduction.judge(federation_id) {
                IntroductionVerdict::Incomplete(missing) => missing.min(PIECE_BYTES),
                IntroductionVerdict::Introduced(federate) => return ReadOutcome::Is(federate, false),
                IntroductionVerdict::Transient(federate) => return ReadOutcome::Is(federate, true),
                IntroductionVerdict::Refuse(code) => return ReadOutcome::Refused(code),
            };
            if !self.readable {
                return ReadOutcome::Waits;
            }
            let mut bytes = [0; PIECE_BYTES];
            match platform.read(self.socket, &mut bytes[..missing]) {
                Ok(Transfer::Bytes(count)) => self.introduction.take(&bytes[..count], federation_id),
                Ok(Transfer::WouldBlock) => self.readable = false,
                Ok(Transfer::Closed) | Err(_) => return ReadOutcome::Ended,
            }
        }
    }
}

/// Refuses a federate that declares to be transient, which this one does not expect of it.
pub(super) fn refuse_transient<P: Platform>(platform: &mut P, peer: Introduced, times: Times) {
    if times.is_logged() {
        report(Level::Warn, &PeerEvent::Transient { federate: peer.federate.0, times });
    }
    reject(platform, peer.socket, RejectCode::UnexpectedMessage);
}

/// Sends a peer why it is refused, and closes the connection.
pub(super) fn refuse<P: Platform>(
    platform: &mut P,
    socket: SocketId,
    address: IpAddress,
    code: RejectCode,
    times: Times,
) {
    if times.is_logged() {
        report(Level::Warn, &PeerEvent::Refused { address, code, times });
    }
    reject(platform, socket, code);
}

/// Sends REJECT and closes the connection.
fn reject<P: Platform>(platform: &mut P, socket: SocketId, code: RejectCode) {
    let mut bytes = [0; 2];
    let mut rest = Message::Reject(code).encode(&mut bytes).map_or(&[][..], |length| &bytes[..length]);
    // The first bytes of a connection always have room.
    while !rest.is_empty()
        && let Ok(Transfer::Bytes(count)) = platform.write(socket, rest)
    {
        rest = rest.get(count..).unwrap_or_default();
    }
    platform.shut_down_writing(socket);
    // A socket that is closed with unread bytes resets the connection, and the code may be lost.
    for _ in 0..UNREAD_BYTES_MAX / PIECE_BYTES {
        if !matches!(platform.read(socket, &mut [0; PIECE_BYTES]), Ok(Transfer::Bytes(_))) {
            break;
        }
    }
    platform.close(socket);
}

/// Closes a connection whose peer has not sent its id. Logs it now and then, because anybody can connect.
fn drop_unidentified<P: Platform>(platform: &mut P, peer: &Unidentified, times: Times) {
    let Unidentified { socket, address, .. } = *peer;
    platform.close(socket);
    if times.is_logged() {
        report(Level::Warn, &PeerEvent::Unidentified { address, times });
    }
}
