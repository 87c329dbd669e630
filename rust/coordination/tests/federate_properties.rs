// SPDX-License-Identifier: Apache-2.0
//! Invariants of the federate's state machine, for any input.

use std::collections::BTreeSet;

use crate::federate_support::dialogue::{DOWNSTREAM, NOW, START, UPSTREAM, config, connected, started};
use lf_coordination::federate::{Event, Federate, Phase};
use lf_coordination::{from_wire, to_wire};
use lf_model::time::{Interval, Tag};
use lf_testkit::federate::{federate_raw, federate_structured};
use lf_wire::{Message, RejectCode};
use proptest::collection::vec;
use proptest::prelude::*;

proptest! {
    /// No sequence of operations and messages, sensible or not, breaks it.
    #[test]
    fn nothing_breaks_it(data in vec(any::<u8>(), 0..1500)) {
        federate_structured(&data);
    }

    /// Bytes from the RTI, cut anywhere: whatever decodes is handled or refused, and refused for good.
    #[test]
    fn random_bytes_are_survived(choice: u8, bytes in vec(prop_oneof![0..27u8, any::<u8>()], 0..400)) {
        federate_raw(&[&[choice][..], &bytes].concat());
    }
}

/// One step of an RTI and a network that keep their promises.
#[derive(Clone, Debug)]
enum Turn {
    /// The RTI grants this many tags more, but not beyond its next message.
    Grant(i64),
    /// A message comes, this many ns after the last granted tag.
    Message(i64),
    /// A DNET, this many ns from the federate's current tag.
    Dnet(i64),
    /// The federate's own next event is this many ns after its current tag.
    Own(i64),
    /// The federate runs what it may.
    Run,
    /// The out-buffer gets room.
    Drain,
}

fn any_turn() -> impl Strategy<Value = Turn> {
    prop_oneof![
        (0..30i64).prop_map(Turn::Grant),
        (1..30i64).prop_map(Turn::Message),
        (-20..60i64).prop_map(Turn::Dnet),
        (1..30i64).prop_map(Turn::Own),
        Just(Turn::Run),
        Just(Turn::Run),
        Just(Turn::Drain),
    ]
}

/// A federate whose event loop does what the module's description asks for.
struct Loop {
    federate: Federate<'static>,
    upstream: bool,
    /// Tags of its own events, and of messages that have come.
    events: BTreeSet<Tag>,
    inputs: BTreeSet<Tag>,
    /// The last NET that went out, and the earliest message since.
    net: Tag,
    message: Tag,
    /// The NET that the RTI knows: the last one, lowered by earlier messages.
    known: Tag,
    ltc: Tag,
}

impl Loop {
    fn new(upstream: bool, downstream: bool) -> Self {
        let upstream_federates = if upstream { UPSTREAM } else { &[] };
        let mut federate = started(config(upstream_federates, if downstream { DOWNSTREAM } else { &[] }));
        let first = Tag::at(START);
        federate.next_event(NOW, first);
        let events = BTreeSet::from([first]);
        Self {
            federate,
            upstream,
            events,
            inputs: BTreeSet::new(),
            net: Tag::NEVER,
            message: Tag::FOREVER,
            known: Tag::NEVER,
            ltc: Tag::NEVER,
        }
    }

    fn turn(&mut self, turn: &Turn) {
        let current = self.federate.current().max(Tag::at(START));
        let after = |tag: Tag, ns: i64| Tag::at(tag.time + Interval::from_nanos(ns));
        let granted = self.federate.granted().max(Tag::at(START).before());
        match *turn {
            Turn::Grant(ns) if self.upstream => self.handle(Message::TagGrant(to_wire(after(granted, ns)))),
            Turn::Message(ns) if self.upstream => {
                let tag = after(granted.max(current), ns);
                let message = Message::TaggedMessage { port: 0, federate: 1, tag: to_wire(tag), payload: &[] };
                assert_eq!(
                    self.federate.handle_message(NOW, message),
                    Ok(Event::Message { port: 0, tag, payload: &[] })
                );
                self.message = self.message.min(tag);
                self.known = self.known.min(tag);
                self.inputs.insert(tag);
            }
            Turn::Dnet(ns) => self.handle(Message::DownstreamNextEventTag(to_wire(after(current, ns)))),
            Turn::Own(ns) => drop(self.events.insert(after(current, ns))),
            Turn::Run => self.run(),
            Turn::Drain => self.drain(),
            Turn::Grant(_) | Turn::Message(_) => {}
        }
        self.federate.next_event(NOW, self.next());
    }

    fn handle(&mut self, message: Message<'_>) {
        self.federate.handle_message(NOW, message).unwrap();
    }

    fn next(&self) -> Tag {
        self.events.first().copied().into_iter().chain(self.inputs.first().copied()).min().unwrap_or(Tag::FOREVER)
    }

    fn run(&mut self) {
        let tag = self.next();
        if tag < Tag::FOREVER && self.federate.may_advance(tag) {
            self.federate.begin(tag).unwrap();
            self.events.remove(&tag);
            self.federate.sent();
            let input = self.inputs.remove(&tag);
            self.federate.complete(input);
        }
    }

    fn drain(&mut self) {
        while let Some(message) = self.federate.poll_transmit(usize::MAX) {
            match message {
                Message::NextEventTag(tag) => {
                    let tag = from_wire(tag);
                    assert!(tag != self.net || self.message < tag, "told twice, and not lowered since");
                    assert!(tag >= self.federate.current(), "a NET of the past");
                    let own = self.events.iter().all(|own| *own > tag);
                    assert!(tag > self.net || tag >= self.message || !own, "{tag:?} after {:?}", self.net);
                    (self.net, self.message, self.known) = (tag, Tag::FOREVER, tag);
                }
                Message::LatestTagComplete(tag) => {
                    let tag = from_wire(tag);
                    assert!(tag > self.ltc && tag <= self.federate.current());
                    self.ltc = tag;
                }
                // The RTI has taken all that came before the question.
                question @ Message::PortAbsent { federate: 1, port: u16::MAX, .. } => self.handle(question),
                Message::Resign | Message::TaggedMessage { .. } => {}
                other => panic!("{other:?}"),
            }
        }
    }
}

proptest! {
    /// With an RTI that keeps its promises: NETs go back only because of a message or an earlier event of the program's
    /// own, are never of the past nor sent twice; LTCs only go on; a federate that waits for a grant has sent its NET.
    #[test]
    fn nets_and_ltcs_go_on(
        (upstream, downstream) in any::<(bool, bool)>(),
        turns in vec(any_turn(), 0..150),
    ) {
        let mut participant = Loop::new(upstream, downstream);
        for turn in &turns {
            participant.turn(turn);
            let next = participant.next();
            let waits = upstream && next < Tag::FOREVER && next > participant.federate.granted();
            if waits {
                participant.drain();
                prop_assert_eq!(participant.known, next, "it waits without having told for what");
            }
        }
        participant.drain();
        participant.federate.finish();
        let end: Vec<_> = std::iter::from_fn(|| participant.federate.poll_transmit(usize::MAX)).collect();
        prop_assert_eq!(end.last(), Some(&Message::Resign));
        if (upstream || downstream) && participant.net != Tag::FOREVER {
            prop_assert_eq!(end[0], Message::NextEventTag(lf_wire::Tag::FOREVER));
        }
    }

    /// A rejection ends every handshake, whatever its code, unless it may pass.
    #[test]
    fn every_rejection_is_final(code: u8) {
        let mut federate: Federate<'_> = connected(config(&[], DOWNSTREAM));
        let rejected = federate.handle_message(NOW, Message::Reject(RejectCode::from_byte(code)));
        if RejectCode::from_byte(code) == RejectCode::IdInUse {
            prop_assert_eq!((rejected, federate.phase()), (Ok(Event::IdInUse), Phase::Disconnected));
            return Ok(());
        }
        prop_assert!(rejected.is_err());
        prop_assert_eq!((federate.phase(), federate.poll_transmit(usize::MAX)), (Phase::Failed, None));
    }
}
