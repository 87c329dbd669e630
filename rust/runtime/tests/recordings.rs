// SPDX-License-Identifier: Apache-2.0
//! The whole event loop against recordings of C federates with decentralized coordination: the tester's part, as the
//! RTI and as the other federate, is played from the file, and what the federate sends is compared byte for byte.

use std::collections::{BTreeMap, BTreeSet};

use crate::support::federation::{Edge, PORT, Plan, RTI, Ran, edge, run_node};
use crate::support::keys::with_host;
use crate::support::node::Behavior;
use lf_model::time::{Instant, Interval};
use lf_runtime::Coordination;
use lf_runtime::platform::{Endpoint, Platform as _, SocketId, Transfer};
use lf_testkit::golden::{Fill, Frame, Step};
use lf_testkit::messages::encoded;
use lf_testkit::network::{address_of, octets_of};
use lf_testkit::world::{Blocking, Conditions, Threads, Virtual};
use lf_wire::{Message, Tag};

const MS: fn(i64) -> Interval = Interval::from_millis;
/// The federate's number among the participants.
const FEDERATE: usize = 1;
/// Connections between federates have numbers from here on.
const FIRST_PEER: u16 = 1000;

/// All but the federate.
struct Tester {
    me: Blocking,
    rti: SocketId,
    peer: SocketId,
    connections: BTreeMap<u16, SocketId>,
    /// Those that the federate has made to another one.
    direct: BTreeSet<u16>,
    /// Where the federate listens.
    advertised: u16,
    start: Instant,
}

impl Tester {
    fn new(platform: Virtual) -> Self {
        let mut me = Blocking::new(platform);
        let (rti, peer) = (me.platform.listen(PORT).unwrap(), me.platform.listen(0).unwrap());
        Self {
            me,
            rti,
            peer,
            connections: BTreeMap::new(),
            direct: BTreeSet::new(),
            advertised: 0,
            start: Instant::NEVER,
        }
    }

    fn play(&mut self, steps: &[Step]) {
        for (index, step) in steps.iter().enumerate() {
            let at = format!("step {index}: {step:?}");
            match step {
                Step::Connect(connection) => {
                    let listener = if *connection < FIRST_PEER { self.rti } else { self.peer };
                    self.connections.insert(*connection, self.me.accept(listener));
                    if *connection >= FIRST_PEER {
                        self.direct.insert(*connection);
                    }
                }
                Step::P2pConnect(connection) => {
                    let address = Endpoint::new(address_of(FEDERATE), self.advertised);
                    self.connections.insert(*connection, self.me.connect(address));
                }
                Step::Send(frame) => self.send(frame),
                Step::Recv(frame) => self.receive(frame, &at),
                Step::Silence(connections) => {
                    let until = self.me.now() + MS(5);
                    self.me.pass_until(until);
                    for connection in connections {
                        let found = self.me.platform.read(self.connections[connection], &mut [0; 1]);
                        assert_eq!(found, Ok(Transfer::WouldBlock), "{at}");
                    }
                }
                Step::ClosedByPeer(connection) => {
                    let socket = self.connections[connection];
                    if *connection >= FIRST_PEER {
                        // The stock federate closes at its end; ours reads its senders' last messages, which end there
                        // too.
                        self.me.platform.shut_down_writing(socket);
                    }
                    let last = self.me.hear_to_end(socket);
                    // Ours says first that nothing more comes.
                    let end = encoded(&Message::PortAbsent { port: 0, federate: 1, tag: Tag::FOREVER });
                    let ends = if self.direct.contains(connection) { &end[..] } else { &[] };
                    assert_eq!(last, ends, "{at}");
                }
                Step::Close(connection) => self.me.platform.close(self.connections[connection]),
                other => panic!("not of a decentralized federate: {other:?}"),
            }
        }
    }

    fn send(&mut self, frame: &Frame) {
        if let Some(tag) = frame.tag {
            // The recording says that it is sent at its time.
            let until = self.start + Interval::from_nanos(tag.time_ns);
            self.me.pass_until(until);
        }
        let bytes = match &frame.fill {
            None => frame.bytes.exact().unwrap(),
            Some(Fill::PhysicalTime) => frame.bytes.fill_with(self.me.now().as_nanos().to_le_bytes()),
            Some(Fill::Start) => {
                self.start = self.me.now() + MS(300);
                frame.bytes.fill_with(self.start.as_nanos().to_le_bytes())
            }
            Some(Fill::TagTime) => self.expected(frame),
            Some(Fill::P2pPort) => {
                let port = i32::from(self.me.platform.local_port(self.peer).unwrap());
                let mut bytes = frame.bytes.fill_with(port.to_le_bytes());
                // The tester is not on the computer on which it was recorded.
                let address = bytes.len() - 4;
                bytes[address..].copy_from_slice(&octets_of(RTI));
                bytes
            }
            Some(other) => panic!("not of a decentralized federate: {other:?}"),
        };
        self.me.say_bytes(self.connections[&frame.connection], &bytes);
    }

    /// Returns the frame with its tag in place.
    fn expected(&self, frame: &Frame) -> Vec<u8> {
        let time = frame.tag.map_or(0, |tag| self.start.as_nanos() + tag.time_ns);
        frame.bytes.fill_with(time.to_le_bytes())
    }

    /// Receives a frame. The recorded federate is of LF 0.12. In 0.13, and in our federate, one more byte says whether
    /// a federate is transient; that byte is not compared.
    fn receive(&mut self, frame: &Frame, at: &str) {
        const ADVERTISEMENT: u8 = 15;
        const WITH_KIND: [u8; 2] = [13, 16];
        const KIND_AT: usize = 3;
        let socket = self.connections[&frame.connection];
        let mut found = Vec::new();
        let has_kind = |found: &[u8]| found.first().is_some_and(|byte| WITH_KIND.contains(byte));
        while found.len() < frame.bytes.len() + usize::from(has_kind(&found)) {
            let needed = frame.bytes.len() + usize::from(has_kind(&found)) - found.len();
            let bytes = self.me.hear_some(socket, needed);
            assert!(!bytes.is_empty(), "{at}: the federate has closed the connection");
            found.extend(bytes);
        }
        if has_kind(&found) {
            assert_eq!(found.remove(KIND_AT), 0, "{at}: no federate is transient");
        }
        if frame.tag.is_some() || frame.bytes.masked_len() == 0 {
            assert_eq!(found, self.expected(frame), "{at}: found on the left");
        } else {
            assert!(frame.bytes.matches(&found), "{at}: found {found:02x?}");
        }
        if found[0] == ADVERTISEMENT {
            self.advertised = u16::from_le_bytes([found[1], found[2]]);
        }
    }
}

/// Plays a recording of this federate; returns its outcome.
fn replay(name: &str, id: u16, behavior: Behavior, timeout: Interval, seed: u64) -> Ran {
    let recording = lf_testkit::golden::load(name).unwrap();
    let mut nodes = vec![Behavior::default(); 2];
    nodes[usize::from(id)] = behavior;
    let edge = Edge { waits: (MS(50), Interval::ZERO), ..edge(0, 1) };
    let plan = Plan {
        coordination: Coordination::Decentralized,
        timeout: Some(timeout),
        keepalive: true,
        trials: 10,
        federation_id: b"Unidentified Federation",
        ..Plan::new(nodes, vec![edge])
    };
    let world = Threads::new(Conditions::seeded(seed));
    let tester = world.join(Interval::ZERO, Interval::ZERO);
    let mut federate = world.join(Interval::ZERO, MS(1_700));
    std::thread::scope(|scope| {
        scope.spawn(|| Tester::new(tester).play(&recording.steps));
        let ran = scope.spawn(move || {
            federate.begin();
            with_host(&plan, federate, |host| run_node::<2>(&plan, true, id, host))
        });
        world.start();
        ran.join().unwrap()
    })
}

#[test]
fn a_source_connects_to_its_receiver_and_sends_there() {
    for seed in 0..8 {
        let timer = Behavior { timer: Some((Interval::ZERO, MS(100))), ..Behavior::default() };
        assert_eq!(replay("52-decentralized-source", 0, timer, MS(400), seed).result, Ok(()));
    }
}

#[test]
fn a_sink_takes_the_right_sender_only_and_what_it_sends() {
    for seed in 0..8 {
        let ran = replay("52b-decentralized-sink", 1, Behavior::default(), MS(800), seed);
        assert_eq!((ran.result, ran.late_messages), (Ok(()), 0));
        let expected: Vec<_> = (0..4u32).map(|n| (MS(100 * i64::from(n)).as_nanos(), 0, 0, 0x2a + n)).collect();
        assert_eq!(ran.log, expected);
    }
}
