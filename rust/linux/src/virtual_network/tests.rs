// SPDX-License-Identifier: Apache-2.0
//! Calls and answers keep what they contain.

use std::net::Ipv4Addr;
use std::thread;

use lf_model::Outside;
use lf_runtime::platform::Platform;
use proptest::prelude::*;

use super::*;
use crate::outside::HostOutside;

const SOCKET: SocketId = SocketId { index: 3, generation: 500 };
const OTHER: SocketId = SocketId { index: 4, generation: u16::MAX };

/// A network whose answers name what they were asked; calls without an answer are counted.
#[derive(Default)]
struct Echo {
    told: usize,
    interest: Interest,
}

fn from(ip: [u8; 4], port: u16) -> Endpoint {
    Endpoint::new(Ipv4Addr::from(ip), port)
}

impl Platform for Echo {
    fn now(&mut self) -> Instant {
        Instant::from_nanos(1_000)
    }

    fn outside(&self) -> &'static dyn Outside {
        HostOutside::of_program()
    }

    fn set_correction(&mut self, _correction: lf_coordination::clock_sync::ClockCorrection) {}

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        buffer.fill(7);
        Ok(())
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        if address == from([10, 0, 0, 2], 15045) { Ok(SOCKET) } else { Err(NetError::Refused) }
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        if socket == SOCKET { Ok(()) } else { Err(NetError::Os(-5)) }
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        if port == 0 { Ok(OTHER) } else { Err(NetError::AddressInUse) }
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        if port == u16::MAX { Ok(OTHER) } else { Err(NetError::NoSocketLeft) }
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        buffer.fill(1);
        Ok((socket == OTHER).then(|| (buffer.len(), from([10, 0, 0, 9], 1))))
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        assert_eq!((socket, to, bytes), (OTHER, from([10, 0, 0, 9], 1), &[0, 1, 0][..]));
        Ok(())
    }

    fn local_port(&mut self, _listener: SocketId) -> Result<u16, NetError> {
        Ok(u16::MAX)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        Ok((listener == OTHER).then(|| (SOCKET, from([10, 0, 0, 9], 0).ip)))
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        buffer[0] = 9;
        match socket {
            SOCKET => Ok(Transfer::Bytes(1)),
            OTHER => Ok(Transfer::Closed),
            _ => Err(NetError::Reset),
        }
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        if socket == SOCKET { Ok(Transfer::Bytes(bytes.len())) } else { Ok(Transfer::WouldBlock) }
    }

    fn shut_down_writing(&mut self, _socket: SocketId) {
        self.told += 1;
    }

    fn close(&mut self, _socket: SocketId) {
        self.told += 1;
    }

    fn set_interest(&mut self, _socket: SocketId, interest: Interest) {
        self.interest = interest;
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        if until == Deadline::Never {
            ready(SOCKET, self.interest);
            ready(OTHER, Interest::WRITE);
        }
    }

    fn interrupted(&mut self) -> bool {
        self.told == 2
    }
}

#[test]
fn every_call_reaches_the_network_and_its_answer_comes_back() {
    let (client, server) = UnixStream::pair().expect("a pair of sockets");
    let serving = thread::spawn(move || {
        assert_eq!(participant(&server).expect("it begins"), 5);
        serve(&server, &mut Echo::default());
    });
    let (mut network, time) = VirtualNetwork::begin_at(client, 5).expect("it is served");
    assert_eq!(time.as_nanos(), VIRTUAL_START + 1_000);

    assert_eq!(network.connect(from([10, 0, 0, 2], 15045)), Ok(SOCKET));
    assert_eq!(network.connect(from([10, 0, 0, 3], 15045)), Err(NetError::Refused));
    assert_eq!((network.connected(SOCKET), network.connected(OTHER)), (Ok(()), Err(NetError::Os(-5))));
    assert_eq!((network.listen(0), network.listen(1)), (Ok(OTHER), Err(NetError::AddressInUse)));
    assert_eq!((network.bind(u16::MAX), network.bind(1)), (Ok(OTHER), Err(NetError::NoSocketLeft)));
    assert_eq!(network.local_port(OTHER), Ok(u16::MAX));
    let peer = from([10, 0, 0, 9], 0).ip;
    assert_eq!((network.accept(OTHER), network.accept(SOCKET)), (Ok(Some((SOCKET, peer))), Ok(None)));

    let mut buffer = [0; 3];
    assert_eq!(network.receive_from(OTHER, &mut buffer), Ok(Some((3, from([10, 0, 0, 9], 1)))));
    assert_eq!((buffer, network.receive_from(SOCKET, &mut buffer)), ([1; 3], Ok(None)));
    assert_eq!(network.send_to(OTHER, from([10, 0, 0, 9], 1), &[0, 1, 0]), Ok(()));
    assert_eq!((network.read(SOCKET, &mut buffer), buffer[0]), (Ok(Transfer::Bytes(1)), 9));
    assert_eq!(network.read(OTHER, &mut buffer), Ok(Transfer::Closed));
    assert_eq!(network.read(SocketId { index: 0, generation: 0 }, &mut buffer), Err(NetError::Reset));
    assert_eq!(network.write(SOCKET, &[0; 1000]), Ok(Transfer::Bytes(1000)));
    assert_eq!(network.write(OTHER, &[0; 1000]), Ok(Transfer::WouldBlock));
    assert_eq!((network.random(&mut buffer), buffer), (Ok(()), [7; 3]));

    network.set_interest(SOCKET, Interest::READ);
    let mut ready = Vec::new();
    let time = network.wait(Deadline::Never, &mut |socket, interest| ready.push((socket, interest)));
    assert_eq!((time, &ready[..]), (Some(time_of(1_000)), &[(SOCKET, Interest::READ), (OTHER, Interest::WRITE)][..]));
    assert_eq!(network.wait(Deadline::Now, &mut |_, _| panic!("nothing is ready")), Some(time_of(1_000)));
    assert!(!network.interrupted());
    network.shut_down_writing(SOCKET);
    network.close(SOCKET);
    network.wait(Deadline::At(time_of(5)), &mut |_, _| {});
    assert!(network.interrupted());
    drop(network);
    serving.join().expect("it ends");
}

fn time_of(ns: i64) -> Instant {
    Instant::from_nanos(VIRTUAL_START + ns)
}

/// A program whose network is gone has to end, and does not panic.
#[test]
fn without_the_other_program_calls_fail() {
    let (client, server) = UnixStream::pair().expect("a pair of sockets");
    let serving = thread::spawn(move || {
        participant(&server).expect("it begins");
        Frame::done().write(&server).expect("it hears");
    });
    let (mut network, _) = VirtualNetwork::begin_at(client, 0).expect("it is served");
    serving.join().expect("it ends");
    assert_eq!(network.connect(from([10, 0, 0, 2], 1)), Err(NetError::Unreachable));
    assert_eq!(network.wait(Deadline::Never, &mut |_, _| {}), None);
    network.close(SOCKET);
    assert!(network.interrupted());
}

proptest! {
    /// Bytes that are no frame of a participant are refused, and do not end the other program.
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        // The length of such a frame is that of its bytes, so that no large one is awaited.
        let mut bytes = bytes;
        if let Some(length) = bytes.get_mut(13..17) {
            length.copy_from_slice(&[8, 0, 0, 0]);
        }
        if let Ok(frame) = Frame::read(&bytes[..]) {
            let _ = (Call::of(&frame), frame.address(), frame.ready().count());
            let _ = frame.outcome();
        }
    }
}
