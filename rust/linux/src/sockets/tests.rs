// SPDX-License-Identifier: Apache-2.0
//! The socket table over real sockets of this computer.

use std::os::unix::net::UnixStream;

use super::*;

fn table() -> (Sockets, UnixStream, UnixStream) {
    let (reader, writer) = UnixStream::pair().expect("a pair of sockets");
    (Sockets::new(&reader).expect("an epoll"), reader, writer)
}

/// Waits until this socket has the requested readiness.
fn await_ready(sockets: &mut Sockets, id: SocketId, interest: Interest) -> Interest {
    sockets.set_interest(id, interest);
    let mut found = None;
    while found.is_none() {
        sockets.wait(None, &mut |socket, interest| found = (socket == id).then_some(interest).or(found));
    }
    sockets.set_interest(id, Interest::NONE);
    found.expect("the loop ends with it")
}

/// Returns a listener, and both ends of a connection to it.
fn connection(sockets: &mut Sockets) -> (SocketId, SocketId, SocketId) {
    let listener = sockets.listen(0).expect("a listener");
    let port = sockets.local_port(listener).expect("its port");
    let client = sockets.connect(Endpoint::new(Ipv4Addr::LOCALHOST, port)).expect("an attempt");
    await_ready(sockets, client, Interest::WRITE);
    sockets.connected(client).expect("a connection");
    await_ready(sockets, listener, Interest::READ);
    let (server, peer) = sockets.accept(listener).expect("no error").expect("a connection");
    assert_eq!(peer, IpAddress::V4(Ipv4Addr::LOCALHOST));
    assert_eq!(sockets.accept(listener).map(|accepted| accepted.is_some()), Ok(false));
    (listener, client, server)
}

/// Checks that every call with this id is an error or has no effect.
fn assert_stale(sockets: &mut Sockets, id: SocketId) {
    assert_eq!(sockets.write(id, b"x"), Err(NetError::Stale));
    assert_eq!(sockets.read(id, &mut [0; 4]), Err(NetError::Stale));
    assert_eq!(sockets.connected(id), Err(NetError::Stale));
    assert_eq!(sockets.local_port(id), Err(NetError::Stale));
    sockets.set_interest(id, Interest::READ);
    sockets.shut_down_writing(id);
    sockets.close(id);
}

/// An id outlives its socket, and is an error then, also when its slot has been given to another one.
#[test]
fn a_stale_id_names_no_other_socket() {
    let (mut sockets, _reader, _writer) = table();
    let (listener, client, server) = connection(&mut sockets);
    sockets.close(client);
    assert_stale(&mut sockets, client);
    let port = sockets.local_port(listener).expect("the listener is still there");
    let next = sockets.connect(Endpoint::new(Ipv4Addr::LOCALHOST, port)).expect("an attempt");
    assert_eq!(next.index, client.index, "its place is used again");
    assert_stale(&mut sockets, client);
    await_ready(&mut sockets, next, Interest::WRITE);
    sockets.connected(next).expect("it is not closed by the old id");
    assert_eq!(await_ready(&mut sockets, server, Interest::READ), Interest::READ);
    assert_eq!(sockets.read(server, &mut [0; 4]), Ok(Transfer::Closed));
}

/// Bytes go through in order, writing stops when the peer does not read, and the end comes after the last byte.
#[test]
fn bytes_then_the_end() {
    let (mut sockets, _reader, _writer) = table();
    let (_listener, client, server) = connection(&mut sockets);
    assert_eq!(sockets.read(server, &mut [0; 4]), Ok(Transfer::WouldBlock));
    let mut sent = 0_usize;
    let chunk: Vec<u8> = (0..=u8::MAX).collect();
    while let Ok(Transfer::Bytes(count)) = sockets.write(client, &chunk[sent % 256..]) {
        sent += count;
    }
    sockets.shut_down_writing(client);
    let mut received = 0_usize;
    let mut buffer = [0; 4096];
    loop {
        await_ready(&mut sockets, server, Interest::READ);
        match sockets.read(server, &mut buffer).expect("no error") {
            Transfer::Bytes(count) => {
                assert!(buffer[..count].iter().zip(received..).all(|(byte, place)| usize::from(*byte) == place % 256));
                received += count;
            }
            Transfer::WouldBlock => {}
            Transfer::Closed => break,
        }
    }
    assert_eq!(received, sent);
}

/// An attempt without a listener has an outcome, and it is an error.
#[test]
fn a_port_without_a_listener_refuses() {
    let (mut sockets, _reader, _writer) = table();
    let listener = sockets.listen(0).expect("a listener");
    let port = sockets.local_port(listener).expect("its port");
    assert_eq!(sockets.listen(port), Err(NetError::AddressInUse));
    sockets.close(listener);
    let client = sockets.connect(Endpoint::new(Ipv4Addr::LOCALHOST, port)).expect("an attempt");
    await_ready(&mut sockets, client, Interest::WRITE);
    assert_eq!(sockets.connected(client), Err(NetError::Refused));
}

/// Both sides detect a peer that has gone without a word, such as a board that has halted.
#[test]
fn connections_are_asked_whether_they_are_alive() {
    let (mut sockets, _reader, _writer) = table();
    let (_listener, client, server) = connection(&mut sockets);
    for socket in [client, server] {
        let descriptor = sockets.descriptor(socket).expect("it is open");
        assert_eq!(sockopt::socket_keepalive(descriptor), Ok(true));
        let (idle, interval) = (sockopt::tcp_keepidle(descriptor), sockopt::tcp_keepintvl(descriptor));
        assert_eq!(
            (idle, interval, sockopt::tcp_keepcnt(descriptor)),
            (Ok(KEEPALIVE.0), Ok(KEEPALIVE.1), Ok(KEEPALIVE.2))
        );
    }
}

/// A broken connection is reported to every waiter with an interest, and to no other.
#[test]
fn a_broken_connection_is_ready_for_all() {
    let (mut sockets, _reader, mut writer) = table();
    let (_listener, client, server) = connection(&mut sockets);
    assert_eq!(sockets.write(client, b"unread"), Ok(Transfer::Bytes(6)));
    await_ready(&mut sockets, server, Interest::READ);
    // Unread bytes break the connection when a socket is closed.
    sockets.close(server);
    assert_eq!(await_ready(&mut sockets, client, Interest::READ), Interest { readable: true, writable: true });
    sockets.set_interest(client, Interest::NONE);
    std::io::Write::write_all(&mut writer, &[1]).expect("room");
    assert!(sockets.wait(None, &mut |_, _| panic!("nobody asked")).woken, "only the wake-up");
    assert_eq!(sockets.read(client, &mut [0; 4]), Err(NetError::Reset));
}

/// A datagram comes with its sender's address, and is cut if it is too long for the buffer.
#[test]
fn datagrams_come_one_by_one_from_whoever_sent_them() {
    let (mut sockets, ..) = table();
    let (one, other) = (sockets.bind(0).expect("a port"), sockets.bind(0).expect("another"));
    let address = |port| Endpoint::new(Ipv4Addr::LOCALHOST, port);
    let ports = [one, other].map(|socket| sockets.local_port(socket).expect("its number"));
    assert_eq!(sockets.bind(ports[0]), Err(NetError::AddressInUse));
    let mut buffer = [0; 4];
    assert_eq!(sockets.receive_from(one, &mut buffer), Ok(None));
    for bytes in [&b"a"[..], b"second"] {
        sockets.send_to(other, address(ports[0]), bytes).expect("it goes to this computer");
    }
    for expected in [&b"a"[..], b"seco"] {
        await_ready(&mut sockets, one, Interest::READ);
        let (count, from) = sockets.receive_from(one, &mut buffer).expect("no error").expect("a datagram");
        assert_eq!((&buffer[..count], from), (expected, address(ports[1])));
    }
    // A missing receiver is not the sender's concern.
    sockets.close(other);
    assert_eq!(sockets.send_to(one, address(ports[1]), b"lost"), Ok(()));
    assert_eq!(sockets.send_to(other, address(ports[0]), b"stale"), Err(NetError::Stale));
}
