// SPDX-License-Identifier: Apache-2.0
//! Sockets that listen for connections.

use lf_coordination::{Deadline, IpAddress, Tally};
use lf_model::time::{Instant, Interval};

use crate::log_event::{ConnectionEvent, report};
use crate::platform::{Interest, Platform, SocketId};
use log::Level;

/// The time for which no connection is accepted after the system had no resources for one.
const ACCEPT_PAUSE: Interval = Interval::from_millis(100);

/// A listening socket, while there is one, and whether connections are pending there.
#[derive(Debug, Default)]
pub(crate) struct Listener {
    socket: Option<SocketId>,
    /// Whether a connection may be pending.
    pending: bool,
    /// Whether a wait has reported one since the last was accepted.
    ready: bool,
    /// The time at which to accept again after the system had no resources.
    again: Option<Instant>,
    /// The number of times that it had none.
    failures: Tally,
}

impl Listener {
    /// Returns a listener that may have a pending connection already.
    pub(crate) fn new(socket: SocketId) -> Self {
        Self { socket: Some(socket), pending: true, ..Self::default() }
    }

    /// Returns whether a connection may be pending, and may be accepted now.
    pub(crate) fn has_pending(&mut self, now: Instant) -> bool {
        if self.again.is_some_and(|time| time <= now) {
            self.mark_pending();
        }
        self.pending && self.again.is_none() && self.socket.is_some()
    }

    /// Returns whether a connection may be pending: then no wait has to report it.
    pub(crate) fn is_known(&self) -> bool {
        self.pending
    }

    /// Marks a connection as pending, though no wait has reported it.
    pub(crate) fn mark_pending(&mut self) {
        (self.again, self.pending) = (None, true);
    }

    /// Postpones a connection, because there is no slot. Returns whether one is pending for sure: a wait has reported
    /// it since the last was accepted.
    pub(crate) fn postpone(&mut self) -> bool {
        self.pending = core::mem::take(&mut self.ready);
        self.pending
    }

    /// Accepts a connection, if one is pending.
    pub(crate) fn accept<P: Platform>(&mut self, platform: &mut P, now: Instant) -> Option<(SocketId, IpAddress)> {
        self.ready = false;
        match platform.accept(self.socket?) {
            Ok(Some(connection)) => return Some(connection),
            Ok(None) => {}
            Err(error) => {
                // The connection is still pending, so the listener stays ready: an immediate retry would never end.
                let times = self.failures.count();
                if times.is_logged() {
                    report(Level::Warn, &ConnectionEvent::NotAccepted { error, times });
                }
                self.again = Some(now + ACCEPT_PAUSE);
            }
        }
        self.pending = false;
        None
    }

    /// Sets whether to wait for connections.
    pub(crate) fn set_interest<P: Platform>(&self, platform: &mut P, wanted: bool) {
        if let Some(socket) = self.socket {
            let wanted = wanted && self.again.is_none();
            platform.set_interest(socket, if wanted { Interest::READ } else { Interest::NONE });
        }
    }

    /// Handles that a wait found this socket ready. Returns `true` if it is this one.
    pub(crate) fn handle_ready(&mut self, ready: SocketId) -> bool {
        let is_it = self.socket == Some(ready);
        (self.pending, self.ready) = (self.pending | is_it, self.ready | is_it);
        is_it
    }

    /// Returns when to accept though no wait reports a connection: now, if one may be pending and there is a slot, or
    /// after a pause.
    pub(crate) fn poll_timeout(&self, has_place: bool) -> Deadline {
        match self.socket {
            Some(_) if self.pending && has_place => Deadline::Now,
            Some(_) => self.again.into(),
            None => Deadline::Never,
        }
    }

    /// Closes the socket.
    pub(crate) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
    }
}
