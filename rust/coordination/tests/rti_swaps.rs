// SPDX-License-Identifier: Apache-2.0
//! Federates that come, go and are swapped, where no recording shows it.

use lf_coordination::rti::{Config, ConnectionId, Outcome, Rti, SetupError, Status};
use lf_coordination::{Deadline, FederateId};
use lf_model::time::{Instant, Interval};
use lf_testkit::rti::dialogue::{FEDERATION, START, at, config, hello, message, offered, read, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{
    DELAY_NONE, Decoded, HANDED_OVER_PORT, KIND_TRANSIENT, Limits, Message, NeighborStructure, Tag,
    UDP_PORT_CLOCK_SYNC_OFF, decode, decode_to_transient,
};

/// A time of the RTI's clock after all tags of these dialogues.
const LATE: Instant = Instant::from_nanos(1_000_000 * START);

fn rig(federates: usize, transients: u16, now: Instant) -> Rig {
    let mut rig = Rig::new(Config { transients, ..config() }, Sizes::ample(federates));
    rig.now = now;
    rig
}

/// Takes the messages to a transient federate, as text.
fn heard(rig: &mut Rig, connection: ConnectionId) -> Vec<String> {
    let bytes = rig.take(connection, usize::MAX);
    let (mut rest, mut messages) = (&bytes[..], Vec::new());
    while let Ok(Decoded::Complete { message, len }) = decode_to_transient(rest, &Limits::NONE, |_| true) {
        messages.push(match message {
            Message::EffectiveStart { start: START, tag } => format!("start {} {}", tag.time - START, tag.microstep),
            Message::TagGrant(tag) => format!("TAG {}", tag.time - START),
            Message::Reject(code) => format!("REJECT {}", code.byte()),
            other => other.name().to_owned(),
        });
        rest = &rest[len..];
    }
    assert!(rest.is_empty());
    messages
}

/// Connects an instance of a transient federate, up to the last message of its handshake.
fn introduce(rig: &mut Rig, federate: u16, upstream: &[(u16, i64)]) -> ConnectionId {
    let connection = rig.connect();
    let ids = Message::TransientFedIds { federate, kind: KIND_TRANSIENT, federation_id: FEDERATION };
    rig.message(connection, &ids);
    if rig.outlet.list[connection.0].open {
        rig.message(connection, &Message::NeighborStructure(NeighborStructure::new(upstream, &[])));
    }
    if rig.outlet.list[connection.0].open {
        rig.message(connection, &Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF));
    }
    connection
}

/// Starts 0 → 1 (transient) → 2 with all but 1, which joins at the start.
fn chain() -> (Rig, [ConnectionId; 3]) {
    let mut rig = rig(3, 1, LATE);
    let (first, last) = (hello(&mut rig, 0, &[]), hello(&mut rig, 2, &[(1, DELAY_NONE)]));
    for connection in [first, last] {
        rig.message(connection, &Message::Timestamp(0));
    }
    assert_eq!([first, last].map(|connection| read(&mut rig, connection)), [["TIMESTAMP"]; 2]);
    let middle = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(middle, &Message::Timestamp(START));
    assert_eq!(heard(&mut rig, middle), ["ACK", "start 0 0"]);
    assert_eq!(read(&mut rig, last), ["UPSTREAM_CONNECTED"]);
    (rig, [first, middle, last])
}

/// Starts the same; then 1 leaves, and another instance of it connects.
fn with_successor() -> (Rig, [ConnectionId; 3]) {
    let (mut rig, [first, old, last]) = chain();
    rig.message(old, &Message::Resign);
    rig.close(old);
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    (rig, [first, new, last])
}

#[test]
fn an_instance_that_does_not_make_way_is_expelled() {
    let (mut rig, [first, old, _]) = chain();
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert_eq!((heard(&mut rig, new), heard(&mut rig, old)), (vec!["ACK".into()], vec!["STOP".into()]));
    // Its clock waits, and messages go to the instance that runs.
    rig.message(new, &Message::Timestamp(START + 9));
    rig.message(first, &message(1, 5, b"x"));
    assert_eq!((heard(&mut rig, new), heard(&mut rig, old)), (vec![], vec!["TAGGED_MESSAGE".into()]));
    // A third one is in the way of both.
    let third = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert_eq!(heard(&mut rig, third), ["REJECT 2"]);
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + Interval::from_secs(30)));
    wait(&mut rig, Interval::from_secs(30));
    assert_eq!(heard(&mut rig, old), ["FAILED"]);
    rig.pump(new);
    assert_eq!(heard(&mut rig, new), ["start 9 0"], "after the message that the other one has not completed");
    for connection in [first, new] {
        rig.message(connection, &Message::Resign);
    }
    assert_eq!(rig.rti.status(), Status::Running);
}

/// A federate may come that has no memory for a larger window, so all return to the configured one until it has offered
/// one, too; one that has left does not count.
#[test]
fn an_instance_that_comes_has_offered_no_window() {
    let (mut rig, [first, old, last]) = chain();
    assert_eq!(
        (offered(&mut rig, first, 0, 20), offered(&mut rig, old, 1, 18), offered(&mut rig, last, 2, 30)),
        (16, 16, 18)
    );
    rig.message(old, &Message::Resign);
    rig.close(old);
    read(&mut rig, last);
    assert_eq!(offered(&mut rig, first, 0, 21), 21);
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert_eq!(offered(&mut rig, first, 0, 21), 21);
    rig.message(new, &Message::Timestamp(START + 9));
    heard(&mut rig, new);
    assert_eq!(
        (offered(&mut rig, first, 0, 21), offered(&mut rig, new, 1, 17), offered(&mut rig, first, 0, 21)),
        (16, 17, 17)
    );
}

/// Returns a state that a federate hands over.
fn state(of: u16, value: &'static [u8]) -> Message<'static> {
    Message::TaggedMessage { port: HANDED_OVER_PORT, federate: of, tag: at(5), payload: value }
}

/// A state goes to the one that waits, before it begins; to nobody where nobody waits, and only from the federate
/// itself.
#[test]
fn a_state_is_passed_to_the_instance_that_waits() {
    let (mut rig, [first, old, _]) = chain();
    rig.message(old, &state(1, b"for nobody"));
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(new, &Message::Timestamp(START + 9));
    assert_eq!((heard(&mut rig, new), heard(&mut rig, old)), (vec!["ACK".into()], vec!["STOP".into()]));
    for value in [&b"one"[..], b"two"] {
        rig.message(old, &state(1, value));
    }
    assert_eq!(read(&mut rig, new), ["message [111, 110, 101]", "message [116, 119, 111]"]);
    rig.message(old, &Message::Resign);
    rig.close(old);
    rig.pump(new);
    assert_eq!(heard(&mut rig, new), ["start 9 0"]);
    assert_eq!(heard(&mut rig, old), Vec::<String>::new());
    // From another federate it is a message like any other.
    let other = Message::TaggedMessage { port: HANDED_OVER_PORT, federate: 1, tag: at(20), payload: b"x" };
    rig.message(first, &other);
    assert_eq!(heard(&mut rig, new), ["TAGGED_MESSAGE"]);
    assert_eq!(rig.rti.status(), Status::Running);
}

/// A state waits for room like any message, and nothing of it is lost.
#[test]
fn a_state_waits_for_room_at_the_instance_that_waits() {
    let (mut rig, [_, old, _]) = chain();
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert_eq!((heard(&mut rig, new), heard(&mut rig, old)), (vec!["ACK".into()], vec!["STOP".into()]));
    rig.outlet.capacity = 200;
    for _ in 0..3 {
        rig.message(old, &state(1, &[7; 100]));
    }
    rig.message(old, &Message::Resign);
    let mut messages = Vec::new();
    while messages.len() < 3 {
        let more = heard(&mut rig, new);
        assert!(!more.is_empty(), "it waits without end after {messages:?}");
        messages.extend(more);
        rig.pump(old);
    }
    assert_eq!(messages, ["TAGGED_MESSAGE"; 3]);
}

#[test]
fn a_successor_that_vanishes_leaves_the_place_to_the_next_one() {
    let (mut rig, [_, old, last]) = chain();
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.close(new);
    rig.message(old, &Message::Resign);
    assert_eq!(heard(&mut rig, old), ["STOP"]);
    assert_eq!(read(&mut rig, last), ["UPSTREAM_DISCONNECTED"]);
    rig.close(old);
    let next = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(next, &Message::Timestamp(START + 3));
    assert_eq!(heard(&mut rig, next), ["ACK", "start 3 0"]);
}

/// One that vanishes may have sent messages at a tag that it has not completed.
#[test]
fn one_that_has_vanished_does_not_repeat_a_tag() {
    let (mut rig, [_, old, last]) = chain();
    rig.message(old, &message(2, 7, b"x"));
    rig.close(old);
    assert_eq!(read(&mut rig, last), ["message [120]", "UPSTREAM_DISCONNECTED"]);
    let next = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(next, &Message::Timestamp(START + 3));
    assert_eq!(heard(&mut rig, next), ["ACK", "start 7 1"]);
}

/// Nothing comes to a tag that one has had which has left.
#[test]
fn one_joins_after_the_tags_of_those_that_have_left() {
    let (mut rig, [_, old, last]) = chain();
    rig.message(old, &Message::Resign);
    rig.close(old);
    rig.message(last, &Message::NextEventTag(at(9)));
    rig.message(last, &Message::Resign);
    assert_eq!(read(&mut rig, last), ["UPSTREAM_DISCONNECTED", "TAG 9 0"]);
    let next = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(next, &Message::Timestamp(START + 3));
    assert_eq!(heard(&mut rig, next), ["ACK", "start 9 1"]);
}

#[test]
fn one_that_sends_directly_to_one_that_has_left_is_refused() {
    let (mut rig, [_, next, last]) = with_successor();
    let question = Message::AddressQuery { federate: 2, is_transient: Some(false) };
    rig.message(next, &question);
    assert_eq!(heard(&mut rig, next), ["ACK", "ADDRESS_QUERY_REPLY"]);
    rig.message(last, &Message::Resign);
    rig.message(next, &question);
    assert_eq!(heard(&mut rig, next), ["REJECT 8"]);
}

#[test]
fn who_takes_part_can_be_told_to_leave() {
    let (mut rig, [_, middle, last]) = chain();
    let dismiss = |rig: &mut Rig, federate| rig.rti.dismiss(FederateId(federate), &mut rig.outlet);
    assert!([0, 2, 3].iter().all(|other| !dismiss(&mut rig, *other)), "they are persistent, or nobody");
    assert!(dismiss(&mut rig, 1));
    assert_eq!(heard(&mut rig, middle), ["STOP"]);
    rig.message(middle, &Message::Resign);
    assert_eq!(read(&mut rig, last), ["UPSTREAM_DISCONNECTED"]);
    assert!(!dismiss(&mut rig, 1), "it has left");
    // Its next incarnation is not concerned.
    rig.close(middle);
    let next = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert!(!dismiss(&mut rig, 1), "it is not there yet");
    rig.message(next, &Message::Timestamp(START + 3));
    assert_eq!(heard(&mut rig, next), ["ACK", "start 3 0"]);
}

#[test]
fn a_second_instance_before_the_start_is_refused() {
    let mut rig = rig(2, 1, LATE);
    let one = introduce(&mut rig, 0, &[]);
    let other = introduce(&mut rig, 0, &[]);
    assert_eq!((heard(&mut rig, one), heard(&mut rig, other)), (vec!["ACK".into()], vec!["REJECT 2".into()]));
}

/// Neither the start nor the end of the federation waits for one that is not ready.
#[test]
fn who_is_silent_holds_nobody_up() {
    let mut rig = rig(2, 1, LATE);
    let silent = introduce(&mut rig, 0, &[]);
    let stays = hello(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(stays, &Message::Timestamp(0));
    rig.message(stays, &Message::NextEventTag(at(7)));
    assert_eq!(read(&mut rig, stays), ["TIMESTAMP", "TAG 7 0"]);
    wait(&mut rig, Interval::from_secs(90));
    assert_eq!(heard(&mut rig, silent), ["ACK", "FAILED"]);
    rig.message(stays, &Message::Resign);
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::Complete));
}

#[test]
fn a_federate_that_is_not_ready_cannot_act() {
    let (mut rig, [_, new, last]) = with_successor();
    rig.message(new, &Message::NextEventTag(at(1)));
    assert_eq!(heard(&mut rig, new), ["ACK", "FAILED"]);
    // It has not taken part, so nobody is told.
    assert_eq!(read(&mut rig, last), ["UPSTREAM_DISCONNECTED"]);
}

#[test]
fn each_incarnation_has_the_same_connections() {
    let (mut rig, [_, old, _]) = chain();
    for others in [&[(2, DELAY_NONE)][..], &[], &[(0, DELAY_NONE), (2, DELAY_NONE)], &[(0, 0)]] {
        let other = introduce(&mut rig, 1, others);
        assert_eq!(heard(&mut rig, other), ["ACK", "REJECT 4"], "{others:?}");
        assert!(rig.outlet.log_events.last().is_some_and(|event| event.contains("its connections are not those")));
    }
    let twice = introduce(&mut rig, 1, &[(0, DELAY_NONE), (0, 5)]);
    assert_eq!(heard(&mut rig, twice), ["ACK"], "the shorter of parallel connections counts");
    assert_eq!(heard(&mut rig, old), ["STOP"]);
}

/// 0 (transient, absent) → 1 → 2: what comes from 0 can reach 2, so 2 must not be far ahead either.
#[test]
fn grants_behind_an_absent_federate_wait_for_the_clock() {
    let now = Instant::from_nanos(START + 10);
    let mut rig = rig(3, 1, now);
    let [one, two] = [hello(&mut rig, 1, &[(0, DELAY_NONE)]), hello(&mut rig, 2, &[(1, DELAY_NONE)])];
    for connection in [one, two] {
        rig.message(connection, &Message::Timestamp(0));
    }
    rig.message(one, &Message::NextEventTag(at(5_000)));
    rig.message(two, &Message::NextEventTag(at(1_000)));
    assert_eq!([one, two].map(|connection| read(&mut rig, connection).len()), [1, 1], "the start time only");
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(Instant::from_nanos(START + 1_000)));
    // Who comes now can take part from now on, and 2 goes on up to there.
    let joined = introduce(&mut rig, 0, &[]);
    rig.message(joined, &Message::Timestamp(START + 2_000));
    assert_eq!(heard(&mut rig, joined), ["ACK", "start 2000 0"]);
    assert_eq!(read(&mut rig, two), ["TAG 1999 4294967295"]);
    assert_eq!(read(&mut rig, one), ["UPSTREAM_CONNECTED"]);
    rig.message(joined, &Message::Resign);
    assert_eq!(read(&mut rig, one), ["UPSTREAM_DISCONNECTED"]);
    wait(&mut rig, Interval::from_nanos(4_990));
    assert_eq!(read(&mut rig, one), ["TAG 5000 0"]);
}

/// A federate that was granted a tag while the cycle was open passes by the tags before it, and sends no absence there:
/// those that wait for it at such a tag learn that from their grant.
#[test]
fn a_cycle_that_closes_does_not_wait_for_who_was_granted_more() {
    let mut rig = rig(3, 1, LATE);
    let (first, second) = (hello(&mut rig, 0, &[(1, DELAY_NONE)]), hello(&mut rig, 1, &[(2, DELAY_NONE)]));
    for connection in [first, second] {
        rig.message(connection, &Message::Timestamp(0));
    }
    rig.message(second, &Message::NextEventTag(at(20)));
    assert_eq!(read(&mut rig, second), ["TIMESTAMP", "TAG 20 0"]);
    let third = introduce(&mut rig, 2, &[(0, DELAY_NONE)]);
    rig.message(third, &Message::Timestamp(START + 30));
    assert_eq!(heard(&mut rig, third), ["ACK", "start 30 0"]);
    rig.message(first, &Message::NextEventTag(at(10)));
    assert_eq!(read(&mut rig, first), ["TIMESTAMP", "PTAG 10 0", "TAG 10 0"]);
}

/// A transient federate closes a cycle without delay. A federate upstream of that was told that its next events do not
/// matter, and is told that they do now.
#[test]
fn who_is_upstream_of_a_cycle_that_closes_is_to_announce_its_events() {
    let mut rig = rig(3, 1, LATE);
    let (first, second) = (hello(&mut rig, 0, &[]), hello(&mut rig, 1, &[(0, 1), (2, DELAY_NONE)]));
    for connection in [first, second] {
        rig.message(connection, &Message::Timestamp(0));
    }
    rig.message(first, &Message::NextEventTag(at(0)));
    rig.message(second, &Message::NextEventTag(Tag::FOREVER));
    assert_eq!(read(&mut rig, first), ["TIMESTAMP", "DNET FOREVER"]);
    let third = introduce(&mut rig, 2, &[(1, DELAY_NONE)]);
    rig.message(third, &Message::Timestamp(START + 30));
    rig.message(third, &Message::NextEventTag(at(30)));
    assert_eq!(read(&mut rig, first), ["DNET NEVER"]);
}

#[test]
fn who_joins_while_a_stop_is_asked_for_is_asked_too() {
    let (mut rig, [first, old, last]) = chain();
    rig.message(old, &Message::Resign);
    rig.close(old);
    read(&mut rig, last);
    rig.message(first, &Message::StopRequest(at(50)));
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    rig.message(new, &Message::Timestamp(START + 60));
    assert_eq!(heard(&mut rig, new), ["ACK", "start 60 0", "STOP_REQUEST"]);
    rig.message(last, &Message::StopReply(at(50)));
    assert_eq!(rig.rti.stop_tag(), None);
    rig.message(new, &Message::StopReply(Tag::new(START + 60, 1)));
    assert_eq!(read(&mut rig, last), ["STOP_REQUEST", "UPSTREAM_CONNECTED", "STOP_GRANTED"]);
}

/// Those who do not read are told of each departure before the return.
#[test]
fn who_has_left_and_returned_has_left() {
    let (mut rig, [_, old, last]) = chain();
    // The message leaves no room for a notification.
    rig.outlet.capacity = 22;
    rig.message(old, &message(2, 1, b""));
    rig.message(old, &Message::Resign);
    rig.close(old);
    let new = introduce(&mut rig, 1, &[(0, DELAY_NONE)]);
    assert_eq!(heard(&mut rig, new), ["ACK"]);
    rig.message(new, &Message::Timestamp(START + 9));
    assert_eq!(heard(&mut rig, new), ["start 9 0"]);
    let mut all = Vec::new();
    while !rig.outlet.list[last.0].outgoing.is_empty() {
        all.extend(read(&mut rig, last));
    }
    let notifications: Vec<_> = all.iter().filter(|message| message.starts_with("UPSTREAM")).collect();
    assert_eq!(notifications, ["UPSTREAM_DISCONNECTED", "UPSTREAM_CONNECTED"]);
}

#[test]
fn a_federation_of_transients_alone_is_refused() {
    let mut memory = Sizes::ample(2).memory();
    let rti = Rti::new(Config { transients: 2, ..config() }, memory.storage());
    assert_eq!(rti.err(), Some(SetupError::Transients { transients: 2, federates: 2 }));
}

#[test]
fn a_clock_is_told_once() {
    let (mut rig, [first, middle, last]) = chain();
    rig.message(first, &Message::StopRequest(at(9)));
    for connection in [middle, last] {
        rig.message(connection, &Message::StopReply(at(9)));
    }
    assert_eq!(heard(&mut rig, middle), ["STOP_REQUEST", "STOP_GRANTED"]);
    rig.message(middle, &Message::Timestamp(START + 1));
    assert_eq!(heard(&mut rig, middle), ["FAILED"]);
}

#[test]
fn a_persistent_federate_that_has_left_is_not_replaced_by_a_transient_one() {
    let (mut rig, [first, ..]) = chain();
    rig.message(first, &Message::Resign);
    let instead = introduce(&mut rig, 0, &[]);
    assert_eq!(heard(&mut rig, instead), ["REJECT 2"]);
}

/// 0 ⇄ 1 → 2 (transient) → 3. Without events the cycle ends, but not before all are there; and 3 may have inputs again.
#[test]
fn a_federation_is_not_idle_while_somebody_may_join() {
    let mut rig = rig(4, 1, LATE);
    let cycle = [hello(&mut rig, 0, &[(1, 5)]), hello(&mut rig, 1, &[(0, 5)])];
    let last = hello(&mut rig, 3, &[(2, DELAY_NONE)]);
    let persistent = [cycle[0], cycle[1], last];
    for connection in persistent {
        rig.message(connection, &Message::Timestamp(0));
    }
    for connection in persistent {
        rig.message(connection, &Message::NextEventTag(Tag::FOREVER));
    }
    let idle = |rig: &mut Rig| {
        wait(rig, Interval::ZERO);
        wait(rig, Interval::from_secs(1));
        persistent.map(|connection| read(rig, connection).contains(&"TAG FOREVER".to_owned()))
    };
    assert_eq!(idle(&mut rig), [false; 3]);
    let joined = introduce(&mut rig, 2, &[(1, DELAY_NONE)]);
    rig.message(joined, &Message::Timestamp(START + 7));
    rig.message(joined, &Message::NextEventTag(Tag::FOREVER));
    assert_eq!(idle(&mut rig), [true, true, false]);
}

/// 0 (transient, absent) → 1 ⇄ 2.
#[test]
fn provisional_grants_behind_an_absent_federate_wait_for_the_clock() {
    let mut rig = rig(3, 1, Instant::from_nanos(START + 10));
    let one = hello(&mut rig, 1, &[(0, DELAY_NONE), (2, DELAY_NONE)]);
    let two = hello(&mut rig, 2, &[(1, DELAY_NONE)]);
    for connection in [one, two] {
        rig.message(connection, &Message::Timestamp(0));
    }
    for connection in [one, two] {
        rig.message(connection, &Message::NextEventTag(at(1_000)));
    }
    assert_eq!([one, two].map(|connection| read(&mut rig, connection)), [["TIMESTAMP", "PTAG 0 0"]; 2]);
    for connection in [one, two] {
        rig.message(connection, &Message::LatestTagComplete(at(0)));
    }
    assert_eq!([one, two].map(|connection| read(&mut rig, connection)), [[""; 0]; 2]);
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(Instant::from_nanos(START + 1_000)));
    wait(&mut rig, Interval::from_nanos(990));
    assert_eq!([one, two].map(|connection| read(&mut rig, connection)), [["PTAG 1000 0"]; 2]);
}

/// 0 (transient, absent) → 1 ← 2: the event of 1 is all that it is granted, and just that.
#[test]
fn what_others_have_completed_waits_for_the_clock_too() {
    let mut rig = rig(3, 1, Instant::from_nanos(START + 10));
    let [one, two] = [hello(&mut rig, 1, &[(0, DELAY_NONE), (2, DELAY_NONE)]), hello(&mut rig, 2, &[])];
    for connection in [one, two] {
        rig.message(connection, &Message::Timestamp(0));
    }
    for connection in [two, one] {
        rig.message(connection, &Message::NextEventTag(at(1_000)));
    }
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never, "2 may still send something");
    rig.message(two, &Message::LatestTagComplete(at(1_000)));
    assert_eq!(read(&mut rig, one), ["TIMESTAMP"]);
    wait(&mut rig, Interval::from_nanos(990));
    assert_eq!(read(&mut rig, one), ["TAG 1000 0"]);
}

/// Returns the notifications that a persistent federate reads, each with its federate.
fn notifications(rig: &mut Rig, connection: ConnectionId) -> Vec<(&'static str, u16)> {
    let mut all = Vec::new();
    while !rig.outlet.list[connection.0].outgoing.is_empty() {
        let bytes = rig.take(connection, usize::MAX);
        let mut rest = &bytes[..];
        while let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) {
            all.extend(match message {
                Message::UpstreamConnected { federate } => Some(("upstream came", federate)),
                Message::UpstreamDisconnected { federate } => Some(("upstream left", federate)),
                Message::OutboundConnected { federate } => Some(("outbound came", federate)),
                Message::OutboundDisconnected { federate } => Some(("outbound left", federate)),
                _ => None,
            });
            rest = &rest[len..];
        }
    }
    all
}

/// Connects a transient federate without upstream federates, which begins.
fn come(rig: &mut Rig, federate: u16) -> ConnectionId {
    let connection = introduce(rig, federate, &[]);
    assert_eq!(heard(rig, connection), ["ACK"]);
    rig.message(connection, &Message::Timestamp(START + 9));
    assert_eq!(heard(rig, connection).len(), 1);
    connection
}

/// 1, 2 and 4 send to 0, and 0 asks for 1, 2 and 4; 3 has nothing to do with it. While there is no room, 1 and 4 leave,
/// and come again later.
#[test]
fn those_who_do_not_read_are_told_of_those_who_came_or_left_and_of_no_others() {
    let mut rig = rig(5, 4, LATE);
    let zero = hello(&mut rig, 0, &[(1, DELAY_NONE), (2, DELAY_NONE), (4, DELAY_NONE)]);
    for federate in [1, 2, 4] {
        rig.message(zero, &Message::AddressQuery { federate, is_transient: Some(true) });
    }
    rig.message(zero, &Message::Timestamp(0));
    let [one, two, four] = [1, 2, 4].map(|federate| come(&mut rig, federate));
    let came = [1, 2, 4].map(|federate| [("upstream came", federate), ("outbound came", federate)]);
    assert_eq!(notifications(&mut rig, zero), came.concat());
    let capacity = core::mem::replace(&mut rig.outlet.capacity, 2);
    for connection in [one, four] {
        rig.close(connection);
    }
    rig.outlet.capacity = capacity;
    let now = rig.now;
    rig.rti.handle_writable(now, zero, &mut rig.outlet);
    let left = |federates: &[u16]| {
        let about = |what| federates.iter().map(move |federate| (what, *federate));
        about("upstream left").chain(about("outbound left")).collect::<Vec<_>>()
    };
    assert_eq!(notifications(&mut rig, zero), left(&[1, 4]));
    rig.close(two);
    assert_eq!(notifications(&mut rig, zero), left(&[2]));
    let three = come(&mut rig, 3);
    // The message leaves no room for a notification.
    rig.outlet.capacity = 22;
    rig.message(three, &message(0, 20, b""));
    for federate in [1, 4] {
        come(&mut rig, federate);
    }
    let about = |what| [1, 4].map(|federate| (what, federate));
    assert_eq!(notifications(&mut rig, zero), [about("upstream came"), about("outbound came")].concat());
}

/// The RTI was told of one transient federate, and begins without one.
#[test]
fn a_persistent_federate_too_many_is_refused_at_the_start() {
    let mut rig = rig(3, 1, LATE);
    let [first, second, third] = [0, 1, 2].map(|federate| hello(&mut rig, federate, &[]));
    for connection in [first, second] {
        rig.message(connection, &Message::Timestamp(0));
    }
    assert_eq!(read(&mut rig, third), ["REJECT"]);
    assert!(!rig.outlet.list[third.0].open);
}

#[test]
fn who_is_ready_after_a_stop_is_refused() {
    let (mut rig, [first, new, last]) = with_successor();
    rig.message(first, &Message::StopRequest(at(9)));
    rig.message(last, &Message::StopReply(at(9)));
    assert!(rig.rti.stop_tag().is_some(), "nobody waits for the answer of one that has not begun");
    rig.message(new, &Message::Timestamp(START + 1));
    assert_eq!(heard(&mut rig, new), ["ACK", "REJECT 8"]);
}
