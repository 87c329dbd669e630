// SPDX-License-Identifier: Apache-2.0
//! TCP through the platform, from this program to itself.

use core::ffi::CStr;
use core::net::{Ipv4Addr, SocketAddrV4};

use lf_coordination::Deadline;
use lf::ZephyrPlatform;
use lf::kconfig::LF_SOCKETS;
use lf::runtime::platform::{Interest, NetError, Platform, SocketId, Transfer};

use crate::{Outcome, ensure, platform};

const FAILED: &CStr = c"a call of the platform failed";

/// Turns an error into a failure of the test.
fn well<T>(result: Result<T, NetError>) -> Result<T, &'static CStr> {
    result.map_err(|error| {
        lf::println!("{error}");
        FAILED
    })
}

fn loopback(port: u16) -> SocketAddrV4 {
    SocketAddrV4::new(Ipv4Addr::LOCALHOST, port)
}

/// Waits until one socket is as asked.
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
            ensure!(peer == Ipv4Addr::LOCALHOST);
            return Ok(socket);
        }
    }
}

/// A listener, and both ends of a connection to it.
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
    well(platform.listen(port))?;
    Ok(())
}

pub(crate) fn a_stale_id_is_an_error() -> Outcome {
    let mut platform = platform()?;
    let old = well(platform.listen(0))?;
    platform.close(old);
    let new = well(platform.listen(0))?;
    ensure!(new.index == old.index && new.generation != old.generation);
    // Closing and asking by the old name must not reach the new socket.
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
