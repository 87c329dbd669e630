// SPDX-License-Identifier: Apache-2.0
//! The RTI when peers leave, misbehave or do not read, which no recording shows.

use lf_coordination::Deadline;
use lf_coordination::rti::{AfterLoss, CLOCK_TIME_OUT, Cause, Config, Outcome, Status, Verdict};
use lf_model::time::{Instant, Interval};
use lf_testkit::messages::encoded;
use lf_testkit::rti::dialogue::{FEDERATION, START, Upstream, at, chain, config, hello, message, read, started, wait};
use lf_testkit::rti::{Awaited, Rig, Sizes};
use lf_wire::{ADDRESS_PORT_UNKNOWN, DELAY_NONE, Message, NeighborStructure, RejectCode, Tag};

#[test]
fn a_lost_federate_holds_nobody_up() {
    let (mut rig, connections) = chain(config(), Sizes::ample(3));
    rig.message(connections[1], &Message::NextEventTag(at(5)));
    rig.close(connections[0]);
    assert_eq!(read(&mut rig, connections[1]), ["TAG FOREVER"]);
    assert!(rig.outlet.log_events.contains(&"federate 0 is lost: its connection ended without a word".to_owned()));
    for connection in &connections[1..] {
        rig.message(*connection, &Message::Resign);
    }
    let lost = Outcome::Lost { federate: 0.into(), cause: Cause::ConnectionLost };
    assert_eq!(rig.rti.status(), Status::Finished(lost));
}

#[test]
fn a_loss_can_stop_all() {
    let config = Config { after_loss: AfterLoss::StopAll, ..config() };
    let (mut rig, connections) = chain(config, Sizes::ample(3));
    rig.message(connections[0], &Message::Failed);
    // No grant before it, which would let the first one downstream end as if all had come to an end in order.
    assert_eq!(read(&mut rig, connections[1]), ["FAILED"]);
    assert_eq!(read(&mut rig, connections[2]), ["FAILED"]);
    assert!(connections.iter().all(|connection| !rig.outlet.list[connection.0].open));
    let lost = Outcome::Lost { federate: 0.into(), cause: Cause::Failed };
    assert_eq!(rig.rti.status(), Status::Finished(lost));
}

#[test]
fn an_aborted_federation_has_failed_for_all() {
    let (mut rig, connections) = chain(config(), Sizes::ample(2));
    rig.rti.abort(&mut rig.outlet);
    assert_eq!(read(&mut rig, connections[0]), ["FAILED"]);
    assert_eq!(read(&mut rig, connections[1]), ["FAILED"]);
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::Aborted));
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
}

#[test]
fn a_federate_that_is_lost_before_the_start_can_come_again() {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    let first = hello(&mut rig, 0, &[]);
    rig.message(first, &Message::Timestamp(1_000_000));
    rig.close(first);
    let lost = "federate 0 is lost before the start, its place is free again: its connection ended without a word";
    assert!(rig.outlet.log_events.contains(&lost.to_owned()));

    let second = hello(&mut rig, 1, &[]);
    rig.message(second, &Message::Timestamp(0));
    assert_eq!(read(&mut rig, second), [""; 0], "the clock of the lost federate does not count");
    let again = hello(&mut rig, 0, &[]);
    rig.message(again, &Message::Timestamp(7));
    assert_eq!(rig.rti.start_time(), Some(Instant::from_nanos(START + 7)));
    assert_eq!(read(&mut rig, second), ["TIMESTAMP"]);
}

#[test]
fn a_silent_connection_is_given_up_and_its_id_is_free() {
    let mut rig = Rig::new(config(), Sizes::ample(1));
    let silent = rig.connect();
    rig.message(silent, &Message::FedIds { federate: 0, federation_id: FEDERATION });
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + Interval::from_secs(10)));
    wait(&mut rig, Interval::from_secs(10));
    assert!(!rig.outlet.list[silent.0].open);
    rig.take(silent, usize::MAX);
    hello(&mut rig, 0, &[]);
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + CLOCK_TIME_OUT));
}

#[test]
fn a_resigned_federate_that_does_not_close_is_closed() {
    let (mut rig, connections) = chain(config(), Sizes::ample(2));
    rig.message(connections[0], &Message::Resign);
    assert_eq!(read(&mut rig, connections[1]), ["TAG FOREVER"], "the others do not wait for the end");
    assert!(rig.outlet.list[connections[0].0].open);
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + Interval::from_secs(10)));
    wait(&mut rig, Interval::from_secs(10));
    assert!(!rig.outlet.list[connections[0].0].open);
}

#[test]
fn a_federate_that_leaves_while_a_stop_is_pending_has_agreed() {
    for goodbye in [Some(Message::Resign), Some(Message::Failed), None] {
        let (mut rig, connections) = chain(config(), Sizes::ample(2));
        rig.message(connections[0], &Message::StopRequest(at(5)));
        assert_eq!(read(&mut rig, connections[1]), ["STOP_REQUEST"]);
        match goodbye {
            Some(goodbye) => rig.message(connections[1], &goodbye),
            None => rig.close(connections[1]),
        }
        assert_eq!(read(&mut rig, connections[0]), ["STOP_GRANTED"]);
    }
}

#[test]
fn a_federate_that_does_not_answer_a_stop_request_is_expelled_and_the_others_stop() {
    let (mut rig, connections) = chain(config(), Sizes::ample(3));
    rig.message(connections[0], &Message::StopRequest(at(5)));
    rig.message(connections[1], &Message::StopReply(at(7)));
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + Interval::from_secs(30)));
    wait(&mut rig, Interval::from_secs(30));
    assert_eq!(read(&mut rig, connections[2]), ["STOP_REQUEST", "FAILED"]);
    assert_eq!(read(&mut rig, connections[1]), ["STOP_REQUEST", "STOP_GRANTED"]);
    assert_eq!(read(&mut rig, connections[0]), ["STOP_GRANTED"]);
    assert!(rig.outlet.log_events.contains(&"the federation stops at (1000000007, 0)".to_owned()));
}

#[test]
fn a_federate_that_breaks_the_protocol_is_told_and_the_others_go_on() {
    let mut too_long = [0; 21];
    too_long[..9].copy_from_slice(&[5, 0, 0, 1, 0, 255, 255, 255, 255]);
    let mut to_nobody = [0; 21];
    to_nobody[..4].copy_from_slice(&[5, 0, 0, 9]);
    let no_such_federate = "it named federate 9, which this federation does not have: start the RTI with the number of \
                           federates that the program has (`-n`)";
    let length = "it sent a message of 4294967295 bytes, but this RTI forwards at most 100: start it with \
                  `--max-message 4294967295`, or, if it is on a board, build it from the program that the federates \
                  are from";
    let wrong: [(&[u8], &str); 5] = [
        (&[13, 9, 0], no_such_federate),
        (&to_nobody, no_such_federate),
        (&too_long, length),
        (&[2, 0, 0, 0, 0, 0, 0, 0, 0], "TIMESTAMP may not come at this point"),
        (&[255], "ACK may not come at this point"),
    ];
    for (bytes, reason) in wrong {
        let (mut rig, connections) = chain(config(), Sizes::ample(2));
        rig.send(connections[0], bytes);
        assert_eq!(read(&mut rig, connections[0]), ["FAILED"]);
        assert!(!rig.outlet.list[connections[0].0].open);
        assert_eq!(read(&mut rig, connections[1]), ["TAG FOREVER"]);
        let expected = format!("federate 0 is lost: it broke the protocol: {reason}");
        assert_eq!(rig.outlet.log_events.last(), Some(&expected));
    }
}

#[test]
fn neighbors_that_cannot_be_are_refused() {
    let sizes = Sizes { upstream: 1, ..Sizes::ample(3) };
    let no_such_federate = "it named federate 3, which this federation does not have: start the RTI with the number of \
                            federates that the program has (`-n`)";
    let wrong: [(Upstream<'_>, &[u16], &str); 4] = [
        (&[(3, 0)], &[], no_such_federate),
        (&[], &[3], no_such_federate),
        (&[(1, -1)], &[], "its connection from federate 1 has a delay of -1 ns, which cannot be"),
        (&[(1, 0), (2, 0)], &[], "it has more upstream federates than the 1 that this RTI has room for"),
    ];
    for (upstream, downstream, reason) in wrong {
        let mut rig = Rig::new(config(), sizes);
        let connection = rig.connect();
        rig.message(connection, &Message::FedIds { federate: 0, federation_id: FEDERATION });
        rig.message(connection, &Message::NeighborStructure(NeighborStructure::new(upstream, downstream)));
        assert_eq!(read(&mut rig, connection), ["ACK", "REJECT"]);
        let code = RejectCode::UnexpectedMessage;
        let expected = format!("a connection was refused that claims to be federate 0: {code}; {reason}");
        assert_eq!(rig.outlet.log_events.last(), Some(&expected));
    }
}

#[test]
fn a_t3_in_the_name_of_another_is_refused() {
    let mut rig = Rig::new(Config::new(FEDERATION, 100), Sizes::ample(2));
    let connection = rig.connect();
    rig.message(connection, &Message::FedIds { federate: 0, federation_id: FEDERATION });
    rig.message(connection, &Message::NeighborStructure(NeighborStructure::new(&[], &[])));
    rig.message(connection, &Message::UdpPort(0));
    assert_eq!(read(&mut rig, connection), ["ACK", "T1"]);
    rig.message(connection, &Message::T3 { federate: 1 });
    assert_eq!(read(&mut rig, connection), ["REJECT"]);
}

/// Room for two of the longest messages, which are 21 + 100 bytes.
const TIGHT: usize = 242;

#[test]
fn a_sender_waits_while_its_destination_does_not_read() {
    let sizes = Sizes { output: TIGHT, ..Sizes::ample(2) };
    let (mut rig, connections) = chain(config(), sizes);
    let payloads: Vec<_> = (0..10u8).map(|number| vec![number; 100]).collect();
    for (payload, ns) in payloads.iter().zip(1..) {
        let mut bytes = vec![0; 121];
        message(1, ns, payload).encode(&mut bytes).expect("it has 121 bytes");
        rig.outlet.list[connections[0].0].incoming.extend(bytes);
    }
    rig.pump(connections[0]);
    assert_eq!(rig.outlet.list[connections[0].0].blocked, Some(Awaited::Room(connections[1])));
    assert_eq!(rig.outlet.list[connections[0].0].incoming.len(), 8 * 121);
    let mut received = Vec::new();
    while !rig.outlet.list[connections[1].0].outgoing.is_empty() {
        received.extend(read(&mut rig, connections[1]));
    }
    let expected: Vec<_> = payloads.iter().map(|payload| format!("message {payload:?}")).collect();
    assert_eq!(received, expected);
    assert_eq!(rig.outlet.list[connections[0].0].blocked, None);
}

#[test]
fn a_sender_whose_destination_leaves_need_not_wait() {
    let sizes = Sizes { output: TIGHT, ..Sizes::ample(2) };
    for resigns in [true, false] {
        let (mut rig, connections) = chain(config(), sizes);
        for ns in 1..4 {
            rig.message(connections[0], &message(1, ns, &[0; 100]));
        }
        assert_eq!(rig.outlet.list[connections[0].0].blocked, Some(Awaited::Room(connections[1])));
        if resigns {
            rig.message(connections[1], &Message::Resign);
        } else {
            rig.close(connections[1]);
        }
        assert_eq!(rig.outlet.list[connections[0].0].blocked, None);
        let dropped = "a message from federate 0 was dropped, because federate 1 has left".to_owned();
        assert_eq!(rig.outlet.log_events.last(), Some(&dropped));
    }
}

#[test]
fn grants_without_room_are_worked_out_anew_when_there_is_some() {
    let sizes = Sizes { output: TIGHT, ..Sizes::ample(2) };
    let (mut rig, connections) = chain(config(), sizes);
    rig.message(connections[0], &message(1, 100, &[1; 100]));
    rig.message(connections[0], &message(1, 100, &[2; 100]));
    rig.message(connections[1], &Message::NextEventTag(at(1)));
    for ns in 2..50 {
        rig.message(connections[0], &Message::NextEventTag(at(ns)));
    }
    let first = read(&mut rig, connections[1]);
    assert_eq!(first.len(), 2, "the messages are still there");
    assert_eq!(read(&mut rig, connections[1]), ["TAG 48 4294967295"], "one grant stands for 48");
}

#[test]
fn a_reply_without_room_holds_the_question_back() {
    let sizes = Sizes { output: 13, ..Sizes::ample(1) };
    let (mut rig, connections) = chain(config(), sizes);
    for _ in 0..3 {
        let mut bytes = vec![0; 3];
        Message::AddressQuery { federate: 0, is_transient: None }.encode(&mut bytes).expect("it has 3 bytes");
        rig.outlet.list[connections[0].0].incoming.extend(bytes);
    }
    rig.pump(connections[0]);
    assert_eq!(rig.outlet.list[connections[0].0].blocked, Some(Awaited::Room(connections[0])));
    let mut replies = 0;
    while !rig.outlet.list[connections[0].0].outgoing.is_empty() {
        replies += read(&mut rig, connections[0]).len();
    }
    assert_eq!(replies, 3);
}

#[test]
fn nothing_overtakes_the_start_time() {
    let sizes = Sizes { output: 16, ..Sizes::ample(2) };
    let mut rig = Rig::new(config(), sizes);
    let connections = [hello(&mut rig, 0, &[]), hello(&mut rig, 1, &[(0, DELAY_NONE)])];
    rig.message(connections[1], &Message::AddressQuery { federate: 0, is_transient: None });
    for connection in connections {
        rig.message(connection, &Message::Timestamp(0));
    }
    rig.message(connections[0], &Message::NextEventTag(Tag::FOREVER));
    rig.message(connections[0], &Message::Resign);
    assert_eq!(read(&mut rig, connections[1]), ["ADDRESS_QUERY_REPLY"]);
    assert_eq!(read(&mut rig, connections[1]), ["TIMESTAMP"]);
    assert_eq!(read(&mut rig, connections[1]), ["TAG FOREVER"]);
}

#[test]
fn a_federate_may_not_speak_of_tags_before_the_start() {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    let connection = hello(&mut rig, 0, &[]);
    rig.message(connection, &Message::NextEventTag(at(0)));
    assert_eq!(read(&mut rig, connection), ["FAILED"]);
    hello(&mut rig, 0, &[]);
}

/// Returns the messages to each federate in a cycle 0 → 1 → 2 → 0 with 0 ⇄ 2 beside it, in which all are at a tag when
/// `lost` goes. Those in `stock` are programs of others.
fn loss_in_cycle(lost: usize, stock: Option<usize>) -> Vec<Vec<String>> {
    let upstream = [vec![2], vec![0], vec![1, 0]];
    let upstream = upstream.map(|list: Vec<u16>| list.into_iter().map(|from| (from, DELAY_NONE)).collect());
    let (mut rig, connections) = started(config(), Sizes::ample(3), &upstream);
    for (federate, connection) in connections.iter().enumerate() {
        if stock != Some(federate) {
            rig.message(*connection, &Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN });
        }
        rig.message(*connection, &Message::NextEventTag(at(0)));
    }
    for connection in &connections {
        assert_eq!(read(&mut rig, *connection), ["PTAG 0 0"]);
    }
    rig.close(connections[lost]);
    connections.iter().map(|connection| read(&mut rig, *connection)).collect()
}

/// 2 waits at the tag for 1, and 0 for 2: no grant can say that 1 is no more, for the two are still in a cycle.
#[test]
fn a_federate_that_waits_for_a_lost_one_within_a_tag_is_told() {
    assert_eq!(loss_in_cycle(1, None), [vec![], vec![], vec!["UPSTREAM_DISCONNECTED"]]);
    // A stock federate of LF 0.12 does not know the word.
    assert_eq!(loss_in_cycle(1, Some(2)), [[""; 0]; 3]);
}

/// Several are lost while there is no room to say so.
#[test]
fn losses_are_told_when_there_is_room() {
    let upstream = [vec![2, 1], vec![0], vec![0], vec![0]];
    let upstream = upstream.map(|list: Vec<u16>| list.into_iter().map(|from| (from, DELAY_NONE)).collect());
    let (mut rig, connections) = started(config(), Sizes::ample(4), &upstream);
    for connection in &connections {
        rig.message(*connection, &Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN });
        rig.message(*connection, &Message::NextEventTag(at(0)));
        read(&mut rig, *connection);
    }
    let capacity = core::mem::replace(&mut rig.outlet.capacity, 2);
    rig.close(connections[2]);
    rig.close(connections[1]);
    assert_eq!(read(&mut rig, connections[0]), [""; 0]);
    rig.outlet.capacity = capacity;
    let now = rig.now;
    rig.rti.handle_writable(now, connections[0], &mut rig.outlet);
    let heard = read(&mut rig, connections[0]);
    assert_eq!(heard[..2], ["UPSTREAM_DISCONNECTED"; 2]);
    assert!(!heard[2..].contains(&heard[0]), "{heard:?}");
}

/// Two cycles without delay, 0 ⇄ 1 and 2 ⇄ 3, with 1 → 2. A rule that exempts every federate of any cycle grants 2 the
/// start provisionally at once; but 2 does not wait for 1, and what 1 sends at the start would come too late.
#[test]
fn a_provisional_grant_waits_for_another_cycle() {
    let upstream = [vec![1], vec![0], vec![3, 1], vec![2]];
    let upstream = upstream.map(|list: Vec<u16>| list.into_iter().map(|from| (from, DELAY_NONE)).collect());
    let (mut rig, connections) = started(config(), Sizes::ample(4), &upstream);
    for connection in &connections {
        rig.message(*connection, &Message::NextEventTag(at(0)));
    }
    assert_eq!(read(&mut rig, connections[0]), ["PTAG 0 0"]);
    assert_eq!(read(&mut rig, connections[1]), ["PTAG 0 0"]);
    assert_eq!(read(&mut rig, connections[2]), [""; 0]);
    assert_eq!(read(&mut rig, connections[3]), ["PTAG 0 0"], "it depends on 2 only, and waits for what that sends");

    rig.message(connections[1], &message(2, 0, b"x"));
    assert_eq!(read(&mut rig, connections[2]), ["message [120]"], "before any grant that covers its tag");
    for connection in &connections[..2] {
        rig.message(*connection, &Message::LatestTagComplete(at(0)));
        rig.message(*connection, &Message::NextEventTag(at(10)));
    }
    assert_eq!(read(&mut rig, connections[2]), ["PTAG 0 0"]);
}

/// Two cycles without delay, 0 ⇄ 1 and 2 ⇄ 3, with 0 → 2 after 10 ns. 2 waits at a tag and needs nothing of 0 there; 1
/// waits for 0 at an earlier tag.
#[test]
fn a_federate_is_called_to_the_earliest_tag_at_which_others_wait() {
    let none = |from: u16| (from, DELAY_NONE);
    let upstream = [vec![none(1)], vec![none(0)], vec![none(3), (0, 10)], vec![none(2)]];
    let (mut rig, connections) = started(config(), Sizes::ample(4), &upstream);
    for word in [Message::NextEventTag, Message::LatestTagComplete] {
        for connection in &connections {
            rig.message(*connection, &word(at(0)));
        }
    }
    for connection in &connections {
        assert_eq!(read(&mut rig, *connection)[0], "PTAG 0 0");
    }
    for (federate, ns) in [(0, 20), (2, 9), (3, 9), (1, 8)] {
        rig.message(connections[federate], &Message::NextEventTag(at(ns)));
    }
    let heard: Vec<_> = connections.iter().map(|connection| read(&mut rig, *connection).pop()).collect();
    assert_eq!(heard, ["PTAG 8 0", "PTAG 8 0", "PTAG 9 0", "PTAG 9 0"].map(|grant| Some(grant.to_owned())));
}

/// In a cycle nobody would be the first to leave.
#[test]
fn a_cycle_without_events_ends_after_a_while() {
    let (mut rig, connections) = started(config(), Sizes::ample(2), &[vec![(1, 5)], vec![(0, 5)]]);
    for connection in &connections {
        rig.message(*connection, &Message::NextEventTag(Tag::FOREVER));
    }
    wait(&mut rig, Interval::ZERO);
    wait(&mut rig, Interval::from_nanos(999_999_999));
    let may_end = |rig: &mut Rig| {
        let mut heard = connections.iter().map(|connection| read(rig, *connection));
        heard.all(|messages| messages.last().is_some_and(|message| message == "TAG FOREVER"))
    };
    assert!(!may_end(&mut rig));
    wait(&mut rig, Interval::from_nanos(1));
    assert!(may_end(&mut rig));
}

#[test]
fn each_loss_in_a_cycle_is_told_once() {
    let upstream = [vec![1, 2], vec![0], vec![0]];
    let upstream = upstream.map(|list: Vec<u16>| list.into_iter().map(|from| (from, DELAY_NONE)).collect());
    let (mut rig, connections) = started(config(), Sizes::ample(3), &upstream);
    for connection in &connections {
        rig.message(*connection, &Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN });
    }
    for lost in [2, 1] {
        rig.close(connections[lost]);
        let heard = read(&mut rig, connections[0]);
        let told = heard.iter().filter(|message| *message == "UPSTREAM_DISCONNECTED");
        assert_eq!(told.count(), 1, "{lost}: {heard:?}");
    }
}

/// The RTI expects the events of those that are there.
#[test]
fn the_first_event_to_come_is_known() {
    let (mut rig, connections) = chain(config(), Sizes::ample(3));
    for (connection, next) in connections.iter().zip([at(5), at(9), Tag::FOREVER]) {
        rig.message(*connection, &Message::NextEventTag(next));
    }
    let after = |rig: &Rig, ns: i64| match rig.rti.next_event_after(Instant::from_nanos(START + ns)) {
        Deadline::At(time) => Some(time.as_nanos() - START),
        Deadline::Never => None,
        Deadline::Now => panic!("it is not over"),
    };
    assert_eq!([0, 4, 5, 8, 9].map(|ns| after(&rig, ns)), [Some(5), Some(5), Some(9), Some(9), None]);
    rig.message(connections[0], &Message::Resign);
    assert_eq!(after(&rig, 0), Some(9));
    rig.rti.abort(&mut rig.outlet);
    assert_eq!(after(&rig, 0), None);
}

/// Messages for a federate that has left are counted, and the sum is logged if that says more.
#[test]
fn sums_are_of_more_than_one() {
    for times in 0..4 {
        let (mut rig, connections) = chain(config(), Sizes::ample(2));
        rig.message(connections[1], &Message::Resign);
        for ns in 0..times {
            rig.message(connections[0], &message(1, ns, b"x"));
        }
        rig.message(connections[0], &Message::Resign);
        let sums = rig.outlet.log_events.iter().filter(|event| event.starts_with("federate 0 in all:"));
        assert_eq!(sums.count(), usize::from(times > 1), "{times}: {:?}", rig.outlet.log_events);
    }
}

#[test]
fn input_of_a_connection_that_the_rti_has_closed_is_not_for_it() {
    let (mut rig, connections) = chain(config(), Sizes::ample(2));
    let goodbye = encoded(&Message::Failed);
    for bytes in [&goodbye[..], &goodbye, &[]] {
        let verdict = rig.rti.handle_input(rig.now, connections[0], bytes, &mut rig.outlet);
        assert_eq!(verdict, Verdict::Closed, "{bytes:?}");
    }
}
