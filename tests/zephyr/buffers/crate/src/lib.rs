// SPDX-License-Identifier: Apache-2.0
//! Three connections all have many bytes to send, and receivers that at first read nothing: Zephyr runs out of buffers.
//! All bytes arrive nevertheless.
#![no_std]

use core::net::Ipv4Addr;

use lf::ZephyrPlatform;
use lf::runtime::platform::{Endpoint, Interest, NetError, Platform, SocketId, Transfer};
use lf_coordination::Deadline;

const CONNECTIONS: usize = 3;
/// Bytes over each connection; many times more than there are buffers for.
const TOTAL: usize = 40_000;
/// The maximum number of bytes in one write.
const PIECE: usize = 1500;

/// A connection with both ends in this program.
struct Connection {
    client: SocketId,
    server: SocketId,
    sent: usize,
    received: usize,
}

/// Returns the byte at a position of the sent bytes.
fn byte(place: usize) -> u8 {
    u8::try_from(place % 251).unwrap_or_default()
}

/// Waits until the socket is ready for this.
fn await_ready(platform: &mut ZephyrPlatform, socket: SocketId, interest: Interest) {
    platform.set_interest(socket, interest);
    let mut is_ready = false;
    while !is_ready {
        platform.wait(Deadline::Never, &mut |ready, _| is_ready |= ready == socket);
    }
    platform.set_interest(socket, Interest::NONE);
}

impl Connection {
    fn open(platform: &mut ZephyrPlatform, listener: SocketId) -> Result<Self, NetError> {
        let port = platform.local_port(listener)?;
        let client = platform.connect(Endpoint::new(Ipv4Addr::LOCALHOST, port))?;
        await_ready(platform, client, Interest::WRITE);
        platform.connected(client)?;
        await_ready(platform, listener, Interest::READ);
        let (server, _) = platform.accept(listener)?.ok_or(NetError::Refused)?;
        Ok(Self { client, server, sent: 0, received: 0 })
    }

    /// Writes until the system accepts no more.
    fn write(&mut self, platform: &mut ZephyrPlatform) -> Result<(), NetError> {
        while self.sent < TOTAL {
            let mut bytes = [0; PIECE];
            let length = PIECE.min(TOTAL - self.sent);
            for (place, value) in (self.sent..).zip(&mut bytes[..length]) {
                *value = byte(place);
            }
            match platform.write(self.client, &bytes[..length])? {
                Transfer::Bytes(count) => self.sent += count,
                Transfer::WouldBlock => break,
                Transfer::Closed => return Err(NetError::Reset),
            }
        }
        let interest = if self.sent < TOTAL { Interest::WRITE } else { Interest::NONE };
        platform.set_interest(self.client, interest);
        Ok(())
    }

    /// Reads the received bytes, and compares them with the sent ones.
    fn read(&mut self, platform: &mut ZephyrPlatform) -> Result<(), NetError> {
        let mut bytes = [0; PIECE];
        if let Transfer::Bytes(count) = platform.read(self.server, &mut bytes)? {
            let is_expected = (self.received..).zip(&bytes[..count]).all(|(place, value)| *value == byte(place));
            assert!(is_expected, "other bytes have come than were sent");
            self.received += count;
        }
        Ok(())
    }
}

fn run(platform: &mut ZephyrPlatform) -> Result<(), NetError> {
    let listener = platform.listen(4242)?;
    let mut connections = [
        Connection::open(platform, listener)?,
        Connection::open(platform, listener)?,
        Connection::open(platform, listener)?,
    ];
    for connection in &mut connections {
        connection.write(platform)?;
        platform.set_interest(connection.server, Interest::READ);
    }
    while connections.iter().any(|connection| connection.received < TOTAL) {
        let mut ready = [Interest::NONE; 2 * CONNECTIONS];
        platform.wait(Deadline::Never, &mut |socket, is| {
            for (connection, ready) in connections.iter().zip(ready.chunks_mut(2)) {
                for (end, ready) in [connection.client, connection.server].into_iter().zip(ready) {
                    *ready = if end == socket { is } else { *ready };
                }
            }
        });
        for (connection, ready) in connections.iter_mut().zip(ready.chunks(2)) {
            if ready[0].writable {
                connection.write(platform)?;
            }
            if ready[1].readable {
                connection.read(platform)?;
            }
        }
    }
    lf::println!("all has come on {CONNECTIONS} connections");
    Ok(())
}

lf::main!(run, lf::log::LevelFilter::Info);
