// SPDX-License-Identifier: Apache-2.0
//! The session with the RTI: its connection, made, made again until the RTI has accepted the federate, and closed; and
//! the messages on it, in both directions.
//!
//! A session knows no tags: what the machine has to say it sends, and what comes it looks at as a policy says.

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
use crate::platform::{Interest, NetError, Platform, SocketId};
use crate::trace::{RTI, Recording};

/// How long one of several addresses may leave an attempt without an outcome.
const ATTEMPT_TIME_OUT: Interval = Interval::from_secs(5);

/// The session with the RTI.
#[derive(Debug)]
pub(super) struct Session<'a, 's> {
    pub(super) receiver: Receiver<'s>,
    /// The RTI's address, and those to try after it; the one in use has this place among them, from 0.
    first: Endpoint,
    others: &'a [Endpoint],
    place: u16,
    attempt: Attempt,
    retry: ConnectRetry,
    /// Why the last attempt failed.
    last_error: Option<NetError>,
    refusal: Refusal,
}

/// Whether the RTI has refused this federate because its id is taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Refusal {
    /// It has not.
    Never,
    /// It has, but something else has gone wrong since.
    Before,
    /// The last attempt ended like that.
    Last,
}

/// How far the connection is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Attempt {
    /// No connection, none under way; the next attempt is due at this time.
    Due(Instant),
    /// An attempt is under way; `true` when the socket says that it has an outcome.
    UnderWay(SocketId, bool),
    /// The connection is there.
    Made,
    /// It is closed for good.
    Over,
}

impl<'a, 's> Session<'a, 's> {
    /// A session that begins now.
    pub(super) fn new(now: Instant, join: &Join<'a>, connection: Connection<'s>) -> Self {
        let limits = Limits {
            // What the buffer holds is the limit; an input's own length is checked when its value is decoded.
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

    /// What is to be sent.
    pub(super) fn output(&mut self) -> &mut OutBuffer<&'s mut [u8]> {
        &mut self.receiver.connection.output
    }

    /// Whether messages can be exchanged.
    pub(super) fn is_open(&self) -> bool {
        self.attempt == Attempt::Made
    }

    /// Makes the connection, as far as that goes without waiting. `true` when it has just been made.
    ///
    /// # Errors
    /// When the time for it is over.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
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

    /// The address that is tried, or at which the RTI is.
    fn address<P: Platform>(&self) -> Endpoint {
        if !P::NAMES {
            return self.first;
        }
        let other = self.place.checked_sub(1).and_then(|index| self.others.get(usize::from(index)));
        other.copied().unwrap_or(self.first)
    }

    /// When an attempt without an outcome is over.
    fn attempt_ends(&self) -> Instant {
        let give_up = self.retry.give_up();
        if self.others.is_empty() { give_up } else { give_up.min(self.retry.last() + ATTEMPT_TIME_OUT) }
    }

    /// Drops a connection over which the RTI has refused this federate because its id is taken, and asks again as long
    /// as the RTI may take to notice that a federate is gone, from the first refusal on.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn ask_again<P: Platform>(&mut self, platform: &mut P) {
        if self.refusal == Refusal::Never {
            self.retry.renew(platform.now());
        }
        self.close(platform);
        self.attempt = Attempt::Due(platform.now());
        self.refusal = Refusal::Last;
    }

    /// The address at which the RTI is.
    pub(super) fn rti<P: Platform>(&self) -> IpAddress {
        self.address::<P>().ip
    }

    /// What this federate waits for, before the RTI has accepted it.
    pub(super) fn reason(&self, otherwise: Reason) -> Reason {
        if self.refusal == Refusal::Last { Reason::Id } else { otherwise }
    }

    /// What a federate waits for that has no connection.
    pub(super) fn missing(&self) -> Reason {
        Reason::Rti(self.first, self.last_error)
    }

    /// Reads once, if there is something to read, for [`Receiver::next`]. `true` when the connection has ended.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P) -> bool {
        self.receiver.resume();
        self.receiver.connection.fill(platform) == Reading::End
    }

    /// Moves what the machine has to say into the output buffer, and writes it.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
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

    /// Moves what the machine has to say into the output buffer, behind the messages of the tags it speaks of.
    pub(super) fn collect<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        machine: &mut Federate<'_, impl Needs>,
    ) {
        while let Some(message) = machine.poll_transmit(self.receiver.connection.output.room()) {
            // There is room: the machine was told how much, and gave a message that fits.
            let _ = self.receiver.connection.output.push(&message);
            recording.note_sent(platform, &message, RTI);
        }
    }

    /// Writes what is pending. `true` when the output buffer has become empty by it.
    ///
    /// A broken connection is not reported here: reading finds its end, after the peer's last words.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        if !self.is_open() || self.receiver.connection.output.is_empty() {
            return false;
        }
        if !self.receiver.connection.flush(platform) {
            self.receiver.connection.output.clear();
            self.receiver.connection.look();
            return false;
        }
        self.receiver.connection.output.is_empty()
    }

    /// Sends what is still to be said (RESIGN or FAILED), closes our direction, and awaits the RTI's end. `false` when
    /// there is nothing more to wait for.
    ///
    /// A socket that is closed while something is unread resets the connection, and what was sent last may be lost. So
    /// the RTI's last words are read.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
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

    /// Says what to wait for: bytes as long as there is space for them, and room if something is pending.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P) {
        if let Attempt::UnderWay(socket, _) = self.attempt {
            platform.set_interest(socket, Interest::WRITE);
        }
        self.receiver.connection.set_interest(platform, true);
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        if let Attempt::UnderWay(socket, has_outcome) = &mut self.attempt {
            *has_outcome |= *socket == ready;
        }
        self.receiver.connection.handle_ready(ready, interest);
    }

    /// When there is something to do though no socket is ready.
    pub(super) fn poll_timeout(&mut self) -> Deadline {
        match self.attempt {
            Attempt::Due(time) => Deadline::At(time),
            Attempt::UnderWay(..) => Deadline::At(self.attempt_ends()),
            // What is held may have room, or a write found the connection broken, and the end is to be read.
            Attempt::Made if self.receiver.held.stale || self.receiver.connection.is_due() => Deadline::Now,
            Attempt::Made | Attempt::Over => Deadline::Never,
        }
    }

    fn attempt_again<P: Platform>(&mut self, platform: &mut P) -> Result<(), Failed> {
        let now = platform.now();
        if P::NAMES && self.place > 0 {
            // The addresses of one host are tried one after the other without a pause.
            self.retry.hurry(now);
        }
        match self.retry.poll(now) {
            ConnectStep::Attempt => match platform.connect(self.address::<P>()) {
                Ok(socket) => self.attempt = Attempt::UnderWay(socket, false),
                Err(error) => self.begin_anew(platform, error),
            },
            ConnectStep::WaitUntil(time) => self.attempt = Attempt::Due(time),
            ConnectStep::GiveUp => return Err(Failed),
        }
        Ok(())
    }

    /// What is wrong when [`Session::establish`] fails.
    pub(super) fn unreachable(&self) -> RunError {
        match self.refusal {
            Refusal::Last => FederateError::Rejected(RejectCode::IdInUse).into(),
            _ => RunError::RtiUnreachable { address: self.first, last: self.last_error },
        }
    }
}
