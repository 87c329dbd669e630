// SPDX-License-Identifier: Apache-2.0
//! Who connects before the start, until it has said which federate it is.
//!
//! A peer takes none of the places that the other federates have. There are few places for accept_queue; when they are
//! taken and another one comes, the oldest has had its time, however short: a federate introduces itself at once.

use lf_coordination::peer::{Introduction, IntroductionVerdict};
use lf_coordination::{Deadline, FederateId, IpAddress, Tally, Times};
use lf_model::time::{Instant, Interval};
use lf_wire::{Message, RejectCode};

use crate::listener::Listener;
use crate::log_event::{PeerEvent, report};
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};
use log::Level;

/// How many accept_queue there can be at once. The compiler counts their sockets, too.
const UNIDENTIFIED_MAX: usize = 2;
/// How long a peer may take to say who it is.
const INTRODUCTION_TIME_OUT: Interval = Interval::from_secs(10);
/// How long it has for that while others wait for its place.
const FULL_TIME_OUT: Interval = Interval::from_millis(250);
/// How many bytes of an introduction are read at once.
const PIECE_BYTES: usize = 64;
/// How much of what a refused peer has said is read at most.
const UNREAD_BYTES_MAX: usize = 1024;

#[derive(Debug)]
struct Unidentified {
    socket: SocketId,
    address: IpAddress,
    introduction: Introduction,
    since: Instant,
    readable: bool,
}

/// A peer that has said which federate it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Introduced {
    pub(super) federate: FederateId,
    pub(super) socket: SocketId,
    pub(super) address: IpAddress,
}

/// The listener and those who have come to it.
#[derive(Debug, Default)]
pub(super) struct AcceptQueue {
    listener: Listener,
    places: [Option<Unidentified>; UNIDENTIFIED_MAX],
    /// How many have gone without having said who they are.
    unidentified: Tally,
    /// How many have been refused.
    pub(super) refused: Tally,
}

impl AcceptQueue {
    /// Begins to await connections; gives the port.
    pub(super) fn listen<P: Platform>(&mut self, platform: &mut P) -> Result<u16, NetError> {
        let listener = platform.listen(0)?;
        self.listener = Listener::new(listener);
        platform.local_port(listener)
    }

    /// Takes those that wait, and gives one that has said which federate it is. To be called until there is none.
    pub(super) fn receive<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8]) -> Option<Introduced> {
        let now = platform.now();
        self.accept(platform, now);
        for place in &mut self.places {
            let Some(peer) = place else { continue };
            match peer.read(platform, federation_id) {
                ReadOutcome::Waits if peer.since + INTRODUCTION_TIME_OUT > now => {}
                ReadOutcome::Waits | ReadOutcome::Ended => {
                    drop_unidentified(platform, peer, self.unidentified.count());
                    *place = None;
                }
                ReadOutcome::Refused(code) => {
                    refuse(platform, peer.socket, peer.address, code, self.refused.count());
                    *place = None;
                }
                ReadOutcome::IsTransient(federate) => {
                    let times = self.refused.count();
                    if times.is_logged() {
                        report(Level::Warn, &PeerEvent::Transient { federate: federate.0, times });
                    }
                    reject(platform, peer.socket, RejectCode::UnexpectedMessage);
                    *place = None;
                }
                ReadOutcome::Is(federate) => {
                    let introduced = Introduced { federate, socket: peer.socket, address: peer.address };
                    *place = None;
                    return Some(introduced);
                }
            }
        }
        None
    }

    /// Takes those that wait, as long as there are places or somebody has had its time.
    fn accept<P: Platform>(&mut self, platform: &mut P, now: Instant) {
        while self.listener.has_pending(now)
            && let Some(place) = self.place(now)
            && let Some((socket, address)) = self.listener.accept(platform, now)
        {
            let introduction = Introduction::default();
            let peer = Unidentified { socket, address, introduction, since: now, readable: true };
            if let Some(before) = self.places[place].replace(peer) {
                drop_unidentified(platform, &before, self.unidentified.count());
            }
        }
    }

    /// A place for one more: a free one, or that of the oldest peer once it has had its time.
    fn place(&self, now: Instant) -> Option<usize> {
        let free = self.places.iter().position(Option::is_none);
        free.or_else(|| self.oldest().filter(|(since, _)| *since + FULL_TIME_OUT <= now).map(|(_, place)| place))
    }

    fn oldest(&self) -> Option<(Instant, usize)> {
        let accept_queue = self.places.iter().enumerate();
        accept_queue.filter_map(|(index, place)| place.as_ref().map(|peer| (peer.since, index))).min()
    }

    /// Says what to wait for.
    pub(super) fn set_interest<P: Platform>(&self, platform: &mut P) {
        // Who is known to wait need not be told of again.
        self.listener.set_interest(platform, !self.listener.is_known());
        for peer in self.places.iter().flatten() {
            platform.set_interest(peer.socket, Interest::READ);
        }
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId) {
        self.listener.handle_ready(ready);
        for peer in self.places.iter_mut().flatten().filter(|peer| peer.socket == ready) {
            peer.readable = true;
        }
    }

    /// When there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&self) -> Deadline {
        let has_place = self.places.iter().any(Option::is_none);
        let accepts = self.listener.poll_timeout(has_place);
        let Some((since, _)) = self.oldest() else { return accepts };
        let is_full = self.listener.is_known() && !has_place;
        accepts.min(Deadline::At(since + if is_full { FULL_TIME_OUT } else { INTRODUCTION_TIME_OUT }))
    }

    /// Awaits nobody any more.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        for peer in self.places.iter_mut().filter_map(Option::take) {
            platform.close(peer.socket);
        }
        self.listener.close(platform);
    }
}

/// What a peer has said.
enum ReadOutcome {
    /// Not all yet.
    Waits,
    /// It has gone.
    Ended,
    Is(FederateId),
    IsTransient(FederateId),
    Refused(RejectCode),
}

impl Unidentified {
    /// Reads what has come of its introduction, and not a byte more.
    fn read<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8]) -> ReadOutcome {
        loop {
            let missing = match self.introduction.judge(federation_id) {
                IntroductionVerdict::Incomplete(missing) => missing.min(PIECE_BYTES),
                IntroductionVerdict::Introduced(federate) => return ReadOutcome::Is(federate),
                IntroductionVerdict::Transient(federate) => return ReadOutcome::IsTransient(federate),
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

/// Tells whoever has connected why it is refused, and closes the connection.
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
    // The first bytes of a connection always find room.
    while !rest.is_empty()
        && let Ok(Transfer::Bytes(count)) = platform.write(socket, rest)
    {
        rest = rest.get(count..).unwrap_or_default();
    }
    platform.shut_down_writing(socket);
    // A socket that is closed with something unread resets the connection, and the code may be lost.
    for _ in 0..UNREAD_BYTES_MAX / PIECE_BYTES {
        if !matches!(platform.read(socket, &mut [0; PIECE_BYTES]), Ok(Transfer::Bytes(_))) {
            break;
        }
    }
    platform.close(socket);
}

/// Closes a connection whose peer has not said who it is: told now and then, for anybody can connect.
fn drop_unidentified<P: Platform>(platform: &mut P, peer: &Unidentified, times: Times) {
    let Unidentified { socket, address, .. } = *peer;
    platform.close(socket);
    if times.is_logged() {
        report(Level::Warn, &PeerEvent::Unidentified { address, times });
    }
}
