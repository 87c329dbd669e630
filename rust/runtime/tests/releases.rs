// SPDX-License-Identifier: Apache-2.0
//! A federate finds the form in which a receiver of either release of LF takes its introduction.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use lf_coordination::Deadline;
use lf_model::time::Interval;
use lf_runtime::Coordination;
use lf_runtime::platform::{Interest, IpAddress, Platform as _, SocketId, Transfer};
use lf_testkit::messages::encoded;
use lf_testkit::network::address_of;
use lf_wire::{Message, MessageType, RejectCode};
use support::federation::{PORT, Plan, edge, run_node};
use support::network::Conditions;
use support::node::Behavior;
use support::world::{VirtualPlatform, World};

const ID: &[u8] = b"virtual";
/// Where the receiver listens.
const PEER_PORT: u16 = 4711;

/// The RTI, and the receiver of a federate's messages.
struct Tester(VirtualPlatform);

impl Tester {
    fn accept(&mut self, listener: SocketId) -> SocketId {
        loop {
            if let Some((socket, _)) = self.0.accept(listener).unwrap() {
                self.0.set_interest(listener, Interest::NONE);
                return socket;
            }
            self.wait(listener);
        }
    }

    fn wait(&mut self, socket: SocketId) {
        self.0.set_interest(socket, Interest::READ);
        self.0.wait(Deadline::Never, &mut |_, _| {});
    }

    fn hear(&mut self, socket: SocketId, bytes: usize) -> Vec<u8> {
        let (mut heard, mut left) = (Vec::new(), vec![0; bytes]);
        while !left.is_empty() {
            match self.0.read(socket, &mut left).unwrap() {
                Transfer::Bytes(count) => heard.extend(left.drain(..count)),
                Transfer::WouldBlock => self.wait(socket),
                Transfer::Closed => panic!("the federate has left"),
            }
        }
        heard
    }

    fn say(&mut self, socket: SocketId, message: &Message<'_>) {
        let bytes = encoded(message);
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            match self.0.write(socket, rest).unwrap() {
                Transfer::Bytes(count) => rest = &rest[count..],
                other => panic!("the network has room for it: {other:?}"),
            }
        }
    }

    /// Takes introductions as a receiver does whose header has this many bytes, the last of which is the length of the
    /// federation id. Returns the number of introductions until one was right.
    fn receive(&mut self, rti: SocketId, header_bytes: usize) -> usize {
        let listener = self.0.listen(PEER_PORT).unwrap();
        for attempt in 1.. {
            assert_eq!(self.hear(rti, 4), [MessageType::AddressQuery.byte(), 1, 0, 0]);
            let IpAddress::V4(address) = address_of(0) else { panic!("its addresses are those of IPv4") };
            self.say(rti, &Message::AddressQueryReply { port: PEER_PORT.into(), address: address.octets() });
            let peer = self.accept(listener);
            let header = self.hear(peer, header_bytes);
            let length = usize::from(header[header_bytes - 1]);
            if self.hear(peer, length) == ID {
                self.say(peer, &Message::Ack);
                return attempt;
            }
            self.say(peer, &Message::Reject(RejectCode::FederationIdMismatch));
            self.0.close(peer);
        }
        unreachable!("it tries again until it is over")
    }
}

/// Returns the number of introductions to such a receiver before a federate tells the RTI that it is ready.
fn attempts(header_bytes: usize) -> usize {
    let nodes = vec![Behavior::default(); 2];
    let coordination = Coordination::Decentralized;
    let plan = Plan { coordination, trials: 1, keepalive: true, ..Plan::new(nodes, vec![edge(0, 1)]) };
    let world = World::new(Conditions::seeded(1));
    let mut platform = world.join(Interval::ZERO, Interval::ZERO);
    let mut federate = world.join(Interval::from_millis(1), Interval::ZERO);
    std::thread::scope(|scope| {
        let attempts = scope.spawn(move || {
            platform.begin();
            let listener = platform.listen(PORT).unwrap();
            let mut tester = Tester(platform);
            let rti = tester.accept(listener);
            tester.say(rti, &Message::Ack);
            // FED_IDS, NEIGHBOR_STRUCTURE without neighbors, UDP_PORT.
            tester.hear(rti, 4 + ID.len() + 9 + 3);
            let now = tester.0.now().as_nanos();
            tester.say(rti, &Message::T1(now));
            tester.hear(rti, MessageType::T3.fixed_bytes());
            tester.say(rti, &Message::T4(now));
            let attempts = tester.receive(rti, header_bytes);
            assert_eq!(tester.hear(rti, MessageType::Timestamp.fixed_bytes())[0], MessageType::Timestamp.byte());
            tester.0.close(rti);
            attempts
        });
        scope.spawn(move || {
            federate.begin();
            run_node::<2>(&plan, 0, &mut federate)
        });
        world.start();
        attempts.join().unwrap()
    })
}

#[test]
fn a_receiver_of_lf_0_13_takes_the_first_introduction_and_one_of_lf_0_12_the_second() {
    assert_eq!([5, 4].map(attempts), [1, 2]);
}
