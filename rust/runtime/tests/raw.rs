// SPDX-License-Identifier: Apache-2.0
//! The RTI's event loop with federates that a tester plays, because no federate of ours does what they do.

use crate::support::raw::{Tester, config, with_rti};
use lf_coordination::FederateId;
use lf_coordination::rti::{AfterLoss, Cause, Outcome};
use lf_runtime::DELAY_NONE;
use lf_testkit::world::Conditions;
use lf_wire::{Message, Tag};

/// Sends messages to federate 1, each with the announcement of the next.
fn send(tester: &mut Tester, from: usize, count: i64) {
    for ns in 1..=count {
        let tag = tester.at(ns);
        tester.say(from, &Message::NextEventTag(tag));
        tester.say(from, &Message::TaggedMessage { port: 0, federate: 1, tag, payload: b"x" });
    }
}

/// Takes what comes, gets on with it, and agrees to a stop, until all is granted. Gives how many messages there were.
fn take_all(tester: &mut Tester, connection: usize) -> usize {
    let mut count = 0;
    loop {
        let mut answer = None;
        assert!(tester.hear(connection, |message| match message {
            Message::TaggedMessage { tag, .. } => {
                answer = Some(Message::LatestTagComplete(*tag));
                true
            }
            Message::StopRequest(tag) => {
                answer = Some(Message::StopReply(*tag));
                true
            }
            Message::TagGrant(tag) => *tag == Tag::FOREVER,
            _ => false,
        }));
        match answer {
            Some(answer) => {
                count += usize::from(matches!(answer, Message::LatestTagComplete(_)));
                tester.say(connection, &answer);
            }
            None => return count,
        }
    }
}

/// The sender is gone, and its answer to a stop cannot come: what it has said is passed on all the same.
#[test]
fn held_messages_of_a_lost_sender_arrive_while_a_stop_is_pending() {
    for seed in 0..16 {
        let config = lf_coordination::rti::Config { after_loss: AfterLoss::GoOn, ..config() };
        let ended = with_rti(config, 3, Conditions::seeded(seed), |tester| {
            let federates = tester.start(&[&[], &[(0, DELAY_NONE)], &[]]);
            let [sender, receiver, other] = federates[..] else { panic!("there are three") };
            send(tester, sender, 20);
            tester.say(other, &Message::StopRequest(tester.at(1000)));
            tester.end(sender);
            assert_eq!(take_all(tester, receiver), 20, "seed {seed}");
        });
        let lost = Outcome::Lost { federate: FederateId(0), cause: Cause::ConnectionLost };
        assert_eq!((ended.outcome, ended.violation), (Ok(lost), None), "{:?}", ended.log_events);
    }
}

/// Nothing can happen at the end of time, so that a message for it can only be its sender's mistake.
#[test]
fn the_sender_of_a_message_for_the_end_of_time_is_named() {
    for tag in [Tag::FOREVER, Tag::NEVER] {
        let config = lf_coordination::rti::Config { after_loss: AfterLoss::StopAll, ..config() };
        let ended = with_rti(config, 2, Conditions::seeded(1), |tester| {
            let federates = tester.start(&[&[], &[(0, DELAY_NONE)]]);
            let [sender, receiver] = federates[..] else { panic!("there are two") };
            tester.say(sender, &Message::TaggedMessage { port: 0, federate: 1, tag, payload: b"x" });
            assert!(tester.hear(receiver, |message| *message == Message::Failed));
        });
        let said = "federate 0 is lost: it broke the protocol: it sent federate 1 a message for the end of time";
        assert!(ended.log_events.iter().any(|event| event.starts_with(said)), "{:?}", ended.log_events);
    }
}
