// SPDX-License-Identifier: Apache-2.0
//! A federate's errors about messages and bytes that it cannot take: true sentences, with advice.

use crate::support::federation::{Plan, edge, run_with};
use crate::support::node::Behavior;
use lf_model::time::Interval;
use lf_runtime::platform::SocketId;
use lf_testkit::world::Blocking;
use lf_wire::{Message, MessageType, Tag};

const TRIALS: u16 = 3;

/// An RTI that says what it likes.
struct Liar<'a> {
    me: &'a mut Blocking,
    socket: SocketId,
    start: i64,
}

impl Liar<'_> {
    fn say(&mut self, bytes: &[u8]) {
        self.me.say_bytes(self.socket, bytes);
    }

    fn say_message(&mut self, message: &Message<'_>) {
        self.me.say(self.socket, message);
    }

    fn hear(&mut self, bytes: usize) {
        self.me.hear(self.socket, bytes);
    }

    /// Lets the federate in and start.
    fn start(&mut self) {
        self.say_message(&Message::Ack);
        // FED_IDS of the federation "virtual", NEIGHBOR_STRUCTURE with one upstream federate, UDP_PORT.
        self.hear(4 + 7 + 9 + 10 + 3);
        for _ in 0..TRIALS {
            let now = self.me.now().as_nanos();
            self.say_message(&Message::T1(now));
            self.hear(MessageType::T3.fixed_bytes());
            self.say_message(&Message::T4(now));
        }
        self.hear(MessageType::Timestamp.fixed_bytes());
        self.start = self.me.now().as_nanos() + 1_000_000;
        self.say_message(&Message::Timestamp(self.start));
    }

    fn at(&self, ns: i64) -> Tag {
        Tag::new(self.start + ns, 0)
    }
}

/// Returns why federate 1, which has an input from federate 0, ends when its RTI does this.
fn complaint(lie: impl Fn(&mut Liar<'_>) + Sync) -> String {
    complaint_with(&[], lie)
}

/// Returns the complaint of a federate that leaves out some numbers of ports.
fn complaint_with(own_ports: &'static [u16], lie: impl Fn(&mut Liar<'_>) + Sync) -> String {
    let nodes = vec![Behavior::default(); 2];
    let plan = Plan { trials: TRIALS, keepalive: true, own_ports, ..Plan::new(nodes, vec![edge(0, 1)]) };
    let (ran, ()) = run_with::<2, _>(&plan, 1, Interval::from_millis(1_700), |me, socket| {
        lie(&mut Liar { me, socket, start: 0 });
        me.hear_to_end(socket);
    });
    ran.result.unwrap_err().to_string()
}

#[test]
fn a_message_that_is_too_long_is_named_by_its_connection_with_both_lengths() {
    // It is refused as soon as its header has come.
    let header = |length: u32| {
        let mut bytes = vec![MessageType::TaggedMessage.byte(), 0, 0, 1, 0];
        bytes.extend(length.to_le_bytes());
        bytes.extend([0; 12]);
        bytes
    };
    // Beyond the receive buffer, and within it, but for the header.
    for length in [262_144, 390] {
        let complaint = complaint(|liar| {
            liar.start();
            liar.say(&header(length));
        });
        let expected = format!(
            "a message over node.in has {length} bytes, but its type holds 4 at most: give the ports of this \
             connection a type that holds more, and build all federates from one program"
        );
        assert_eq!(complaint, expected);
    }
    let complaint = complaint(|liar| {
        liar.start();
        liar.say_message(&Message::TaggedMessage { port: 0, federate: 1, tag: liar.at(1), payload: &[0; 300] });
    });
    assert_eq!(
        complaint,
        "a message for node.in does not fit its type: its type takes 4 bytes, but it has 300; build all federates from \
         one program"
    );
}

#[test]
fn a_message_that_is_too_long_for_an_input_that_does_not_exist_says_so() {
    let complaint = complaint(|liar| {
        liar.start();
        liar.say_message(&Message::TaggedMessage { port: 9, federate: 1, tag: liar.at(1), payload: &[0; 5_000] });
    });
    assert!(complaint.starts_with("a message came for input 9, which this federate does not have"), "{complaint}");
}

#[test]
fn a_message_for_a_port_that_is_left_out_is_for_no_input() {
    let complaint = |port: u16, payload: &'static [u8]| {
        complaint_with(&[0], |liar| {
            liar.start();
            liar.say_message(&Message::TaggedMessage { port, federate: 1, tag: liar.at(1), payload });
        })
    };
    let missing = |port| format!("a message came for input {port}, which this federate does not have");
    assert!(complaint(0, &[0; 4]).starts_with(&missing(0)));
    assert!(complaint(0, &[0; 5_000]).starts_with(&missing(0)));
    assert!(complaint(1, &[0; 5_000]).starts_with("a message over node.in has 5000 bytes"));
    assert!(complaint(2, &[0; 4]).starts_with(&missing(2)));
}

#[test]
fn a_message_from_before_the_start_says_how_long_before() {
    let complaint = complaint(|liar| {
        liar.start();
        liar.say_message(&Message::TaggedMessage { port: 0, federate: 1, tag: liar.at(-2_500_000), payload: &[0; 4] });
    });
    assert_eq!(
        complaint,
        "a message over node.in came with a tag that is 2500000 ns = 2 ms before the start of the federation: check \
         that all federates are built from the same program"
    );
}

#[test]
fn a_message_for_the_end_of_time_is_not_dropped_without_a_word() {
    let complaint = complaint(|liar| {
        liar.start();
        liar.say_message(&Message::TaggedMessage { port: 0, federate: 1, tag: Tag::FOREVER, payload: &[0; 4] });
    });
    assert_eq!(
        complaint,
        "a message over input 0 came for the end of time, where nothing can happen: check the delays of the connections"
    );
}

#[test]
fn bytes_that_are_no_message_say_where_they_come_from() {
    let stranger = complaint(|liar| liar.say(b"HTTP/1.1 400 Bad Request"));
    assert_eq!(
        stranger,
        "what listens at the RTI's address sent bytes that are no message: type byte 72 at offset 0 is no message of \
         this protocol; check the address and the port, and that an RTI listens there"
    );
    let rti = complaint(|liar| {
        liar.start();
        liar.say(&[77]);
    });
    assert_eq!(
        rti,
        "the RTI sent bytes that are no message while this federate was running: type byte 77 at offset 0 is no \
         message of this protocol; check that the RTI is one of the same release as this federate"
    );
}
