// SPDX-License-Identifier: Apache-2.0
//! The baseline of latencies: the minimum that any program between two sockets can take.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener};

use crate::Result;

/// The way in which a forwarder waits. The load of the processors decides which one is faster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// Sleeps until bytes arrive: one call to read, one to write.
    Asleep,
    /// Polls without sleeping, which occupies a processor: no thread has to be woken.
    Awake,
}

/// Accepts two connections and writes all that arrives on the first one to the second one, until the first one ends.
/// Calls `listening` with the port.
///
/// # Errors
/// When the system has no socket, or a connection breaks.
pub fn forward(waiting: Waiting, listening: impl FnOnce(u16)) -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    listening(listener.local_addr()?.port());
    let (mut from, _) = listener.accept()?;
    let (mut to, _) = listener.accept()?;
    to.set_nodelay(true)?;
    from.set_nonblocking(waiting == Waiting::Awake)?;
    let mut buffer = [0; 4096];
    loop {
        match from.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => to.write_all(&buffer[..count])?,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(error.into()),
        }
    }
}
