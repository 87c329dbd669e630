// SPDX-License-Identifier: Apache-2.0
//! Flow control at the tag: held senders, and how a stop gets past them.

mod rti_support;

use lf_coordination::FederateId;
use lf_coordination::rti::{Cause, Config, ConnectionId, Outcome, Status};
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, Tag, decode};
use rti_support::dialogue::{at, chain, config, message, read, started};
use rti_support::{Awaited, Sizes, World};

fn window(window: usize) -> Config<'static> {
    Config { window, ..config() }
}

fn is_held(world: &World, connection: ConnectionId) -> Option<Awaited> {
    world.outlet.list[connection.0].blocked
}

/// Says that the next event is there, and sends a message at it.
fn step(world: &mut World, from: ConnectionId, to: u16, ns: i64) {
    world.message(from, &Message::NextEventTag(at(ns)));
    world.message(from, &message(to, ns, b""));
}

#[test]
fn a_sender_is_held_until_its_receiver_has_got_on() {
    let (mut world, connections) = chain(window(2), Sizes::ample(2));
    let (sender, receiver) = (connections[0], connections[1]);
    step(&mut world, sender, 1, 10);
    step(&mut world, sender, 1, 20);
    assert_eq!(is_held(&world, sender), None);
    step(&mut world, sender, 1, 30);
    assert_eq!(is_held(&world, sender), Some(Awaited::Input(receiver)));
    read(&mut world, receiver);
    // Nothing that leaves as many before it lets the sender go on.
    world.message(receiver, &Message::NextEventTag(at(10)));
    assert_eq!(is_held(&world, sender), Some(Awaited::Input(receiver)));
    world.message(receiver, &Message::LatestTagComplete(at(10)));
    assert_eq!(is_held(&world, sender), None);
    assert!(read(&mut world, receiver).contains(&"message []".to_owned()));
}

#[test]
fn messages_of_one_tag_and_of_tags_to_come_are_not_held() {
    let (mut world, connections) = started(window(1), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    world.message(connections[0], &Message::NextEventTag(at(10)));
    for ns in [10, 10, 20, 30, 40] {
        // As with several ports and an `after`: all are sent at the first tag.
        world.message(connections[0], &message(1, ns, b""));
        assert_eq!(is_held(&world, connections[0]), None);
    }
    world.message(connections[0], &Message::NextEventTag(at(11)));
    world.message(connections[0], &message(1, 50, b""));
    assert_eq!(is_held(&world, connections[0]), Some(Awaited::Input(connections[1])));
}

#[test]
fn an_announcement_that_a_message_has_overtaken_holds_nothing_back() {
    // 0 → 1 → 2, and 2 has a message of 0 at 20. What 1 does because of an earlier message must get through to it.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut world, connections) = started(window(1), Sizes::ample(3), &upstream);
    world.message(connections[1], &Message::NextEventTag(at(100)));
    world.message(connections[0], &Message::NextEventTag(at(10)));
    world.message(connections[0], &message(1, 10, b""));
    world.message(connections[0], &message(2, 20, b""));
    world.message(connections[1], &message(2, 10, b"early"));
    assert_eq!(is_held(&world, connections[1]), None);
}

#[test]
fn who_has_seen_more_messages_than_the_rti_remembers_keeps_nobody_waiting() {
    // 0 → 1 → 2, and 0 → 2. The RTI remembers two tags for each.
    let upstream = [vec![], vec![(0, 0)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut world, connections) = started(config(), Sizes { in_transit: 2, ..Sizes::ample(3) }, &upstream);
    let [source, middle, last] = connections[..] else { panic!("there are three") };
    world.message(middle, &Message::NextEventTag(at(90)));
    world.message(last, &Message::NextEventTag(at(90)));
    world.message(source, &Message::NextEventTag(at(0)));
    // All at one tag, as with several `after`: the last two do not fit.
    for ns in [10, 20, 30, 50] {
        world.message(source, &message(1, ns, b""));
    }
    world.message(source, &Message::NextEventTag(at(42)));
    assert!(read(&mut world, middle).contains(&"TAG 42 0".to_owned()));
    for (done, next) in [(10, 20), (20, 30), (30, 50)] {
        world.message(middle, &Message::NextEventTag(at(done)));
        world.message(middle, &Message::LatestTagComplete(at(done)));
        world.message(middle, &Message::NextEventTag(at(next)));
    }
    for ns in [42, 43, 44] {
        step(&mut world, source, 2, ns);
    }
    // That 0 is held for 2 must not keep 2 waiting: 1 has no event before 50, and had seen all when it said so.
    assert_eq!(is_held(&world, source), Some(Awaited::Input(last)));
    assert!(read(&mut world, last).contains(&format!("TAG 42 {}", u32::MAX)));
    world.message(last, &Message::NextEventTag(at(42)));
    world.message(last, &Message::LatestTagComplete(at(42)));
    assert_eq!(is_held(&world, source), None);
}

#[test]
fn an_event_that_is_not_announced_holds_nothing_back() {
    // 0 → 1 → 2, and 2 has a message of 0 at 80. No federate needs to know about the tag of 1 at 60 because of a
    // message of 0 at 50, so 1 announces neither, as DNETs allow.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, DELAY_NONE)]];
    let (mut world, connections) = started(window(1), Sizes::ample(3), &upstream);
    world.message(connections[1], &Message::NextEventTag(at(100)));
    world.message(connections[0], &Message::NextEventTag(at(50)));
    world.message(connections[0], &message(1, 50, b""));
    world.message(connections[0], &message(2, 80, b""));
    world.message(connections[1], &Message::LatestTagComplete(at(50)));
    world.message(connections[1], &message(2, 60, b"unannounced"));
    assert_eq!(is_held(&world, connections[1]), None);
}

/// Federates rely on this DNET: they do not count a message that they have sent as one.
#[test]
fn who_sends_a_message_is_asked_for_what_its_receiver_needs_then() {
    // 0 → 1 → 2, and 0 → 2 after 30 ns.
    let upstream = [vec![], vec![(0, DELAY_NONE)], vec![(1, DELAY_NONE), (0, 30)]];
    let (mut world, connections) = started(config(), Sizes::ample(3), &upstream);
    for connection in [connections[2], connections[1], connections[0]] {
        let next = if connection == connections[0] { at(5) } else { Tag::FOREVER };
        world.message(connection, &Message::NextEventTag(next));
    }
    let asked = |world: &mut World| -> Vec<_> {
        let said = world.take(connections[0], usize::MAX);
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
    assert_eq!(asked(&mut world).last(), Some(&Tag::FOREVER));
    // By way of 1, what 0 does at 35 can reach 2 at once.
    world.message(connections[0], &message(2, 35, b""));
    assert_eq!(asked(&mut world), [at(35)]);
    world.message(connections[0], &message(1, 5, b""));
    assert_eq!(asked(&mut world), [at(5)]);
}

#[test]
fn a_receiver_that_leaves_holds_nobody_any_more() {
    for how in [Message::Resign, Message::Failed] {
        let (mut world, connections) = chain(window(1), Sizes::ample(2));
        step(&mut world, connections[0], 1, 10);
        step(&mut world, connections[0], 1, 20);
        assert!(is_held(&world, connections[0]).is_some());
        world.message(connections[1], &how);
        assert_eq!(is_held(&world, connections[0]), None);
        world.message(connections[0], &Message::Resign);
        assert!(matches!(world.rti.status(), Status::Finished(_)));
    }
}

#[test]
fn the_answer_to_a_stop_request_is_found_behind_what_is_held() {
    let (mut world, connections) = chain(window(1), Sizes::ample(3));
    let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
    for ns in [10, 20, 30, 40] {
        step(&mut world, sender, 1, ns);
    }
    world.message(receiver, &Message::StopRequest(at(5)));
    world.message(other, &Message::StopReply(at(5)));
    read(&mut world, receiver);
    assert!(read(&mut world, sender).contains(&"STOP_REQUEST".to_owned()));
    world.message(sender, &Message::StopReply(at(50)));
    for connection in &connections {
        assert!(read(&mut world, *connection).contains(&"STOP_GRANTED".to_owned()));
    }
    // A held message comes in its order, and the answer means nothing new then.
    for ns in [10, 20, 30] {
        assert_eq!(is_held(&world, sender), Some(Awaited::Input(receiver)));
        world.message(receiver, &Message::LatestTagComplete(at(ns)));
        assert!(read(&mut world, receiver).contains(&"message []".to_owned()));
    }
    assert_eq!(is_held(&world, sender), None);
    for connection in &connections {
        world.message(*connection, &Message::Resign);
    }
    assert_eq!(world.rti.status(), Status::Finished(Outcome::Complete));
}

#[test]
fn who_leaves_behind_what_is_held_agrees_to_a_stop() {
    let (mut world, connections) = chain(window(1), Sizes::ample(2));
    for ns in [10, 20, 30] {
        step(&mut world, connections[0], 1, ns);
    }
    world.message(connections[0], &Message::Resign);
    world.message(connections[1], &Message::StopRequest(at(5)));
    assert!(read(&mut world, connections[1]).contains(&"STOP_GRANTED".to_owned()));
    // All that is still to come is later than the stop, and holds nothing up.
    assert_eq!(is_held(&world, connections[0]), None);
    world.message(connections[1], &Message::Resign);
    assert_eq!(world.rti.status(), Status::Finished(Outcome::Complete));
}

/// The sender of these is gone, and what it has said is passed on as its receiver gets on, to the last message.
fn assert_passed_on(world: &mut World, receiver: ConnectionId, tags: impl IntoIterator<Item = i64>) {
    for ns in tags {
        assert!(read(world, receiver).contains(&"message []".to_owned()), "at {ns}");
        assert!(!world.outlet.notices.iter().any(|notice| notice.contains("is lost")), "{:?}", world.outlet.notices);
        world.message(receiver, &Message::LatestTagComplete(at(ns)));
    }
}

#[test]
fn who_is_lost_behind_what_is_held_agrees_to_a_stop_and_has_said_what_it_has_said() {
    for stop_first in [true, false] {
        let (mut world, connections) = chain(window(1), Sizes::ample(3));
        let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
        for ns in [10, 20, 30, 40] {
            step(&mut world, sender, 1, ns);
        }
        if stop_first {
            world.message(other, &Message::StopRequest(at(50)));
            world.close(sender);
        } else {
            world.close(sender);
            world.message(other, &Message::StopRequest(at(50)));
        }
        world.message(receiver, &Message::StopReply(at(50)));
        assert!(read(&mut world, other).contains(&"STOP_GRANTED".to_owned()), "{:?}", world.outlet.notices);
        assert_passed_on(&mut world, receiver, [10, 20, 30]);
        assert_eq!(read(&mut world, receiver).iter().filter(|said| *said == "message []").count(), 1);
        assert!(world.outlet.notices.last().is_some_and(|notice| notice.contains("federate 0 is lost")));
        for connection in [receiver, other] {
            world.message(connection, &Message::Resign);
        }
        let lost = Outcome::Lost { federate: FederateId(0), cause: Cause::ConnectionLost };
        assert_eq!(world.rti.status(), Status::Finished(lost));
    }
}

#[test]
fn the_answer_that_a_lost_sender_has_left_counts() {
    let (mut world, connections) = chain(window(1), Sizes::ample(3));
    let (sender, receiver, other) = (connections[0], connections[1], connections[2]);
    for ns in [10, 20, 30] {
        step(&mut world, sender, 1, ns);
    }
    world.message(sender, &Message::StopReply(at(70)));
    world.close(sender);
    world.message(other, &Message::StopRequest(at(50)));
    world.message(receiver, &Message::StopReply(at(50)));
    assert_eq!(world.rti.stop_tag(), Some(lf_coordination::from_wire(at(70))));
}
