// SPDX-License-Identifier: Apache-2.0
//! Invariants of the federate's state machine, for any input.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use std::collections::BTreeSet;

use lf_coordination::federate::{ClockSync, Config, Event, Federate, Phase};
use lf_coordination::{Deadline, FederateId, from_wire, to_wire};
use lf_model::time::{Instant, Interval, Microstep, Tag};
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, RejectCode, decode};
use proptest::collection::vec;
use proptest::prelude::*;

const START: i64 = 1_000;
/// One place per kind of control message, so that nothing can grow.
const OUTBOX_MAX: usize = 11;

fn config(upstream: bool, downstream: bool, physical: Option<i64>, sync: bool) -> Config<'static> {
    let mut config = Config::new(FederateId(1), b"federation");
    config.upstream = if upstream { &[(0, DELAY_NONE)] } else { &[] };
    config.downstream = if downstream { &[2] } else { &[] };
    config.physical_delay = physical.map(Interval::from_nanos);
    config.advance_interval = Interval::from_nanos(5);
    config.clock_sync = if sync { ClockSync::Init { trials: 2 } } else { ClockSync::Off };
    config
}

/// Anything that an event loop or a peer can do.
#[derive(Clone, Debug)]
enum Deed {
    Connected,
    Disconnected,
    Bytes(Vec<u8>),
    Tagged(u8, Tag),
    Time(u8, i64),
    Timeout,
    Written,
    Transmit(usize),
    NextEvent(Tag),
    Begin(Tag),
    Complete(bool),
    Sent,
    RequestStop(Tag),
    LimitStop(Tag),
    Finish,
    Fail,
}

fn any_tag() -> impl Strategy<Value = Tag> {
    let near =
        (START - 2..START + 60, 0..3u32).prop_map(|(time, step)| Tag::new(Instant::from_nanos(time), Microstep(step)));
    let any = any::<(i64, u32)>().prop_map(|(time, step)| Tag::new(Instant::from_nanos(time), Microstep(step)));
    prop_oneof![8 => near, 1 => any, 1 => Just(Tag::FOREVER), 1 => Just(Tag::NEVER)]
}

fn any_deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        1 => Just(Deed::Connected),
        1 => vec(any::<u8>(), 0..40).prop_map(Deed::Bytes),
        8 => (0..10u8, any_tag()).prop_map(|(kind, tag)| Deed::Tagged(kind, tag)),
        2 => (0..3u8, any::<i64>()).prop_map(|(kind, time)| Deed::Time(kind, time)),
        2 => Just(Deed::Timeout),
        2 => Just(Deed::Written),
        4 => (0..60usize).prop_map(Deed::Transmit),
        8 => any_tag().prop_map(Deed::NextEvent),
        8 => any_tag().prop_map(Deed::Begin),
        4 => any::<bool>().prop_map(Deed::Complete),
        2 => Just(Deed::Sent),
        1 => any_tag().prop_map(Deed::RequestStop),
        1 => any_tag().prop_map(Deed::LimitStop),
        1 => prop_oneof![Just(Deed::Finish), Just(Deed::Fail), Just(Deed::Disconnected)],
    ]
}

fn message(kind: u8, tag: Tag) -> Message<'static> {
    let tag = to_wire(tag);
    match kind {
        0 => Message::ProvisionalTagGrant(tag),
        1 => Message::DownstreamNextEventTag(tag),
        2 => Message::StopRequest(tag),
        3 => Message::StopGranted(tag),
        4 => Message::PortAbsent { port: 0, federate: 1, tag },
        5 => Message::TaggedMessage { port: 0, federate: 1, tag, payload: b"payload" },
        _ => Message::TagGrant(tag),
    }
}

/// Returns the tags that this deed grants for certain and provisionally, if it is a grant.
fn grant(deed: &Deed) -> Option<(Tag, Option<Tag>)> {
    let provisional = |tag: Tag| (tag.before(), Some(tag));
    match deed {
        Deed::Tagged(0, tag) => Some(provisional(*tag)),
        Deed::Tagged(6.., tag) => Some((*tag, None)),
        Deed::Bytes(bytes) => match decode(bytes, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::TagGrant(tag), .. }) => Some((from_wire(tag), None)),
            Ok(Decoded::Complete { message: Message::ProvisionalTagGrant(tag), .. }) => {
                Some(provisional(from_wire(tag)))
            }
            _ => None,
        },
        _ => None,
    }
}

/// Does one deed. Returns false when the caller of the state machine would have to stop because of an error.
fn act(federate: &mut Federate<'_>, now: Instant, deed: &Deed) -> bool {
    let handle = |federate: &mut Federate<'_>, message| federate.handle_message(now, message).is_ok();
    match deed {
        Deed::Connected => federate.handle_connected(now, [0; 8]),
        Deed::Disconnected => return federate.handle_disconnected().is_ok(),
        Deed::Bytes(bytes) => {
            if let Ok(Decoded::Complete { message, .. }) = decode(bytes, &Limits::NONE) {
                return handle(federate, message);
            }
        }
        Deed::Tagged(kind, tag) => return handle(federate, message(*kind, *tag)),
        Deed::Time(kind, time) => {
            let messages = [Message::T1(*time), Message::T4(*time), Message::Timestamp(*time)];
            return handle(federate, messages[usize::from(*kind)]);
        }
        Deed::Timeout => return federate.handle_timeout(now).is_ok(),
        Deed::Written => federate.handle_written(now),
        Deed::Transmit(room) => drop(federate.poll_transmit(*room)),
        Deed::NextEvent(tag) => drop(federate.next_event(now, *tag)),
        Deed::Begin(tag) => return federate.begin(*tag).is_ok(),
        Deed::Complete(input) => federate.complete(*input),
        Deed::Sent => federate.sent(),
        Deed::RequestStop(tag) => federate.request_stop(*tag),
        Deed::LimitStop(tag) => federate.limit_stop(*tag),
        Deed::Finish => federate.finish(),
        Deed::Fail => federate.fail(),
    }
    true
}

/// The deeds that lead to the start.
fn start(federate: &mut Federate<'_>, sync: bool) {
    let drain = |federate: &mut Federate<'_>| while federate.poll_transmit(usize::MAX).is_some() {};
    federate.handle_connected(Instant::from_nanos(0), [0; 8]);
    drain(federate);
    federate.handle_message(Instant::from_nanos(0), Message::Ack).unwrap();
    drain(federate);
    for _ in 0..if sync { 2 } else { 0 } {
        federate.handle_message(Instant::from_nanos(0), Message::T1(0)).unwrap();
        drain(federate);
        federate.handle_message(Instant::from_nanos(0), Message::T4(0)).unwrap();
        drain(federate);
    }
    assert_eq!(
        federate.handle_message(Instant::from_nanos(0), Message::Timestamp(START)),
        Ok(Event::Started(Instant::from_nanos(START)))
    );
}

proptest! {
    /// No sequence of deeds and messages, sensible or not, makes the state machine panic, makes more output than it has
    /// slots for, lets a tag begin that was not granted or lies after the stop tag, or brings it back from its end.
    #[test]
    fn nothing_breaks_it(
        (upstream, downstream, sync, started) in any::<(bool, bool, bool, bool)>(),
        physical in proptest::option::of(0..20i64),
        deeds in vec((any_deed(), 0..9i64), 0..80),
    ) {
        let mut federate = Federate::new(config(upstream, downstream, physical, sync)).unwrap();
        if started {
            start(&mut federate, sync);
        }
        let (mut granted, mut provisional, mut now) = (Tag::NEVER, None, Instant::from_nanos(START));
        for (deed, pause) in &deeds {
            now = now + Interval::from_nanos(*pause);
            let before = (federate.phase(), federate.current(), federate.stop_tag());
            let stops = |tag| federate.awaits_stop_tag() || federate.stop_tag() == Some(tag);
            let takes_back = |tag| stops(tag) && tag > federate.current() && tag <= federate.granted();
            let revoked = grant(deed).and_then(|(_, cycle)| cycle.filter(|tag| takes_back(*tag)));
            let ok = act(&mut federate, now, deed);
            if let (Some(tag), Phase::Running) = (revoked, before.0) {
                granted = tag.before();
                provisional = provisional.filter(|provisional| *provisional < tag);
            } else if let (Some((tag, cycle)), Phase::Running) = (grant(deed), before.0) {
                granted = granted.max(tag);
                provisional = provisional.max(cycle.filter(|tag| *tag != Tag::FOREVER));
            }
            let demanded = federate.demanded_tag();
            prop_assert!(demanded.is_none_or(|tag| Some(tag) == provisional && tag > federate.current()));
            prop_assert_eq!(federate.granted(), granted, "grants come from the RTI only");
            if federate.current() != before.1 {
                prop_assert!(ok && matches!(deed, Deed::Begin(_)) && federate.current() > before.1);
                let in_cycle = provisional == Some(federate.current());
                prop_assert!(!upstream || federate.current() <= federate.granted() || in_cycle);
                prop_assert!(before.2.is_none_or(|stop| federate.current() <= stop));
            }
            prop_assert!(ok || federate.phase() >= Phase::Ended);
            prop_assert!(federate.phase() >= before.0 || federate.phase() == Phase::Disconnected);
            if before.0 >= Phase::Ended {
                prop_assert_eq!(federate.phase(), before.0);
            }
            let mut copy = federate.clone();
            let messages = std::iter::from_fn(|| copy.poll_transmit(usize::MAX)).take(OUTBOX_MAX + 1).count();
            prop_assert!(messages <= OUTBOX_MAX);
            if let Deadline::At(time) = federate.poll_timeout() {
                // A time-out that was handled does not come again at once.
                let mut copy = federate.clone();
                let _ = copy.handle_timeout(time);
                prop_assert!(!copy.poll_timeout().is_due(time), "{:?} again at {:?}", copy.poll_timeout(), time);
            }
        }
    }

    /// Bytes from the RTI, cut anywhere: whatever decodes is handled or refused, and refused for good.
    #[test]
    fn random_bytes_are_survived(started: bool, bytes in vec(prop_oneof![0..27u8, any::<u8>()], 0..400)) {
        let mut federate = Federate::new(config(true, true, None, true)).unwrap();
        if started { start(&mut federate, true) } else { federate.handle_connected(Instant::from_nanos(0), [0; 8]) }
        let mut rest = &bytes[..];
        while let Some(tail) = rest.get(1..) {
            rest = match decode(rest, &Limits { payload_bytes_max: 64, ..Limits::NONE }) {
                Ok(Decoded::Complete { message, len }) => {
                    let failed = federate.handle_message(Instant::from_nanos(0), message).is_err();
                    prop_assert!(!failed || federate.phase() == Phase::Failed);
                    &rest[len..]
                }
                _ => tail,
            };
        }
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
        let mut federate = Federate::new(config(upstream, downstream, None, false)).unwrap();
        start(&mut federate, false);
        let first = Tag::at(Instant::from_nanos(START));
        federate.next_event(Instant::from_nanos(0), first);
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
        let current = self.federate.current().max(Tag::at(Instant::from_nanos(START)));
        let after = |tag: Tag, ns: i64| Tag::at(tag.time + Interval::from_nanos(ns));
        let granted = self.federate.granted().max(Tag::at(Instant::from_nanos(START)).before());
        match *turn {
            Turn::Grant(ns) if self.upstream => self.handle(Message::TagGrant(to_wire(after(granted, ns)))),
            Turn::Message(ns) if self.upstream => {
                let tag = after(granted.max(current), ns);
                let message = Message::TaggedMessage { port: 0, federate: 1, tag: to_wire(tag), payload: &[] };
                assert_eq!(
                    self.federate.handle_message(Instant::from_nanos(0), message),
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
        self.federate.next_event(Instant::from_nanos(0), self.next());
    }

    fn handle(&mut self, message: Message<'_>) {
        self.federate.handle_message(Instant::from_nanos(0), message).unwrap();
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
        let mut federate = Federate::new(config(false, true, None, true)).unwrap();
        federate.handle_connected(Instant::from_nanos(0), [0; 8]);
        let rejected = federate.handle_message(Instant::from_nanos(0), Message::Reject(RejectCode::from_byte(code)));
        if RejectCode::from_byte(code) == RejectCode::IdInUse {
            prop_assert_eq!((rejected, federate.phase()), (Ok(Event::IdInUse), Phase::Disconnected));
            return Ok(());
        }
        prop_assert!(rejected.is_err());
        prop_assert_eq!((federate.phase(), federate.poll_transmit(usize::MAX)), (Phase::Failed, None));
    }
}
