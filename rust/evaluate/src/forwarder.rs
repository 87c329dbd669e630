// SPDX-License-Identifier: Apache-2.0
//! The least that any program between two sockets can do: what latencies are compared with.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener};

use crate::Result;

/// Takes two connections and writes all that comes on the first one to the second one, until the first one ends.
/// `listening` is told the port.
///
/// # Errors
/// When the system has no socket, or a connection breaks.
pub fn forward(listening: impl FnOnce(u16)) -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    listening(listener.local_addr()?.port());
    let (mut from, _) = listener.accept()?;
    let (mut to, _) = listener.accept()?;
    to.set_nodelay(true)?;
    let mut buffer = [0; 4096];
    loop {
        match from.read(&mut buffer)? {
            0 => return Ok(()),
            count => to.write_all(&buffer[..count])?,
        }
    }
}
