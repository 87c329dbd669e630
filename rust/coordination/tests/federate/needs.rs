// SPDX-License-Identifier: Apache-2.0
//! A capability that a program does not need of its federate makes no difference if it is not used, and is refused if
//! it is.

use crate::federate_support::dialogue::{DOWNSTREAM, NOW, START, ms, net};
use lf_coordination::federate::{All, ClockSync, Config, Event, Federate, FederateError, Needs, Phase};
use lf_coordination::{FederateId, to_wire};
use lf_model::time::Interval;
use lf_testkit::profiles::CentralizedSource;
use lf_wire::{Message, MessageType};
use proptest::prelude::*;

fn drain<N: Needs>(federate: &mut Federate<'static, N>) -> Vec<Message<'static>> {
    std::iter::from_fn(|| federate.poll_transmit(usize::MAX)).collect()
}

fn started<N: Needs>() -> Federate<'static, N> {
    let config =
        Config { downstream: DOWNSTREAM, clock_sync: ClockSync::Off, ..Config::with_needs(FederateId(1), b"f") };
    let mut federate = Federate::new(config).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    drain(&mut federate);
    for message in [Message::Ack, Message::Timestamp(START.as_nanos())] {
        federate.handle_message(NOW, message).unwrap();
        drain(&mut federate);
    }
    assert_eq!(federate.phase(), Phase::Running);
    federate
}

/// Does one of the things that can happen to such a program, and says all that can be seen of it afterwards.
fn step<N: Needs>(federate: &mut Federate<'static, N>, operation: u8, at: i64) -> String {
    let (now, tag) = (START + Interval::from_millis(at), ms(at));
    let message = match operation {
        0..=3 => return format!("{} {:?}", federate.next_event(now, tag), drain(federate)),
        4..=7 => return format!("{:?} {:?}", federate.begin(tag), drain(federate)),
        8..=10 => {
            if operation > 8 {
                federate.sent();
            }
            federate.complete(false);
            return format!("{:?} {:?}", federate.current(), drain(federate));
        }
        11 => return format!("{:?} {:?}", federate.handle_timeout(now), drain(federate)),
        12 => Message::PortAbsent { port: u16::MAX, federate: 1, tag: lf_wire::Tag::NEVER },
        13 => Message::StopRequest(to_wire(tag)),
        14 => Message::StopGranted(to_wire(tag)),
        _ => Message::DownstreamNextEventTag(to_wire(tag)),
    };
    format!("{:?} {:?} {:?}", federate.handle_message(now, message), drain(federate), federate.poll_timeout())
}

proptest! {
    #[test]
    fn capabilities_without_use_make_no_difference(steps in prop::collection::vec((0..17u8, 0..30i64), 0..80)) {
        let (mut whole, mut part) = (started::<All>(), started::<CentralizedSource>());
        for (operation, at) in steps {
            prop_assert_eq!(step(&mut whole, operation, at), step(&mut part, operation, at));
            prop_assert_eq!(whole.phase(), part.phase());
        }
    }
}

#[test]
fn messages_that_no_program_needs_are_errors() {
    let tag = to_wire(ms(1));
    for message in [
        Message::TaggedMessage { port: 0, federate: 1, tag, payload: b"1" },
        Message::PortAbsent { port: 0, federate: 1, tag },
        Message::ProvisionalTagGrant(tag),
    ] {
        let (phase, message_type): (_, MessageType) = (Phase::Running, message.message_type());
        let refused = started::<CentralizedSource>().handle_message(NOW, message);
        assert_eq!(refused, Err(FederateError::Unexpected { message: message_type, phase }));
    }
}

#[test]
fn a_grant_says_nothing_to_a_program_that_waits_for_none() {
    let mut federate = started::<CentralizedSource>();
    assert_eq!(federate.handle_message(NOW, Message::TagGrant(to_wire(ms(1)))), Ok(Event::None));
    assert!(federate.next_event(NOW, ms(5)));
    assert_eq!(drain(&mut federate), [net(ms(5))]);
}

#[test]
fn a_departure_says_nothing_to_a_program_without_cycles() {
    let mut federate = started::<CentralizedSource>();
    let left = Message::UpstreamDisconnected { federate: 2 };
    assert_eq!(federate.handle_message(NOW, left), Ok(Event::None));
    assert_eq!(federate.phase(), Phase::Running);
}
