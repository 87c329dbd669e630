// SPDX-License-Identifier: Apache-2.0
//! The session with the RTI: its connection, which is made again until the RTI has accepted the federate, and closed;
//! and the messages on it, in both directions.
//!
//! A session knows no tags: it sends the machine's messages, and examines incoming ones by a policy.

use lf_coordination::federate::{ConnectRetry, ConnectStep, Federate, FederateError, Needs};
use lf_coordination::{Deadline, Endpoint, IpAddress};
use lf_model::time::{Instant, Interval};
use lf_wire::{Limits, OutBuffer, RejectCode};

use super::execution::Failed;
use super::join::Join;
use super::reason::Reason;
use super::receiver::Receiver;
use crate::connection::{Connection, Reading};
use crate::error::RunError;
#[cfg(feature = "security")]
use crate::platform::Participant;
use crate::platform::{Interest, NetError, Platform, SocketId};
use crate::trace::{RTI, Recording};

/// The time that one of several addresses may take for an attempt without an outcome.
const ATTEMPT_TIME_OUT: Interval = Interval::from_secs(5);

/// The session with the RTI.
#[derive(Debug)]
pub(super) struct Session<'a, 's> {
    pub(super) receiver: Receiver<'s>,
    /// The RTI's address, and those to try after it; the one in use has this index among them, from 0.
    first: Endpoint,
    others: &'a [Endpoint],
    place: u16,
    attempt: Attempt,
    retry: ConnectRetry,
    /// The error of the last attempt.
    last_error: Option<NetError>,
    refusal: Refusal,
}

/// Whether the RTI has refused this federate because its id is in use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Refusal {
    /// It has not.
    Never,
    /// It has, but something else has gone wrong since.
    Before,
    /// The last attempt ended like that.
    Last,
}

/// The stage of the connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Attempt {
    /// There is neither a connection nor an attempt; the next attempt is due at this time.
    Due(Instant),
    /// An attempt is open; `true` when the socket reports an outcome.
    UnderWay(SocketId, bool),
    /// The connection is there.
    Made,
    /// It is closed for good.
    Over,
}

impl<'a, 's> Session<'a, 's> {
    /// Returns a session that begins now.
    pub(super) fn new(now: Instant, join: &Join<'a>, connection: Connection<'s>) -> Self {
        let limits = Limits {
            // The capacity of the buffer is the limit; an input's own length is checked when its value is decoded.
            payload_bytes_max: connection.input.capacity(),
            federation_id_bytes_max: 0,
            neighbors_max: 0,
        };
        let (receiver, retry) = (Receiver::new(connection, limits), ConnectRetry::new(now));
        Self {
            receiver,
            first: join.rti,
            others: join.others,
            place: 0,
            attempt: Attempt::Due(now),
            retry,
            last_error: None,
            refusal: Refusal::Never,
        }
    }

    /// Returns the send buffer.
    pub(super) fn output(&mut self) -> &mut OutBuffer<&'s mut [u8]> {
        &mut self.receiver.connection.output
    }

    /// Returns whether messages can be exchanged.
    pub(super) fn is_open(&self) -> bool {
        self.attempt == Attempt::Made
    }

    /// Makes the connection, as far as that goes without waiting. Returns `true` when it has just been made.
    ///
    /// # Errors
    /// When the time for it is over.
    pub(super) fn establish<P: Platform>(&mut self, platform: &mut P) -> Result<bool, Failed> {
        match self.attempt {
            Attempt::Due(_) => self.attempt_again(platform).map(|()| false),
            Attempt::UnderWay(socket, true) => match platform.connected(socket) {
                Ok(()) => {
                    self.receiver.connection.open(socket);
                    self.attempt = Attempt::Made;
                    Ok(true)
                }
                Err(error) => {
                    self.begin_anew(platform, error);
                    self.attempt_again(platform).map(|()| false)
                }
            },
            Attempt::UnderWay(..) if platform.now() >= self.retry.give_up() => Err(Failed),
            Attempt::UnderWay(..) if P::NAMES && platform.now() >= self.attempt_ends() => {
                self.begin_anew(platform, NetError::Unreachable);
                self.attempt_again(platform).map(|()| false)
            }
            Attempt::UnderWay(..) | Attempt::Made | Attempt::Over => Ok(false),
        }
    }

    /// Returns why the connection has ended.
    #[cfg_attr(not(feature = "security"), allow(clippy::unused_self, reason = "only encryption knows more"))]
    pub(super) fn end_reason<P: Platform>(&self, platform: &P) -> NetError {
        #[cfg(feature = "security")]
        if let Some(reason) = self.receiver.connection.socket().and_then(|socket| platform.failure(socket)) {
            return reason;
        }
        #[cfg(not(feature = "security"))]
        let _ = platform;
        NetError::Reset
    }

    /// Drops a connection that ended before the RTI accepted the federate, or could not be made, for this reason;
    /// [`Session::establish`] makes the next one.
    pub(super) fn begin_anew<P: Platform>(&mut self, platform: &mut P, reason: NetError) {
        self.close(platform);
        self.last_error = Some(reason);
        self.attempt = Attempt::Due(platform.now());
        if self.refusal == Refusal::Last {
            self.refusal = Refusal::Before;
        }
        if P::NAMES {
            self.place = if usize::from(self.place) < self.others.len() { self.place + 1 } else { 0 };
        }
    }

    /// Returns the address that is tried, or at which the RTI is.
    fn address<P: Platform>(&self) -> Endpoint {
        if !P::NAMES {
            return self.first;
        }
        let other = self.place.checked_sub(1).and_then(|index| self.others.get(usize::from(index)));
        other.copied().unwrap_or(self.first)
    }

    /// Returns when an attempt without an outcome is over.
    fn attempt_ends(&self) -> Instant {
        let give_up = self.retry.give_up();
        if self.others.is_empty() { give_up } else { give_up.min(self.retry.last() + ATTEMPT_TIME_OUT) }
    }

    /// Drops a connection over which the RTI has refused this federate because its id is in use, and tries again as
    /// long as the RTI may take to detect that a federate is gone, from the first refusal on.
    pub(super) fn ask_again<P: Platform>(&mut self, platform: &mut P) {
        if self.refusal == Refusal::Never {
            self.retry.renew(platform.now());
        }
        self.close(platform);
        self.attempt = Attempt::Due(platform.now());
        self.refusal = Refusal::Last;
    }

    /// Returns the address at which the RTI is.
    pub(super) fn rti<P: Platform>(&self) -> IpAddress {
        self.address::<P>().ip
    }

    /// Returns what this federate waits for, before the RTI has accepted it.
    pub(super) fn reason(&self, otherwise: Reason) -> Reason {
        if self.refusal == Refusal::Last { Reason::Id } else { otherwise }
    }

    /// Returns what a federate without a connection waits for.
    pub(super) fn missing(&self) -> Reason {
        Reason::Rti(self.first, self.last_error)
    }

    /// Reads once, if there is something to read, for [`Receiver::next`]. Returns `true` when the connection has ended.
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P) -> bool {
        self.receiver.resume();
        self.receiver.connection.fill(platform) == Reading::End
    }

    /// Moves the machine's messages into the output buffer, and writes it.
    pub(super) fn transmit<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        machine: &mut Federate<'_, impl Needs>,
    ) {
        while self.is_open() {
            self.collect(platform, recording, machine);
            if !self.flush(platform) {
                return;
            }
            machine.handle_written(platform.now());
            if !machine.has_transmit() {
                return;
            }
        }
    }

    /// Moves the machine's messages into the output buffer, behind the messages of the tags that they cover.
    pub(super) fn collect<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        machine: &mut Federate<'_, impl Needs>,
    ) {
        while let Some(message) = machine.poll_transmit(self.receiver.connection.output.room()) {
            // There is room: the machine knows how much, and returned a message that fits.
            let _ = self.receiver.connection.output.push(&message);
            recording.note_sent(platform, &message, RTI);
        }
    }

    /// Writes what is pending. Returns `true` when this has emptied the output buffer.
    ///
    /// A broken connection is not reported here: reading finds its end, after the peer's last messages.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        if !self.is_open() || self.receiver.connection.output.is_empty() {
            return false;
        }
        if !self.receiver.connection.flush(platform) {
            self.receiver.connection.output.clear();
            self.receiver.connection.mark_readable();
            return false;
        }
        self.receiver.connection.output.is_empty()
    }

    /// Sends the final messages (RESIGN or FAILED), closes our direction, and awaits the RTI's end. Returns `false`
    /// when there is nothing more to wait for.
    ///
    /// A socket that is closed with unread bytes resets the connection, and the last messages may be lost. So the RTI's
    /// last messages are read.
    pub(super) fn leave<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        machine: &mut Federate<'_, impl Needs>,
    ) -> bool {
        let Some(socket) = self.receiver.connection.socket() else { return false };
        self.transmit(platform, recording, machine);
        if self.receiver.connection.output.is_empty() && !machine.has_transmit() {
            platform.shut_down_writing(socket);
        }
        self.receiver.connection.input.clear();
        if self.receiver.connection.has_ended() || self.receiver.connection.fill(platform) == Reading::End {
            return false;
        }
        self.set_interest(platform);
        true
    }

    /// Closes the connection for good.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Attempt::UnderWay(socket, _) = self.attempt {
            platform.close(socket);
        }
        self.receiver.close(platform);
        self.attempt = Attempt::Over;
    }

    /// Sets what to wait for: bytes while there is space for them, and room if something is pending.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P) {
        if let Attempt::UnderWay(socket, _) = self.attempt {
            platform.set_interest(socket, Interest::WRITE);
        }
        self.receiver.connection.set_interest(platform, true);
    }

    /// Handles that a wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        if let Attempt::UnderWay(socket, has_outcome) = &mut self.attempt {
            *has_outcome |= *socket == ready;
        }
        self.receiver.connection.handle_ready(ready, interest);
    }

    /// Returns when there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&mut self) -> Deadline {
        match self.attempt {
            Attempt::Due(time) => Deadline::At(time),
            Attempt::UnderWay(..) => Deadline::At(self.attempt_ends()),
            // Held messages may have room, or a write found the connection broken, and the end is to be read.
            Attempt::Made if self.receiver.held.stale || self.receiver.connection.is_due() => Deadline::Now,
            Attempt::Made | Attempt::Over => Deadline::Never,
        }
    }

    fn attempt_again<P: Platform>(&mut self, platform: &mut P) -> Result<(), Failed> {
        let now = platform.now();
        if P::NAMES && self.place > 0 {
            // The addresses of one host are tried one after the other without a pause.
            self.retry.retry_now(now);
        }
        match self.retry.poll(now) {
            ConnectStep::Attempt => match platform.connect(self.address::<P>()) {
                Ok(socket) => {
                    #[cfg(feature = "security")]
                    platform.require(socket, Participant::Rti);
                    self.attempt = Attempt::UnderWay(socket, false);
                }
                Err(error) => self.begin_anew(platform, error),
            },
            ConnectStep::WaitUntil(time) => self.attempt = Attempt::Due(time),
            ConnectStep::GiveUp => return Err(Failed),
        }
        Ok(())
    }

    /// Returns the error when [`Session::establish`] fails.
    pub(super) fn unreachable(&self) -> RunError {
        match self.refusal {
            Refusal::Last => FederateError::Rejected(RejectCode::IdInUse).into(),
            _ => RunError::RtiUnreachable { address: self.first, last: self.last_error },
        }
    }
}
