// SPDX-License-Identifier: Apache-2.0
//! TCP through the platform, from this program to itself.

use core::ffi::CStr;
use core::net::Ipv4Addr;

use lf::ZephyrPlatform;
use lf::kconfig::LF_SOCKETS;
use lf::runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, SocketId, Transfer};
use lf_coordination::Deadline;
use lf_model::Interval;

use crate::{Outcome, ensure, platform};

const FAILED: &CStr = c"a call of the platform failed";

/// Turns an error into a failure of the test.
fn well<T>(result: Result<T, NetError>) -> Result<T, &'static CStr> {
    result.map_err(|error| {
        lf::println!("{error}");
        FAILED
    })
}

fn loopback(port: u16) -> Endpoint {
    Endpoint::new(Ipv4Addr::LOCALHOST, port)
}

/// Waits until one socket matches its interest.
fn wait_for(platform: &mut ZephyrPlatform, socket: SocketId, interest: Interest) {
    platform.set_interest(socket, interest);
    let mut is = false;
    while !is {
        platform.wait(Deadline::Never, &mut |id, _| is |= id == socket);
    }
    platform.set_interest(socket, Interest::NONE);
}

fn accept(platform: &mut ZephyrPlatform, listener: SocketId) -> Result<SocketId, &'static CStr> {
    loop {
        wait_for(platform, listener, Interest::READ);
        if let Some((socket, peer)) = well(platform.accept(listener))? {
            ensure!(peer == IpAddress::V4(Ipv4Addr::LOCALHOST));
            return Ok(socket);
        }
    }
}

/// Returns a listener, and both ends of a connection to it.
fn connection(platform: &mut ZephyrPlatform) -> Result<[SocketId; 3], &'static CStr> {
    let listener = well(platform.listen(0))?;
    let port = well(platform.local_port(listener))?;
    ensure!(port != 0);
    let client = well(platform.connect(loopback(port)))?;
    let server = accept(platform, listener)?;
    wait_for(platform, client, Interest::WRITE);
    well(platform.connected(client))?;
    Ok([listener, client, server])
}

/// Reads exactly as many bytes as the buffer has.
fn read_all(platform: &mut ZephyrPlatform, socket: SocketId, mut buffer: &mut [u8]) -> Outcome {
    while !buffer.is_empty() {
        wait_for(platform, socket, Interest::READ);
        match well(platform.read(socket, buffer))? {
            Transfer::Bytes(count) => buffer = &mut buffer[count..],
            Transfer::WouldBlock => {}
            Transfer::Closed => return Err(c"the connection ended early"),
        }
    }
    Ok(())
}

fn write_all(platform: &mut ZephyrPlatform, socket: SocketId, mut bytes: &[u8]) -> Outcome {
    while !bytes.is_empty() {
        wait_for(platform, socket, Interest::WRITE);
        match well(platform.write(socket, bytes))? {
            Transfer::Bytes(count) => bytes = &bytes[count..],
            Transfer::WouldBlock => {}
            Transfer::Closed => return Err(c"the connection ended early"),
        }
    }
    Ok(())
}

pub(crate) fn bytes_go_over_tcp_and_back() -> Outcome {
    let mut platform = platform()?;
    let [_, client, server] = connection(&mut platform)?;
    ensure!(platform.read(server, &mut [0]) == Ok(Transfer::WouldBlock));

    let sent: [u8; 1000] = core::array::from_fn(|index| index.to_le_bytes()[0]);
    let mut back = [0; 1000];
    for _ in 0..10 {
        write_all(&mut platform, client, &sent)?;
        let mut there = [0; 1000];
        read_all(&mut platform, server, &mut there)?;
        write_all(&mut platform, server, &there)?;
        read_all(&mut platform, client, &mut back)?;
        ensure!(back == sent);
    }

    platform.close(client);
    wait_for(&mut platform, server, Interest::READ);
    ensure!(platform.read(server, &mut [0]) == Ok(Transfer::Closed));
    Ok(())
}

/// Without input, the wait ends at its time, and not before, and reports no socket as ready.
pub(crate) fn a_wait_for_a_silent_socket_ends_at_its_time() -> Outcome {
    let mut platform = platform()?;
    let [listener, client, server] = connection(&mut platform)?;
    for socket in [listener, client, server] {
        platform.set_interest(socket, Interest::READ);
    }
    let mut is_silent = true;
    let until = platform.now() + Interval::from_millis(20);
    while platform.now() < until {
        platform.wait(Deadline::At(until), &mut |_, _| is_silent = false);
    }
    ensure!(is_silent);
    // Available input is found without waiting, and ends a wait that could be long.
    write_all(&mut platform, client, &[1])?;
    wait_for(&mut platform, server, Interest::READ);
    let later = platform.now() + Interval::from_nanos(i64::MAX / 2);
    for until in [Deadline::Now, Deadline::At(later), Deadline::Never] {
        let mut came = false;
        platform.set_interest(server, Interest::READ);
        platform.wait(until, &mut |id, is| came |= id == server && is.readable);
        ensure!(came);
    }
    Ok(())
}

/// Fills a connection whose receiver does not read: the sender's write would block, and no call blocks.
pub(crate) fn a_full_connection_would_block() -> Outcome {
    let mut platform = platform()?;
    let [_, client, server] = connection(&mut platform)?;
    let bytes = [7; 500];
    let mut sent = 0_usize;
    loop {
        match well(platform.write(client, &bytes))? {
            Transfer::Bytes(count) => sent += count,
            Transfer::WouldBlock => break,
            Transfer::Closed => return Err(c"the connection ended early"),
        }
    }
    ensure!(sent > 0);
    let mut room = [0; 500];
    let mut received = 0;
    while received < sent {
        wait_for(&mut platform, server, Interest::READ);
        if let Transfer::Bytes(count) = well(platform.read(server, &mut room))? {
            ensure!(room[..count].iter().all(|byte| *byte == 7));
            received += count;
        }
    }
    // There is room again, for one byte at least.
    write_all(&mut platform, client, &[8])
}

pub(crate) fn datagrams_come_with_their_sender() -> Outcome {
    let mut platform = platform()?;
    let one = well(platform.bind(0))?;
    let other = well(platform.bind(0))?;
    let port = well(platform.local_port(one))?;
    let to = loopback(well(platform.local_port(other))?);
    let mut room = [0; 16];
    ensure!(platform.receive_from(other, &mut room) == Ok(None));
    well(platform.send_to(one, to, b"hello"))?;
    wait_for(&mut platform, other, Interest::READ);
    let came = well(platform.receive_from(other, &mut room))?;
    ensure!(came == Some((5, loopback(port))));
    ensure!(&room[..5] == b"hello");
    Ok(())
}

pub(crate) fn a_refused_connection_is_reported() -> Outcome {
    let mut platform = platform()?;
    let listener = well(platform.listen(0))?;
    let port = well(platform.local_port(listener))?;
    platform.close(listener);
    match platform.connect(loopback(port)) {
        Ok(client) => {
            wait_for(&mut platform, client, Interest::WRITE);
            ensure!(platform.connected(client) == Err(NetError::Refused));
        }
        Err(error) => ensure!(error == NetError::Refused),
    }
    Ok(())
}

pub(crate) fn a_port_in_use_is_reported() -> Outcome {
    let mut platform = platform()?;
    let listener = well(platform.listen(0))?;
    let port = well(platform.local_port(listener))?;
    ensure!(platform.listen(port) == Err(NetError::AddressInUse));
    platform.close(listener);
    // Zephyr's own stack frees the port a little later.
    while platform.listen(port) == Err(NetError::AddressInUse) {
        let soon = platform.now() + Interval::from_millis(1);
        platform.wait(Deadline::At(soon), &mut |_, _| {});
    }
    ensure!(platform.listen(port) == Err(NetError::AddressInUse));
    Ok(())
}

pub(crate) fn a_stale_id_is_an_error() -> Outcome {
    let mut platform = platform()?;
    let old = well(platform.listen(0))?;
    platform.close(old);
    let new = well(platform.listen(0))?;
    ensure!(new.index == old.index && new.generation != old.generation);
    // Closing and reading by the stale id must not reach the new socket.
    platform.close(old);
    ensure!(platform.local_port(old) == Err(NetError::Stale));
    ensure!(platform.local_port(new).is_ok());
    Ok(())
}

pub(crate) fn a_full_table_leaves_connections_waiting() -> Outcome {
    let mut platform = platform()?;
    let listener = well(platform.listen(0))?;
    let port = well(platform.local_port(listener))?;
    let mut client = None;
    for _ in 1..LF_SOCKETS {
        client = Some(well(platform.connect(loopback(port)))?);
    }
    ensure!(platform.connect(loopback(port)) == Err(NetError::NoSocketLeft));
    ensure!(platform.listen(0) == Err(NetError::NoSocketLeft));
    wait_for(&mut platform, listener, Interest::READ);
    ensure!(platform.accept(listener) == Err(NetError::NoSocketLeft));

    let Some(client) = client else { return Err(c"the table has one place only") };
    platform.close(client);
    accept(&mut platform, listener)?;
    Ok(())
}
