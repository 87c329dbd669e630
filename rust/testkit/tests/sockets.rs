// SPDX-License-Identifier: Apache-2.0
//! The network behaves as TCP and UDP do.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use lf_runtime::platform::{Endpoint, Interest, NetError, SocketId, Transfer};
use lf_testkit::network::{Medium, Network, address_of};
use lf_testkit::random::Random;

const PORT: u16 = 7;
const LATENCY: u64 = 10;
/// Bytes that one direction of a connection holds.
const ROOM: usize = 4;
const BOTH: Interest = Interest { readable: true, writable: true };

/// A medium in which everything takes the same time, and each datagram arrives this often.
struct Wire(usize);

impl Medium for Wire {
    fn latency_ns(&mut self, _owner: usize, _bytes: usize) -> u64 {
        LATENCY
    }

    fn pipe_bytes(&self, _owner: usize) -> usize {
        ROOM
    }

    fn piece(&mut self, most: usize) -> usize {
        most
    }

    fn random(&mut self) -> &mut Random {
        unreachable!("nobody asks for random numbers")
    }

    fn copies(&mut self) -> usize {
        self.0
    }
}

/// Returns a network with a server (0) that listens, and a client (1).
fn network() -> (Network<Wire>, SocketId) {
    let mut network = Network::new(Wire(1));
    assert_eq!((network.join(), network.join()), (0, 1));
    let listener = network.listen(0, PORT).unwrap();
    (network, listener)
}

fn connect(network: &mut Network<Wire>, to: usize) -> SocketId {
    let socket = network.connect(1, Endpoint::new(address_of(to), PORT), 0).unwrap();
    network.set_interest(1, socket, BOTH);
    socket
}

/// Returns a connection that is open on both sides at the time 20: the server's socket and the client's.
fn connection() -> (Network<Wire>, SocketId, SocketId) {
    let (mut network, listener) = network();
    let client = connect(&mut network, 0);
    let (server, from) = network.accept(0, listener, LATENCY).unwrap().unwrap();
    assert_eq!(from, address_of(1));
    network.connected(1, client, 2 * LATENCY).unwrap();
    network.set_interest(0, server, Interest::READ);
    (network, server, client)
}

fn ready(network: &Network<Wire>, owner: usize, now: u64) -> Vec<Interest> {
    let mut ready = Vec::new();
    network.ready(owner, now, |_, interest| ready.push(interest));
    ready
}

#[test]
fn a_connection_is_known_where_it_leads_first_and_then_where_it_began() {
    let (mut network, listener) = network();
    network.set_interest(0, listener, Interest::READ);
    let client = connect(&mut network, 0);
    assert_eq!((network.next_ready(0), network.next_ready(1)), (Some(10), Some(20)));
    assert_eq!(network.accept(0, listener, 9), Ok(None));
    assert!(matches!(network.accept(0, listener, 10), Ok(Some(_))));
    assert_eq!(network.connected(1, client, 19), Err(NetError::Stale));
    assert_eq!(ready(&network, 1, 20), [Interest::WRITE]);
    assert_eq!(network.connected(1, client, 20), Ok(()));
}

#[test]
fn a_connection_is_refused_where_nobody_listens_and_not_answered_where_nobody_is() {
    let (mut network, listener) = network();
    network.close(0, listener, 0);
    let refused = connect(&mut network, 0);
    assert_eq!(network.connected(1, refused, 20), Err(NetError::Refused));
    network.close(1, refused, 20);
    network.switch_off(0, 20);
    let refused = connect(&mut network, 0);
    assert_eq!(network.connected(1, refused, 20), Err(NetError::Refused));
    network.close(1, refused, 20);
    connect(&mut network, 2);
    assert_eq!(network.next_ready(1), None);
}

#[test]
fn bytes_come_in_order_and_wait_for_room() {
    let (mut network, server, client) = connection();
    assert_eq!(network.write(1, client, b"abcdef", 20), Ok(Transfer::Bytes(4)));
    assert_eq!(network.write(1, client, b"ef", 20), Ok(Transfer::WouldBlock));
    assert_eq!((network.next_ready(0), network.next_ready(1)), (Some(30), None));
    let mut bytes = [0; 3];
    assert_eq!(network.read(0, server, &mut bytes, 29), Ok(Transfer::WouldBlock));
    assert_eq!(network.read(0, server, &mut bytes, 30), Ok(Transfer::Bytes(3)));
    assert_eq!(&bytes, b"abc");
    assert_eq!(network.write(1, client, b"ef", 31), Ok(Transfer::Bytes(2)));
    assert_eq!(network.read(0, server, &mut bytes, 31), Ok(Transfer::Bytes(1)));
    assert_eq!(network.read(0, server, &mut bytes, 41), Ok(Transfer::Bytes(2)));
    assert_eq!(&bytes, b"efc");
}

#[test]
fn an_end_comes_after_all_that_was_written_and_leaves_the_other_direction_open() {
    let (mut network, server, client) = connection();
    network.write(1, client, b"ab", 20).unwrap();
    network.shut_down_writing(1, client, 20);
    assert_eq!(network.write(1, client, b"c", 21), Err(NetError::Reset));
    let mut bytes = [0; 3];
    assert_eq!(network.read(0, server, &mut bytes, 30), Ok(Transfer::Bytes(2)));
    assert_eq!(network.read(0, server, &mut bytes, 30), Ok(Transfer::Closed));
    assert_eq!(network.write(0, server, b"c", 30), Ok(Transfer::Bytes(1)));
    assert_eq!(network.read(1, client, &mut bytes, 40), Ok(Transfer::Bytes(1)));
}

#[test]
fn a_socket_that_is_closed_with_unread_input_breaks_the_connection() {
    let (mut network, server, client) = connection();
    network.write(1, client, b"ab", 20).unwrap();
    network.close(0, server, 25);
    assert_eq!(network.read(0, server, &mut [0], 25), Err(NetError::Stale));
    assert_eq!(network.read(1, client, &mut [0], 34), Ok(Transfer::WouldBlock));
    assert_eq!(ready(&network, 1, 35), [BOTH]);
    assert_eq!(network.read(1, client, &mut [0], 35), Err(NetError::Reset));
    assert_eq!(network.write(1, client, b"c", 35), Err(NetError::Reset));
}

#[test]
fn a_socket_that_is_closed_without_unread_input_ends_the_connection_and_breaks_it_when_more_comes() {
    let (mut network, server, client) = connection();
    network.close(0, server, 20);
    assert_eq!(network.read(1, client, &mut [0], 30), Ok(Transfer::Closed));
    assert_eq!(network.write(1, client, b"ab", 30), Ok(Transfer::Bytes(2)));
    assert_eq!(network.read(1, client, &mut [0], 40), Err(NetError::Reset));
}

#[test]
fn all_connections_of_a_participant_end_or_break_with_it() {
    let (mut network, server, client) = connection();
    network.switch_off(1, 20);
    assert_eq!(network.read(0, server, &mut [0], 30), Ok(Transfer::Closed));
    assert_eq!(network.listen(1, PORT), Err(NetError::Unreachable));
    assert_eq!(network.read(1, client, &mut [0], 30), Err(NetError::Stale));
    let (mut network, server, client) = connection();
    network.break_all(1, 20);
    assert_eq!(network.read(0, server, &mut [0], 20), Err(NetError::Reset));
    assert_eq!(network.read(1, client, &mut [0], 20), Err(NetError::Reset));
}

#[test]
fn a_place_is_used_again_under_another_id_and_a_port_of_its_own_choice_is_nobody_elses() {
    let (mut network, listener) = network();
    let chosen = network.listen(0, 0).unwrap();
    let another = network.listen(0, 0).unwrap();
    assert_ne!(network.local_port(0, chosen), network.local_port(0, another));
    network.close(0, listener, 0);
    let again = network.listen(0, PORT).unwrap();
    assert_eq!((again.index, listener.index), (0, 0));
    assert_eq!(network.local_port(0, listener), Err(NetError::Stale));
    network.close(0, listener, 0);
    assert_eq!(network.local_port(0, again), Ok(PORT));
}

#[test]
fn a_datagram_comes_as_often_as_the_medium_says_and_only_where_somebody_listens() {
    let (mut network, _) = network();
    let (from, to) = (network.bind(1, 0).unwrap(), network.bind(0, PORT).unwrap());
    let sender = Endpoint::new(address_of(1), network.local_port(1, from).unwrap());
    let receiver = Endpoint::new(address_of(0), PORT);
    network.set_interest(0, to, Interest::READ);
    for (copies, bytes) in [(0, b"ab"), (1, b"cd"), (2, b"ef")] {
        *network.medium_mut() = Wire(copies);
        network.send_to(1, from, receiver, bytes, copies as u64).unwrap();
    }
    assert_eq!(network.next_ready(0), Some(11));
    let mut buffer = [0];
    let mut all = Vec::new();
    while let Some(one) = network.receive_from(0, to, &mut buffer, 12).unwrap() {
        assert_eq!(one, (1, sender), "what does not fit is lost");
        all.extend(buffer);
    }
    assert_eq!(all, b"cee");
    assert_eq!(network.send_to(1, from, Endpoint::new(address_of(0), PORT + 1), b"ab", 12), Ok(()));
    let nobody = Endpoint::new(address_of(2), PORT);
    assert_eq!(network.send_to(1, from, nobody, b"ab", 12), Err(NetError::Unreachable));
}
