// SPDX-License-Identifier: Apache-2.0
//! A receiver distinguishes a sender that has left in order from one that is lost, for any connection, RTI and sender.

use crate::support::federation::{self, Edge, Plan, run, run_with};
use crate::support::node::Behavior;
use lf_coordination::federate::FederateError;
use lf_coordination::rti::{AfterLoss, Outcome};
use lf_model::time::Interval;
use lf_runtime::platform::{Endpoint, Platform as _, SocketId};
use lf_runtime::{Coordination, PeerFault, RunError};
use lf_testkit::messages::encoded;
use lf_testkit::network::address_of;
use lf_testkit::world::{Blocking, Conditions, Fault};
use lf_wire::{ADDRESS_PORT_UNKNOWN, Message, QueryEnd, Tag};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;
/// The RTI's start delay and the time for the handshakes, roughly.
const START: i64 = 1_600;

/// Returns a sender, a relay and a receiver, over connections past the RTI: logical ones, or physical ones.
fn chain(is_physical: bool, waits: (Interval, Interval), capacity: usize) -> Plan {
    let relay = Behavior { relay: true, ..Behavior::default() };
    let source = Behavior { timer: Some((Interval::ZERO, MS(5))), ..Behavior::default() };
    let edge = |from, to| Edge { physical: is_physical, waits, ..federation::edge(from, to) };
    let coordination = if is_physical { Coordination::Centralized } else { Coordination::Decentralized };
    let nodes = vec![source, relay, Behavior::default()];
    Plan { capacity, coordination, ..Plan::new(nodes, vec![edge(0, 1), edge(1, 2)]) }
}

fn waits() -> impl Strategy<Value = (Interval, Interval)> {
    let wait = || prop_oneof![Just(Interval::ZERO), Just(MS(3)), Just(Interval::FOREVER)];
    (wait(), wait())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whichever comes first, the end of a connection or the RTI's message, no federate takes the loss of another for
    /// an end in order.
    #[test]
    fn the_loss_of_a_sender_is_never_an_end_in_order(
        seed: u64,
        who in 0..2usize,
        at in 0..200i64,
        latency_ns_max in 0..20_000_000u64,
        is_physical: bool,
        waits in waits(),
        capacity in 1usize..=2,
    ) {
        let faults = vec![(MS(START + at), 1 + who, Fault::Kill)];
        let plan = Plan { after_loss: AfterLoss::StopAll, faults, ..chain(is_physical, waits, capacity) };
        let report = run(&plan, Conditions { latency_ns_max, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None, "{:?}", report.results);
        for (federate, result) in report.results.iter().enumerate().filter(|(federate, _)| *federate != who) {
            prop_assert_eq!(result, &Err(RunError::Federate(FederateError::RtiFailed)), "{}", federate);
        }
    }

    /// A sender that ends before the others is never taken for a lost one: they go on to their own end.
    #[test]
    fn an_end_in_order_is_never_a_loss(
        seed: u64,
        latency_ns_max in 0..20_000_000u64,
        pipe_bytes in 25usize..200,
        is_physical: bool,
        timeout in prop::option::of(0..300i64),
        waits in waits(),
        capacity in 1usize..=2,
    ) {
        let timeouts = [(0, Some(MS(60)))].into();
        let chain = chain(is_physical, waits, capacity);
        let plan = Plan { timeouts, timeout: timeout.map(MS), after_loss: AfterLoss::StopAll, ..chain };
        let report = run(&plan, Conditions { pipe_bytes, latency_ns_max, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None, "{:?}", report.results);
        prop_assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
        prop_assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
    }

    /// Where the others are to go on after a loss, they do.
    #[test]
    fn after_a_loss_the_others_go_on(seed: u64, at in 0..200i64, is_physical: bool, waits in waits()) {
        let faults = vec![(MS(START + at), 1, Fault::Kill)];
        let plan = Plan { after_loss: AfterLoss::GoOn, faults, ..chain(is_physical, waits, 2) };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None, "{:?}", report.results);
        prop_assert_eq!((&report.results[1], &report.results[2]), (&Ok(()), &Ok(())));
    }
}

/// An RTI and a sender in one, which know only what the stock programs do.
struct Stock<'a> {
    me: &'a mut Blocking,
    rti: SocketId,
    heard: Vec<u8>,
    query_end: QueryEnd,
    start: i64,
}

impl Stock<'_> {
    fn say(&mut self, socket: SocketId, message: &Message<'_>) {
        self.me.say(socket, message);
    }

    /// Waits for the next message of the federate.
    fn hear<T>(&mut self, find: impl Fn(&Message<'_>) -> Option<T>) -> T {
        loop {
            let mut at = usize::from(self.query_end.take(&self.heard).is_some());
            while let Ok(lf_wire::Decoded::Complete { message, len }) = lf_wire::decode(&self.heard[at..], &LIMITS) {
                at += len;
                self.query_end.follow(&message);
                if let Some(found) = find(&message) {
                    self.heard.drain(..at);
                    return found;
                }
            }
            self.heard.drain(..at);
            let more = self.me.hear_some(self.rti, 256);
            assert!(!more.is_empty(), "the federate has left");
            self.heard.extend(more);
        }
    }

    /// Lets federate 1 in, connects to it as federate 0, and starts.
    fn start(&mut self) -> SocketId {
        self.hear(|message| matches!(message, Message::FedIds { .. }).then_some(()));
        self.say(self.rti, &Message::Ack);
        let now = self.me.now().as_nanos();
        self.say(self.rti, &Message::T1(now));
        self.hear(|message| matches!(message, Message::T3 { .. }).then_some(()));
        self.say(self.rti, &Message::T4(now));
        let port = self.hear(|message| match message {
            Message::AddressAdvertisement { port } if *port > 0 => Some(*port),
            _ => None,
        });
        let address = Endpoint::new(address_of(1), u16::try_from(port).unwrap());
        let sender = self.me.connect(address);
        self.say(
            sender,
            &Message::P2pSendingFedId { federate: 0, is_transient: Some(false), federation_id: b"virtual" },
        );
        // A connection that is closed while something lies there unread loses what it has sent.
        assert_eq!(self.me.hear(sender, 1), encoded(&Message::Ack));
        self.hear(|message| matches!(message, Message::Timestamp(_)).then_some(()));
        self.start = self.me.now().as_nanos() + 1_000_000;
        self.say(self.rti, &Message::Timestamp(self.start));
        sender
    }

    /// Answers a question for the address of this federate: nowhere, or somewhere with a port if it has one.
    fn answer(&mut self, asked: u16, port: Option<i32>, address: [u8; 4]) {
        let found = self.hear(|message| match message {
            Message::AddressQuery { federate, .. } => Some(*federate),
            _ => None,
        });
        assert_eq!(found, asked);
        self.say(self.rti, &Message::AddressQueryReply { port: port.unwrap_or(ADDRESS_PORT_UNKNOWN), address });
    }
}

const HERE: [u8; 4] = [10, 0, 0, 2];
const NOWHERE: [u8; 4] = [0; 4];
const LIMITS: lf_wire::Limits =
    lf_wire::Limits { payload_bytes_max: 64, federation_id_bytes_max: 64, neighbors_max: 8 };

/// Returns the outcome of federate 1, which has a connection from federate 0 over which it waits forever, and the
/// number of its messages.
fn end_with(act: impl Fn(&mut Stock<'_>) + Sync) -> (Result<(), RunError>, usize) {
    let edge = Edge { waits: (Interval::FOREVER, Interval::ZERO), ..federation::edge(0, 1) };
    let nodes = vec![Behavior::default(); 2];
    let plan = Plan { coordination: Coordination::Decentralized, trials: 1, ..Plan::new(nodes, vec![edge]) };
    let (ran, ()) = run_with::<2, _>(&plan, 1, Interval::ZERO, |me, rti| {
        act(&mut Stock { me, rti, heard: Vec::new(), query_end: QueryEnd::NONE, start: 0 });
        me.hear_to_end(rti);
        me.platform.close(rti);
    });
    (ran.result, ran.log.len())
}

/// One value, and then the end of the connection, at once or in the middle of another message.
fn send_and_close(stock: &mut Stock<'_>, sender: SocketId, in_message: bool) {
    let (tag, payload) = (Tag::new(stock.start, 0), [1, 0, 0, 0]);
    let message = Message::P2pTaggedMessage { port: 0, federate: 1, tag, payload: &payload };
    stock.say(sender, &message);
    if in_message {
        stock.me.say_bytes(sender, &encoded(&message)[..9]);
    }
    stock.me.platform.close(sender);
}

#[test]
fn a_sender_that_just_closes_has_left_once_our_rti_knows_no_computer_of_it() {
    for in_message in [false, true] {
        let end = end_with(|stock| {
            let sender = stock.start();
            send_and_close(stock, sender, in_message);
            stock.answer(1, Some(49_152), HERE);
            // The RTI has not noticed yet.
            stock.answer(0, None, HERE);
            stock.answer(0, None, NOWHERE);
        });
        assert_eq!(end, (Ok(()), 1));
    }
}

#[test]
fn a_sender_that_just_closes_is_lost_if_our_rti_says_so() {
    let end = end_with(|stock| {
        let sender = stock.start();
        send_and_close(stock, sender, false);
        stock.answer(1, Some(49_152), HERE);
        stock.answer(0, None, HERE);
        let rti = stock.rti;
        stock.say(rti, &Message::Failed);
    });
    assert_eq!(end.0, Err(RunError::Federate(FederateError::RtiFailed)));
}

/// It reports no loss, so that no federate waits for its message.
#[test]
fn a_sender_that_just_closes_has_left_for_a_stock_rti() {
    let end = end_with(|stock| {
        let sender = stock.start();
        send_and_close(stock, sender, false);
        stock.answer(1, None, HERE);
    });
    assert_eq!(end, (Ok(()), 1));
}

/// The word that stock federates understand, too: nothing comes any more at this input.
#[test]
fn a_sender_that_says_that_nothing_more_comes_has_left() {
    let end = end_with(|stock| {
        let sender = stock.start();
        stock.say(sender, &Message::PortAbsent { port: 0, federate: 1, tag: Tag::FOREVER });
        stock.me.platform.close(sender);
    });
    assert_eq!(end, (Ok(()), 0));
}

#[test]
fn a_sender_that_sends_a_value_for_the_end_of_time_is_named() {
    let (result, _) = end_with(|stock| {
        let sender = stock.start();
        stock.say(sender, &Message::P2pTaggedMessage { port: 0, federate: 1, tag: Tag::FOREVER, payload: &[0; 4] });
    });
    assert_eq!(result, Err(RunError::Peer { federate: 0, fault: PeerFault::WrongTag { port: 0 } }));
}
