// SPDX-License-Identifier: Apache-2.0
//! Flow control at the tag: held senders, and how a stop gets past them.

use lf_coordination::FederateId;
use lf_coordination::rti::{Cause, Config, ConnectionId, Outcome, Status};
use lf_testkit::rti::dialogue::{at, chain, config, message, offered, read, started};
use lf_testkit::rti::{Awaited, Rig, Sizes};
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, Tag, decode};

fn window(window: u16) -> Config<'static> {
    Config { window, ..config() }
}

fn is_held(rig: &Rig, connection: ConnectionId) -> Option<Awaited> {
    rig.outlet.list[connection.0].blocked
}

/// Says that the next event is there, and sends a message at it.
fn step(rig: &mut Rig, from: ConnectionId, to: u16, ns: i64) {
    rig.message(from, &Message::NextEventTag(at(ns)));
    rig.message(from, &message(to, ns, b""));
}

#[test]
fn a_sender_is_held_until_its_receiver_has_got_on() {
    let (mut rig, connections) = chain(window(2), Sizes::ample(2));
    let (sender, receiver) = (connections[0], connections[1]);
    step(&mut rig, sender, 1, 10);
    step(&mut rig, sender, 1, 20);
    assert_eq!(is_held(&rig, sender), None);
    step(&mut rig, sender, 1, 30);
    assert_eq!(is_held(&rig, sender), Some(Awaited::Input(receiver)));
    read(&mut rig, receiver);
    // Nothing that leaves as many before it lets the sender go on.
    rig.message(receiver, &Message::NextEventTag(at(10)));
    assert_eq!(is_held(&rig, sender), Some(Awaited::Input(receiver)));
    rig.message(receiver, &Message::LatestTagComplete(at(10)));
    assert_eq!(is_held(&rig, sender), None);
    assert!(read(&mut rig, receiver).contains(&"message []".to_owned()));
}

/// Once all have offered a larger window, the smallest is that of the federation. An offer that is made before is
/// answered with the configured window.
#[test]
fn the_smallest_window_that_all_offer_counts() {
    let (mut rig, connections) = chain(window(2), Sizes { in_transit: 20, ..Sizes::ample(2) });
    let (sender, receiver) = (connections[0], connections[1]);
    let answered =
        |rig: &mut Rig, federate: u16, window| offered(rig, connections[usize::from(federate)], federate, window);
    assert_eq!(answered(&mut rig, 0, 8), 2);
    assert_eq!(answered(&mut rig, 1, 5), 5);
    assert_eq!(answered(&mut rig, 0, 3), 3);
    // Half of the storage for tags is for messages that a delay keeps in transit.
    assert_eq!((answered(&mut rig, 0, 100), answered(&mut rig, 1, 100)), (5, 10));
    assert_eq!(answered(&mut rig, 1, 4), 4);
    for ns in [10, 20, 30, 40] {
        step(&mut rig, sender, 1, ns);
        assert_eq!(is_held(&rig, sender), None, "{ns}");
    }
    step(&mut rig, sender, 1, 50);
    assert_eq!(is_held(&rig, sender), Some(Awaited::Input(receiver)));
}

#[test]
fn messages_of_one_tag_and_of_tags_to_come_are_not_held() {
    let (mut rig, connections) = started(window(1), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    rig.message(connections[0], &Message::NextEventTag(at(10)));
    for ns in [10, 10, 20, 30, 40] {
        // As with several ports and an `after`: all are sent at the first tag.
        rig.message(connections[0], &message(1, ns, b""));
        assert_eq!(is_held(&rig, connections[0]), None);
    }
    rig.message(connections[0], &Message::NextEventTag(at(11)));
    rig.message(connections[0], &message(1, 50, b""));
    assert_eq!(is_held(&rig, connections[0]), Some(Awaited::Input(connections[1])));
}

#[test]
fn an_announcement_that_a_message_has_overtaken_holds_nothing_back() {
    // 0 → 1 → 2, and 2 has a message of 0 at 20. What 1 does because of an earlier message must get through to it.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut rig, connections) = started(window(1), Sizes::ample(3), &upstream);
    rig.message(connections[1], &Message::NextEventTag(at(100)));
    rig.message(connections[0], &Message::NextEventTag(at(10)));
    rig.message(connections[0], &message(1, 10, b""));
    rig.message(connections[0], &message(2, 20, b""));
    rig.message(connections[1], &message(2, 10, b"early"));
    assert_eq!(is_held(&rig, connections[1]), None);
}

#[test]
fn a_receiver_of_more_messages_than_the_rti_stores_keeps_no_federate_waiting() {
    // 0 → 1 → 2, and 0 → 2. The RTI remembers two tags for each.
    let upstream = [vec![], vec![(0, 0)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut rig, connections) = started(config(), Sizes { in_transit: 2, ..Sizes::ample(3) }, &upstream);
    let [source, middle, last] = connections[..] else { panic!("there are three") };
    rig.message(middle, &Message::NextEventTag(at(90)));
    rig.message(last, &Message::NextEventTag(at(90)));
    rig.message(source, &Message::NextEventTag(at(0)));
    // All at one tag, as with several `after`: the last two do not fit.
    for ns in [10, 20, 30, 50] {
        rig.message(source, &message(1, ns, b""));
    }
    rig.message(source, &Message::NextEventTag(at(42)));
    assert!(read(&mut rig, middle).contains(&"TAG 42 0".to_owned()));
    for (done, next) in [(10, 20), (20, 30), (30, 50)] {
        rig.message(middle, &Message::NextEventTag(at(done)));
        rig.message(middle, &Message::LatestTagComplete(at(done)));
        rig.message(middle, &Message::NextEventTag(at(next)));
    }
    for ns in [42, 43, 44] {
        step(&mut rig, source, 2, ns);
    }
    // That 0 is held for 2 must not keep 2 waiting: 1 has no event before 50, and had seen all when it said so.
    assert_eq!(is_held(&rig, source), Some(Awaited::Input(last)));
    assert!(read(&mut rig, last).contains(&format!("TAG 42 {}", u32::MAX)));
    rig.message(last, &Message::NextEventTag(at(42)));
    rig.message(last, &Message::LatestTagComplete(at(42)));
    assert_eq!(is_held(&rig, source), None);
}

#[test]
fn an_event_that_is_not_announced_holds_nothing_back() {
    // 0 → 1 → 2, and 2 has a message of 0 at 80. No federate needs to know about the tag of 1 at 60 because of a
    // message of 0 at 50, so 1 announces neither, as DNETs allow.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut rig, connections) = started(window(1), Sizes::ample(3), &upstream);
    rig.message(connections[1], &Message::NextEventTag(at(100)));
    rig.message(connections[0], &Message::NextEventTag(at(50)));
    rig.message(connections[0], &message(1, 50, b""));
    rig.message(connections[0], &message(2, 80, b""));
    rig.message(connections[1], &Message::LatestTagComplete(at(50)));
    rig.message(connections[1], &message(2, 60, b"unannounced"));
    assert_eq!(is_held(&rig, connections[1]), None);
}

/// Federates rely on this DNET: they do not count a message that they have sent as one.
#[test]
fn the_sender_of_a_message_is_asked_for_the_net_that_its_receiver_needs() {
    // 0 → 1 → 2, and 0 → 2 after 30 ns.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, 30)]];
    let (mut rig, connections) = started(config(), Sizes::ample(3), &upstream);
    for connection in [connections[2], connections[1], connections[0]] {
        let next = if connection == connections[0] { at(5) } else { Tag::FOREVER };
        rig.message(connection, &Message::NextEventTag(next));
    }
    let asked = |rig: &mut Rig| -> Vec<_> {
        let said = rig.take(connections[0], usize::MAX);
        let mut rest = &said[..];
        std::iter::from_fn(|| match decode(rest, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::DownstreamNextEventTag(tag), len }) => {
                rest = &rest[len..];
                Some(tag)
            }
            _ => None,
        })
        .collect()
    };
    assert_eq!(asked(&mut rig).last(), Some(&Tag::FOREVER));
    // By way of 1, what 0 does at 35 can reach 2 at once.
    rig.message(connections[0], &message(2, 35, b""));
    assert_eq!(asked(&mut rig), [at(35)]);
    rig.message(connections[0], &message(1, 5, b""));
    assert_eq!(asked(&mut rig), [at(5)]);
}

#[test]
fn a_receiver_that_leaves_holds_nobody_any_more() {
    for how in [Message::Resign, Message::Failed] {
        let (mut rig, connections) = chain(window(1), Sizes::ample(2));
        step(&mut rig, connections[0], 1, 10);
        step(&mut rig, connections[0], 1, 20);
        assert!(is_held(&rig, connections[0]).is_some());
        rig.message(connections[1], &how);
        assert_eq!(is_held(&rig, connections[0]), None);
        rig.message(connections[0], &Message::Resign);
        assert!(matches!(rig.rti.status(), Status::Finished(_)));
    }
}

#[test]
fn the_answer_to_a_stop_request_is_found_behind_what_is_held() {
    let (mut rig, connections) = chain(window(1), Sizes::ample(3));
    let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
    for ns in [10, 20, 30, 40] {
        step(&mut rig, sender, 1, ns);
    }
    rig.message(receiver, &Message::StopRequest(at(5)));
    rig.message(other, &Message::StopReply(at(5)));
    read(&mut rig, receiver);
    assert!(read(&mut rig, sender).contains(&"STOP_REQUEST".to_owned()));
    rig.message(sender, &Message::StopReply(at(50)));
    for connection in &connections {
        assert!(read(&mut rig, *connection).contains(&"STOP_GRANTED".to_owned()));
    }
    // A held message comes in its order, and the answer means nothing new then.
    for ns in [10, 20, 30] {
        assert_eq!(is_held(&rig, sender), Some(Awaited::Input(receiver)));
        rig.message(receiver, &Message::LatestTagComplete(at(ns)));
        assert!(read(&mut rig, receiver).contains(&"message []".to_owned()));
    }
    assert_eq!(is_held(&rig, sender), None);
    for connection in &connections {
        rig.message(*connection, &Message::Resign);
    }
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::Complete));
}

#[test]
fn a_federate_that_leaves_behind_held_messages_agrees_to_a_stop() {
    let (mut rig, connections) = chain(window(1), Sizes::ample(2));
    for ns in [10, 20, 30] {
        step(&mut rig, connections[0], 1, ns);
    }
    rig.message(connections[0], &Message::Resign);
    rig.message(connections[1], &Message::StopRequest(at(5)));
    assert!(read(&mut rig, connections[1]).contains(&"STOP_GRANTED".to_owned()));
    // All that is still to come is later than the stop, and holds nothing up.
    assert_eq!(is_held(&rig, connections[0]), None);
    rig.message(connections[1], &Message::Resign);
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::Complete));
}

/// Asserts that the RTI forwards all messages of a sender that is gone, as the receiver completes their tags.
fn assert_passed_on(rig: &mut Rig, receiver: ConnectionId, tags: impl IntoIterator<Item = i64>) {
    for ns in tags {
        assert!(read(rig, receiver).contains(&"message []".to_owned()), "at {ns}");
        assert!(!rig.outlet.log_events.iter().any(|event| event.contains("is lost")), "{:?}", rig.outlet.log_events);
        rig.message(receiver, &Message::LatestTagComplete(at(ns)));
    }
}

#[test]
fn a_federate_lost_behind_held_messages_agrees_to_a_stop_and_its_messages_count() {
    for stop_first in [true, false] {
        let (mut rig, connections) = chain(window(1), Sizes::ample(3));
        let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
        for ns in [10, 20, 30, 40] {
            step(&mut rig, sender, 1, ns);
        }
        if stop_first {
            rig.message(other, &Message::StopRequest(at(50)));
            rig.close(sender);
        } else {
            rig.close(sender);
            rig.message(other, &Message::StopRequest(at(50)));
        }
        rig.message(receiver, &Message::StopReply(at(50)));
        assert!(read(&mut rig, other).contains(&"STOP_GRANTED".to_owned()), "{:?}", rig.outlet.log_events);
        assert_passed_on(&mut rig, receiver, [10, 20, 30]);
        assert_eq!(read(&mut rig, receiver).iter().filter(|said| *said == "message []").count(), 1);
        assert!(rig.outlet.log_events.last().is_some_and(|event| event.contains("federate 0 is lost")));
        for connection in [receiver, other] {
            rig.message(connection, &Message::Resign);
        }
        let lost = Outcome::Lost { federate: FederateId(0), cause: Cause::ConnectionLost };
        assert_eq!(rig.rti.status(), Status::Finished(lost));
    }
}

#[test]
fn the_answer_that_a_lost_sender_has_left_counts() {
    let (mut rig, connections) = chain(window(1), Sizes::ample(3));
    let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
    for ns in [10, 20, 30] {
        step(&mut rig, sender, 1, ns);
    }
    rig.message(sender, &Message::StopReply(at(70)));
    rig.close(sender);
    rig.message(other, &Message::StopRequest(at(50)));
    rig.message(receiver, &Message::StopReply(at(50)));
    assert_eq!(rig.rti.stop_tag(), Some(lf_coordination::from_wire(at(70))));
}
