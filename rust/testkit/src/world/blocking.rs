// SPDX-License-Identifier: Apache-2.0
//! A participant that a test plays.

use lf_coordination::Deadline;
use lf_model::time::{Instant, Interval};
use lf_runtime::platform::{Endpoint, Interest, Platform as _, SocketId, Transfer};
use lf_wire::Message;

use super::Virtual;
use crate::messages::encoded;

/// The longest wait for anything, in virtual time.
const WAIT_MAX: Interval = Interval::from_secs(120);

/// A participant whose calls block until they are done. Each panics if nothing happens for minutes.
#[derive(Debug)]
pub struct Blocking {
    /// Its platform, for calls that do not block.
    pub platform: Virtual,
}

impl Blocking {
    /// Returns a participant that waits for its first turn.
    pub fn new(mut platform: Virtual) -> Self {
        platform.begin();
        Self { platform }
    }

    /// Repeats the question whenever the socket becomes ready, until there is an answer.
    ///
    /// # Panics
    /// If there is none.
    pub fn ask<T>(
        &mut self,
        socket: SocketId,
        interest: Interest,
        mut question: impl FnMut(&mut Virtual) -> Option<T>,
    ) -> T {
        let until = self.now() + WAIT_MAX;
        loop {
            if let Some(found) = question(&mut self.platform) {
                self.platform.set_interest(socket, Interest::NONE);
                return found;
            }
            assert!(!self.platform.interrupted() && self.now() < until, "the others do nothing");
            self.platform.set_interest(socket, interest);
            self.platform.wait(Deadline::At(until), &mut |_, _| {});
        }
    }

    /// Accepts a connection.
    ///
    /// # Panics
    /// If no peer connects.
    pub fn accept(&mut self, listener: SocketId) -> SocketId {
        self.ask(listener, Interest::READ, |platform| platform.accept(listener).expect("it listens")).0
    }

    /// Connects.
    ///
    /// # Panics
    /// If there is no answer.
    pub fn connect(&mut self, address: Endpoint) -> SocketId {
        let socket = self.platform.connect(address).expect("there are places for sockets");
        self.ask(socket, Interest::WRITE, |platform| platform.connected(socket).ok());
        socket
    }

    /// Sends a message, and waits until the network has taken it.
    ///
    /// # Panics
    /// If the connection is closed.
    pub fn say(&mut self, socket: SocketId, message: &Message<'_>) {
        self.say_bytes(socket, &encoded(message));
    }

    /// Sends bytes, and waits until the network has taken them.
    ///
    /// # Panics
    /// If the connection is closed.
    pub fn say_bytes(&mut self, socket: SocketId, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let count = self.ask(socket, Interest::WRITE, |platform| match platform.write(socket, rest) {
                Ok(Transfer::Bytes(count)) => Some(count),
                Ok(Transfer::WouldBlock) => None,
                other => panic!("the connection is closed: {other:?}"),
            });
            rest = &rest[count..];
        }
    }

    /// Reads at most this number of bytes; returns none once the connection has ended or is broken.
    ///
    /// # Panics
    /// If nothing arrives.
    pub fn hear_some(&mut self, socket: SocketId, most: usize) -> Vec<u8> {
        let mut bytes = vec![0; most];
        let count = self.ask(socket, Interest::READ, |platform| match platform.read(socket, &mut bytes) {
            Ok(Transfer::Bytes(count)) => Some(count),
            Ok(Transfer::WouldBlock) => None,
            Ok(Transfer::Closed) | Err(_) => Some(0),
        });
        bytes.truncate(count);
        bytes
    }

    /// Reads this number of bytes.
    ///
    /// # Panics
    /// If the connection ends earlier.
    pub fn hear(&mut self, socket: SocketId, count: usize) -> Vec<u8> {
        let mut heard = Vec::new();
        while heard.len() < count {
            let some = self.hear_some(socket, count - heard.len());
            assert!(!some.is_empty(), "the connection has ended after {} of {count} bytes", heard.len());
            heard.extend(some);
        }
        heard
    }

    /// Reads bytes until the connection has ended or is broken.
    ///
    /// # Panics
    /// If it does not end.
    pub fn hear_to_end(&mut self, socket: SocketId) -> Vec<u8> {
        let mut heard = Vec::new();
        loop {
            let some = self.hear_some(socket, 64);
            if some.is_empty() {
                return heard;
            }
            heard.extend(some);
        }
    }

    /// Lets virtual time pass until its clock shows this time.
    pub fn pass_until(&mut self, until: Instant) {
        while self.now() < until {
            self.platform.wait(Deadline::At(until), &mut |_, _| {});
        }
    }

    /// Returns the time of its clock.
    pub fn now(&mut self) -> Instant {
        self.platform.now()
    }
}
