// SPDX-License-Identifier: Apache-2.0
//! The least that any program between two sockets can do: what latencies are compared with.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener};

use crate::Result;

/// How a forwarder waits. Which one is quicker depends on what else the processors do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// It sleeps until something comes: one call to read, one to write.
    Asleep,
    /// It looks all the time, which takes a processor of its own: nobody has to wake it.
    Awake,
}

/// Takes two connections and writes all that comes on the first one to the second one, until the first one ends.
/// `listening` is told the port.
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
