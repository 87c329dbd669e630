// SPDX-License-Identifier: Apache-2.0
//! Dialogues with the federate's state machine before the start, each named after what it proves.

use super::{Config, Federate, Profile, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, UPSTREAM, accepted, connected, drain, in_turn};
use lf_coordination::federate::{
    CONNECT_RETRY, CONNECT_TIME_OUT, ClockSync, ConfigError, ConnectRetry, ConnectStep, Disconnected, Event,
    FederateError, Phase,
};
use lf_coordination::{Deadline, FederateId};
use lf_model::time::Interval;
use lf_wire::{Message, RejectCode, UDP_PORT_CLOCK_SYNC_OFF};

const IN_TURN: &[Message<'static>] = in_turn::<Profile>();

#[test]
fn the_handshake_goes_out_in_order_as_far_as_there_is_room() {
    let mut federate = Federate::new(config(UPSTREAM, DOWNSTREAM)).unwrap();
    assert_eq!(drain(&mut federate), []);
    federate.handle_connected(NOW, [0; 8]);
    assert_eq!(federate.poll_timeout(), Deadline::At(NOW + CONNECT_TIME_OUT));
    assert_eq!(federate.poll_transmit(13), None);
    assert_eq!(federate.poll_transmit(14), Some(Message::FedIds { federate: 1, federation_id: b"federation" }));
    federate.handle_message(NOW, Message::Ack).unwrap();
    let sent = drain(&mut federate);
    assert_eq!((sent[0].name(), sent[1].name()), ("NEIGHBOR_STRUCTURE", "UDP_PORT"));
    assert_eq!(sent[2..], [IN_TURN, &[Message::Timestamp(NOW.as_nanos())]].concat());
    assert_eq!((federate.phase(), federate.poll_timeout()), (Phase::Starting, Deadline::Never));
}

#[test]
fn every_rejection_says_what_to_do() {
    let mut sentences = std::collections::BTreeSet::new();
    for byte in 0..=8 {
        let mut federate = connected(config(&[], DOWNSTREAM));
        let (code, error) = (RejectCode::from_byte(byte), FederateError::Rejected(RejectCode::from_byte(byte)));
        let result = federate.handle_message(NOW, Message::Reject(code));
        if code == RejectCode::IdInUse {
            // Its id may be free in a moment; what is said when it is not is the event loop's business.
            assert_eq!((result, federate.phase()), (Ok(Event::IdInUse), Phase::Disconnected));
        } else {
            assert_eq!((result, federate.phase()), (Err(error), Phase::Failed));
        }
        assert_eq!(drain(&mut federate), []);
        let sentence = error.to_string();
        let advice = sentence.split_once(". ").map_or("", |(_, advice)| advice);
        assert!(["Start", "End", "Use", "Check", "See"].iter().any(|verb| advice.starts_with(verb)), "{sentence}");
        sentences.insert(sentence);
    }
    assert_eq!(sentences.len(), 9, "{sentences:#?}");
}

#[test]
fn a_connection_that_ends_before_the_ack_is_made_again_until_the_time_is_over() {
    let mut federate = Federate::new(config(&[], DOWNSTREAM)).unwrap();
    let mut retry = ConnectRetry::new(NOW);
    let mut now = NOW;
    let mut attempts = 0;
    loop {
        match retry.poll(now) {
            ConnectStep::Attempt => {
                attempts += 1;
                federate.handle_connected(now, [0; 8]);
                assert_eq!(drain(&mut federate).len(), 1);
                assert_eq!(federate.handle_disconnected(), Ok(Disconnected::ConnectAgain));
                assert_eq!((federate.phase(), federate.poll_timeout()), (Phase::Disconnected, Deadline::Never));
            }
            ConnectStep::WaitUntil(time) => {
                assert!(time > now && time <= now + CONNECT_RETRY);
                now = time;
            }
            ConnectStep::GiveUp => break,
        }
    }
    assert_eq!((attempts, now), (120, NOW + CONNECT_TIME_OUT));
}

#[test]
fn an_rti_that_does_not_answer_is_given_up() {
    let mut federate = connected(config(&[], DOWNSTREAM));
    assert_eq!(federate.handle_timeout(NOW), Ok(Event::None));
    assert_eq!(federate.handle_timeout(NOW + CONNECT_TIME_OUT), Err(FederateError::NoAnswer));
    assert_eq!(drain(&mut federate), [Message::Failed]);
}

#[test]
fn an_rti_that_makes_no_exchange_is_an_error_and_one_that_makes_fewer_is_not() {
    for exchanges in 0..3 {
        let mut config = config(&[], DOWNSTREAM);
        config.clock_sync = ClockSync::Init { trials: 5 };
        let time_out = config.clock_sync_time_out;
        let mut federate = connected(config);
        federate.handle_message(NOW, Message::Ack).unwrap();
        assert_eq!(drain(&mut federate)[1], Message::UdpPort(0));
        for _ in 0..exchanges {
            federate.handle_message(NOW, Message::T1(500)).unwrap();
            assert_eq!(drain(&mut federate), [Message::T3 { federate: 1 }]);
            federate.handle_written(NOW);
            assert_eq!(federate.handle_message(NOW, Message::T4(600)), Ok(Event::None));
        }
        let late = NOW + time_out;
        assert_eq!(federate.poll_timeout(), Deadline::At(late));
        match federate.handle_timeout(late) {
            Err(error) => assert_eq!((error, exchanges), (FederateError::NoClockSync, 0)),
            Ok(Event::ClockCorrected(estimate)) => {
                assert_eq!(
                    (estimate.seen, estimate.offset),
                    (exchanges, Interval::from_nanos(50 + 500 - NOW.as_nanos()))
                );
                let time = late.as_nanos() + estimate.offset.as_nanos();
                assert_eq!(drain(&mut federate), [IN_TURN, &[Message::Timestamp(time)]].concat());
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn an_rti_that_makes_more_exchanges_is_told_apart() {
    let mut config = config(&[], DOWNSTREAM);
    config.clock_sync = ClockSync::Init { trials: 1 };
    let mut federate = accepted(config);
    federate.handle_message(NOW, Message::T1(0)).unwrap();
    drain(&mut federate);
    assert!(matches!(federate.handle_message(NOW, Message::T4(0)), Ok(Event::ClockCorrected(_))));
    assert_eq!(federate.handle_message(NOW, Message::T1(0)), Err(FederateError::TrialsDiffer { trials: 1 }));
}

#[test]
fn t4_without_t3_is_unexpected() {
    let mut config = config(&[], DOWNSTREAM);
    config.clock_sync = ClockSync::Init { trials: 1 };
    let mut federate = accepted(config);
    federate.handle_message(NOW, Message::T1(0)).unwrap();
    let expected = FederateError::Unexpected { message: lf_wire::MessageType::T4, phase: Phase::Synchronizing };
    assert_eq!(federate.handle_message(NOW, Message::T4(0)), Err(expected));
}

#[test]
fn without_clock_synchronization_the_rti_is_told_so() {
    let mut federate = connected(config(&[], &[]));
    federate.handle_message(NOW, Message::Ack).unwrap();
    let sent = drain(&mut federate);
    let off = [Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF)];
    assert_eq!(sent[1..], [&off[..], IN_TURN, &[Message::Timestamp(NOW.as_nanos())]].concat());
}

#[test]
fn impossible_configurations_are_refused_at_once() {
    let long = [b'x'; 256];
    let error = Federate::new(Config::with_needs(FederateId(0), &long)).unwrap_err();
    assert_eq!(error, ConfigError::FederationIdTooLong { bytes: 256 });
    assert!(Federate::new(Config::with_needs(FederateId(0), &long[1..])).is_ok());
    let mut none = config(&[], &[]);
    none.clock_sync = ClockSync::Init { trials: 0 };
    assert_eq!(Federate::new(none).unwrap_err(), ConfigError::NoTrials);
    let mut never = config(&[], DOWNSTREAM);
    (never.physical_delay, never.advance_interval) = (Some(Interval::ZERO), Interval::ZERO);
    assert_eq!(Federate::new(never).unwrap_err(), ConfigError::AdvanceInterval);
}

#[test]
fn answers_before_their_questions_are_unexpected() {
    let unexpected = |message: &Message<'_>, phase| {
        let message = message.message_type();
        Err(FederateError::Unexpected { message, phase })
    };
    let reply = Message::AddressQueryReply { port: 4711, address: [127, 0, 0, 1] };
    for message in [Message::Failed, reply] {
        let mut federate = Federate::new(config(&[], DOWNSTREAM)).unwrap();
        assert_eq!(federate.handle_message(NOW, message), unexpected(&message, Phase::Disconnected));
    }
    let mut federate = Federate::new(config(&[], DOWNSTREAM)).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    assert_eq!(federate.handle_message(NOW, Message::Ack), unexpected(&Message::Ack, Phase::Introducing));
    let mut federate = connected(config(&[], DOWNSTREAM));
    federate.handle_message(NOW, Message::Ack).unwrap();
    let start = Message::Timestamp(0);
    assert_eq!(federate.handle_message(NOW, start), unexpected(&start, Phase::Starting), "its own clock comes first");
}

#[test]
fn an_rti_that_fails_before_the_start_is_no_stranger() {
    for mut federate in [connected(config(&[], DOWNSTREAM)), accepted(config(&[], DOWNSTREAM))] {
        assert_eq!(federate.handle_message(NOW, Message::Failed), Err(FederateError::RtiFailed));
    }
}

#[test]
fn addresses_that_nobody_has_asked_for_do_no_harm_before_the_start() {
    let mut federate = accepted(config(&[], DOWNSTREAM));
    for reply in [
        Message::AddressQueryReply { port: 4711, address: [127, 0, 0, 1] },
        Message::AddressQueryReplyIpv6 { port: 4711, address: [1; 16], scope: 0 },
    ] {
        assert_eq!(federate.handle_message(NOW, reply), Ok(Event::None));
    }
    assert_eq!(federate.phase(), Phase::Starting);
}
