// SPDX-License-Identifier: Apache-2.0
//! Connections whose bytes are encrypted between this table and the system.

use std::fmt;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;

use lf_runtime::platform::{NetError, Participant, Transfer};
use rustix::net::{RecvFlags, SendFlags};

/// A way to encrypt the connections of a program.
pub(crate) trait Encryption: fmt::Debug {
    /// Returns the end that connects of a new connection.
    fn connecting(&self) -> Option<Box<dyn Secured>>;
    /// Returns the end that accepts of a new connection.
    fn accepting(&self) -> Option<Box<dyn Secured>>;
}

/// The stage of an encrypted connection.
#[cfg_attr(not(feature = "tls"), allow(dead_code, reason = "only TLS has such connections"))]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum SecuredStage {
    /// The ends do not know each other yet.
    Handshake,
    /// Bytes go both ways.
    Open,
    /// The connection is of no use.
    Failed,
}

/// One end of an encrypted connection.
pub(crate) trait Secured: fmt::Debug {
    /// Returns the stage.
    fn stage(&self) -> SecuredStage;
    /// Returns whether the handshake waits for room to write.
    fn wants_write(&self) -> bool;
    /// Returns whether a read has something to return, though the system has nothing.
    fn has_more(&mut self) -> bool;
    /// Lets the handshake fail if another participant than this one is at the other end.
    fn require(&mut self, participant: Participant);
    /// Returns whether this participant may be at the other end: the one that has proved it, where that is demanded.
    fn may_be(&self, participant: Participant) -> bool;
    /// Goes on with the handshake.
    ///
    /// # Errors
    /// The reason why the ends do not come together, once.
    fn handshake(&mut self, wire: &mut Wire<'_>) -> Result<(), String>;
    /// Reads what has come.
    ///
    /// # Errors
    /// The reason why the connection is of no use, once; then the system's error.
    fn read(&mut self, wire: &mut Wire<'_>, buffer: &mut [u8]) -> Result<Result<Transfer, NetError>, String>;
    /// Writes as many bytes as the system takes. Until then, calls have to begin with the same bytes.
    ///
    /// # Errors
    /// The reason why the connection is of no use, once; then the system's error.
    fn write(&mut self, wire: &mut Wire<'_>, bytes: &[u8]) -> Result<Result<Transfer, NetError>, String>;
    /// Tells the other end that nothing more comes.
    fn close(&mut self, wire: &mut Wire<'_>);
}

/// The system's side of a connection.
#[derive(Debug)]
pub(crate) struct Wire<'s>(pub(super) &'s OwnedFd);

impl Read for Wire<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        Ok(rustix::net::recv(self.0, buffer, RecvFlags::empty()).map(|(_, count)| count)?)
    }
}

impl Write for Wire<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(rustix::net::send(self.0, bytes, SendFlags::NOSIGNAL)?)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
