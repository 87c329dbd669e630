// SPDX-License-Identifier: Apache-2.0
//! Who connects before the start, until it has said which federate it is.
//!
//! A visitor takes none of the places that the other federates have. There are few places for visitors; when they are
//! taken and another one comes, the oldest has had its time, however short: a federate introduces itself at once.

use lf_coordination::peer::{Introduction, IntroductionVerdict};
use lf_coordination::{Deadline, FederateId, IpAddress, Tally, Times};
use lf_model::time::{Instant, Interval};
use lf_wire::{Message, RejectCode};

use crate::listener::Listener;
use crate::log_event::{PeerEvent, report};
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};
use log::Level;

/// How many visitors there can be at once. The compiler counts their sockets, too.
const VISITORS_MAX: usize = 2;
/// How long a visitor may take to say who it is.
const INTRODUCTION_TIME_OUT: Interval = Interval::from_secs(10);
/// How long it has for that while others wait for its place.
const CROWDED_TIME_OUT: Interval = Interval::from_millis(250);
/// How many bytes of an introduction are read at once.
const PIECE_BYTES: usize = 64;
/// How much of what a refused visitor has said is read at most.
const UNREAD_BYTES_MAX: usize = 1024;

#[derive(Debug)]
struct Visitor {
    socket: SocketId,
    address: IpAddress,
    introduction: Introduction,
    since: Instant,
    readable: bool,
}

/// A visitor that has said which federate it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Introduced {
    pub(super) federate: FederateId,
    pub(super) socket: SocketId,
    pub(super) address: IpAddress,
}

/// The listener and those who have come to it.
#[derive(Debug, Default)]
pub(super) struct Visitors {
    listener: Listener,
    places: [Option<Visitor>; VISITORS_MAX],
    /// How many have gone without having said who they are.
    nameless: Tally,
    /// How many have been refused.
    pub(super) refused: Tally,
}

impl Visitors {
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
            let Some(visitor) = place else { continue };
            match visitor.read(platform, federation_id) {
                Said::Waits if visitor.since + INTRODUCTION_TIME_OUT > now => {}
                Said::Waits | Said::Ended => {
                    turn_away(platform, visitor, self.nameless.count());
                    *place = None;
                }
                Said::Refused(code) => {
                    refuse(platform, visitor.socket, visitor.address, code, self.refused.count());
                    *place = None;
                }
                Said::IsTransient(federate) => {
                    let times = self.refused.count();
                    if times.is_logged() {
                        report(Level::Warn, &PeerEvent::Transient { federate: federate.0, times });
                    }
                    reject(platform, visitor.socket, RejectCode::UnexpectedMessage);
                    *place = None;
                }
                Said::Is(federate) => {
                    let introduced = Introduced { federate, socket: visitor.socket, address: visitor.address };
                    *place = None;
                    return Some(introduced);
                }
            }
        }
        None
    }

    /// Takes those that wait, as long as there are places or somebody has had its time.
    fn accept<P: Platform>(&mut self, platform: &mut P, now: Instant) {
        while self.listener.knocks(now)
            && let Some(place) = self.place(now)
            && let Some((socket, address)) = self.listener.accept(platform, now)
        {
            let introduction = Introduction::default();
            let visitor = Visitor { socket, address, introduction, since: now, readable: true };
            if let Some(before) = self.places[place].replace(visitor) {
                turn_away(platform, &before, self.nameless.count());
            }
        }
    }

    /// A place for one more: a free one, or that of the oldest visitor once it has had its time.
    fn place(&self, now: Instant) -> Option<usize> {
        let free = self.places.iter().position(Option::is_none);
        free.or_else(|| self.oldest().filter(|(since, _)| *since + CROWDED_TIME_OUT <= now).map(|(_, place)| place))
    }

    fn oldest(&self) -> Option<(Instant, usize)> {
        let visitors = self.places.iter().enumerate();
        visitors.filter_map(|(index, place)| place.as_ref().map(|visitor| (visitor.since, index))).min()
    }

    /// Says what to wait for.
    pub(super) fn set_interest<P: Platform>(&self, platform: &mut P) {
        // Who is known to wait need not be told of again.
        self.listener.set_interest(platform, !self.listener.is_known());
        for visitor in self.places.iter().flatten() {
            platform.set_interest(visitor.socket, Interest::READ);
        }
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId) {
        self.listener.handle_ready(ready);
        for visitor in self.places.iter_mut().flatten().filter(|visitor| visitor.socket == ready) {
            visitor.readable = true;
        }
    }

    /// When there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&self) -> Deadline {
        let has_place = self.places.iter().any(Option::is_none);
        let accepts = self.listener.poll_timeout(has_place);
        let Some((since, _)) = self.oldest() else { return accepts };
        let crowded = self.listener.is_known() && !has_place;
        accepts.min(Deadline::At(since + if crowded { CROWDED_TIME_OUT } else { INTRODUCTION_TIME_OUT }))
    }

    /// Awaits nobody any more.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        for visitor in self.places.iter_mut().filter_map(Option::take) {
            platform.close(visitor.socket);
        }
        self.listener.close(platform);
    }
}

/// What a visitor has said.
enum Said {
    /// Not all yet.
    Waits,
    /// It has gone.
    Ended,
    Is(FederateId),
    IsTransient(FederateId),
    Refused(RejectCode),
}

impl Visitor {
    /// Reads what has come of its introduction, and not a byte more.
    fn read<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8]) -> Said {
        loop {
            let missing = match self.introduction.judge(federation_id) {
                IntroductionVerdict::Incomplete(missing) => missing.min(PIECE_BYTES),
                IntroductionVerdict::Introduced(federate) => return Said::Is(federate),
                IntroductionVerdict::Transient(federate) => return Said::IsTransient(federate),
                IntroductionVerdict::Refuse(code) => return Said::Refused(code),
            };
            if !self.readable {
                return Said::Waits;
            }
            let mut bytes = [0; PIECE_BYTES];
            match platform.read(self.socket, &mut bytes[..missing]) {
                Ok(Transfer::Bytes(count)) => self.introduction.take(&bytes[..count], federation_id),
                Ok(Transfer::WouldBlock) => self.readable = false,
                Ok(Transfer::Closed) | Err(_) => return Said::Ended,
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

/// Closes a connection whose visitor has not said who it is: told now and then, for anybody can connect.
fn turn_away<P: Platform>(platform: &mut P, visitor: &Visitor, times: Times) {
    let Visitor { socket, address, .. } = *visitor;
    platform.close(socket);
    if times.is_logged() {
        report(Level::Warn, &PeerEvent::Nameless { address, times });
    }
}
