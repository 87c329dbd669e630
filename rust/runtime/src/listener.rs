// SPDX-License-Identifier: Apache-2.0
//! Where connections come from.

use lf_coordination::{Deadline, IpAddress, Tally};
use lf_model::time::{Instant, Interval};

use crate::log_event::{ConnectionEvent, report};
use crate::platform::{Interest, Platform, SocketId};
use log::Level;

/// How long no connection is accepted after the system has had no resources for one.
const ACCEPT_PAUSE: Interval = Interval::from_millis(100);

/// A socket that listens, as long as there is one, and what is known of those who wait there.
#[derive(Debug, Default)]
pub(crate) struct Listener {
    socket: Option<SocketId>,
    /// A connection may be waiting.
    pending: bool,
    /// A wait has said so since the last one was taken.
    ready: bool,
    /// When to accept again after the system had no resources.
    again: Option<Instant>,
    /// How often it had none.
    failures: Tally,
}

impl Listener {
    /// Somebody may wait there already.
    pub(crate) fn new(socket: SocketId) -> Self {
        Self { socket: Some(socket), pending: true, ..Self::default() }
    }

    /// Whether a connection may be waiting, and may be accepted now.
    pub(crate) fn has_pending(&mut self, now: Instant) -> bool {
        if self.again.is_some_and(|time| time <= now) {
            self.mark_pending();
        }
        self.pending && self.again.is_none() && self.socket.is_some()
    }

    /// Whether a connection may be waiting: then no wait has to tell.
    pub(crate) fn is_known(&self) -> bool {
        self.pending
    }

    /// A connection may be waiting, though no wait has told.
    pub(crate) fn mark_pending(&mut self) {
        (self.again, self.pending) = (None, true);
    }

    /// There is no place for one more. Gives whether one waits for sure: a wait has told since the last was taken.
    pub(crate) fn postpone(&mut self) -> bool {
        self.pending = core::mem::take(&mut self.ready);
        self.pending
    }

    /// Takes a connection, if one waits.
    pub(crate) fn accept<P: Platform>(&mut self, platform: &mut P, now: Instant) -> Option<(SocketId, IpAddress)> {
        self.ready = false;
        match platform.accept(self.socket?) {
            Ok(Some(connection)) => return Some(connection),
            Ok(None) => {}
            Err(error) => {
                // The connection still waits, so the listener stays ready: asking it at once would be without end.
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

    /// Says whether to wait for connections.
    pub(crate) fn set_interest<P: Platform>(&self, platform: &mut P, wanted: bool) {
        if let Some(socket) = self.socket {
            let wanted = wanted && self.again.is_none();
            platform.set_interest(socket, if wanted { Interest::READ } else { Interest::NONE });
        }
    }

    /// A wait found this socket ready. `true` if it is this one.
    pub(crate) fn handle_ready(&mut self, ready: SocketId) -> bool {
        let is_it = self.socket == Some(ready);
        (self.pending, self.ready) = (self.pending | is_it, self.ready | is_it);
        is_it
    }

    /// When to accept though no wait tells: now, if somebody may wait and there is a place, or after a pause.
    pub(crate) fn poll_timeout(&self, has_place: bool) -> Deadline {
        match self.socket {
            Some(_) if self.pending && has_place => Deadline::Now,
            Some(_) => self.again.into(),
            None => Deadline::Never,
        }
    }

    /// Listens no longer.
    pub(crate) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
    }
}
