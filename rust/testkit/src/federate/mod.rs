// SPDX-License-Identifier: Apache-2.0
//! The invariants of a federate's state machine: its output is bounded, it advances to no tag that is not allowed, its
//! grants come from the RTI only, the progress that it announces is monotonic, and an error ends it.
//!
//! Any bytes encode a sequence of steps: a property of `coordination` and the fuzzers choose them.

mod operations;

use arbitrary::{Arbitrary, Unstructured};
use lf_coordination::auth::answer_rti;
use lf_coordination::federate::{ClockSync, Config, Federate, Phase};
use lf_coordination::{Deadline, FederateId, from_wire};
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::{DELAY_NONE, DecodeError, Decoded, Limits, Message, decode};

use operations::Operation;

/// The start time of the federation.
const START: i64 = 1_000;
/// One slot for each kind of message, so that nothing can grow.
const OUTBOX_MAX: usize = 15;

/// A federate, its announcements, and the RTI's grants to it.
struct Watched {
    federate: Federate<'static>,
    has_upstream: bool,
    now: Instant,
    granted: Tag,
    provisional: Option<Tag>,
    completed: Option<Tag>,
    resigned: bool,
}

/// Runs a federate that the first byte chooses, with the rest as bytes from the RTI.
///
/// # Panics
/// If an invariant does not hold.
pub fn federate_raw(data: &[u8]) {
    let [choice, rest @ ..] = data else { return };
    let mut watched = Watched::new(*choice);
    if choice & 64 == 0 {
        watched.federate.handle_connected(Instant::from_nanos(0), [7; 8]);
    } else {
        watched.begin_to_run();
    }
    let limits = Limits { payload_bytes_max: 300, federation_id_bytes_max: 255, neighbors_max: 8 };
    let mut rest = rest;
    while !rest.is_empty() {
        rest = match decode(rest, &limits) {
            Ok(Decoded::Complete { message, len }) => {
                watched.hear(message);
                &rest[len..]
            }
            Err(DecodeError::UnknownType { .. }) => &rest[1..],
            Ok(Decoded::Incomplete { .. }) | Err(_) => return,
        };
    }
}

/// Runs a federate that the first byte chooses, with operations of its event loop and of the RTI.
///
/// # Panics
/// If an invariant does not hold.
pub fn federate_structured(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(choice) = u8::arbitrary(&mut input) else { return };
    let mut watched = Watched::new(choice);
    if choice & 64 != 0 {
        watched.begin_to_run();
    }
    while !input.is_empty() {
        let Ok(pause) = u8::arbitrary(&mut input) else { return };
        let Ok(operation) = Operation::any(&mut input, START) else { return };
        watched.now = watched.now + Interval::from_nanos((pause % 9).into());
        let message = if let Operation::Hear(parts) = &operation { Some(parts.message()) } else { None };
        watched.step(message, |federate, now| operation.act(federate, now));
        if let Operation::Transmit(room) = operation {
            watched.transmit(room);
        }
    }
}

impl Watched {
    fn new(choice: u8) -> Self {
        let mut config = Config::new(FederateId(1), b"federation");
        config.upstream = if choice & 1 != 0 { &[(0, DELAY_NONE), (2, 5)] } else { &[] };
        config.downstream = if choice & 2 != 0 { &[2] } else { &[] };
        config.physical_delay = (choice & 4 != 0).then_some(Interval::from_nanos(if choice & 32 == 0 { 3 } else { 0 }));
        config.advance_interval = Interval::from_nanos(5);
        config.clock_sync = if choice & 8 != 0 { ClockSync::Init { trials: 2 } } else { ClockSync::Off };
        config.authentication = (choice & 16 != 0).then_some(answer_rti);
        let federate = Federate::new(config).expect("the configuration is one that works");
        Self {
            federate,
            has_upstream: choice & 1 != 0,
            now: Instant::from_nanos(START),
            granted: Tag::NEVER,
            provisional: None,
            completed: None,
            resigned: false,
        }
    }

    /// Performs the handshake, as far as that is possible without a secret.
    fn begin_to_run(&mut self) {
        self.federate.handle_connected(Instant::from_nanos(0), [7; 8]);
        self.transmit(usize::MAX);
        for message in [Message::Ack, Message::T1(0), Message::T4(0), Message::T1(0), Message::T4(0)] {
            if matches!(message, Message::T1(_) | Message::T4(_)) && self.federate.phase() != Phase::Synchronizing {
                continue;
            }
            self.hear(message);
        }
        self.hear(Message::Timestamp(START));
    }

    /// Delivers a message of the RTI, and lets the federate transmit its answer.
    fn hear(&mut self, message: Message<'_>) {
        self.step(Some(message), |federate, now| federate.handle_message(now, message).is_ok());
        self.transmit(usize::MAX);
    }

    /// Tracks the RTI's grants.
    fn follow(&mut self, before: &Federate<'_>, message: Message<'_>) {
        if before.phase() != Phase::Running {
            return;
        }
        match message {
            Message::TagGrant(tag) => self.granted = self.granted.max(from_wire(tag)),
            Message::ProvisionalTagGrant(tag) => {
                let tag = from_wire(tag);
                let stops = before.awaits_stop_tag() || before.stop_tag() == Some(tag);
                if stops && tag > before.current() && tag <= before.granted() {
                    self.granted = tag.before();
                    self.provisional = self.provisional.filter(|provisional| *provisional < tag);
                } else {
                    self.granted = self.granted.max(tag.before());
                    self.provisional = self.provisional.max((tag != Tag::FOREVER).then_some(tag));
                }
            }
            _ => {}
        }
    }

    /// Runs a step, perhaps with this message, and asserts the invariants afterwards.
    fn step(&mut self, message: Option<Message<'_>>, act: impl FnOnce(&mut Federate<'static>, Instant) -> bool) {
        let before = self.federate.clone();
        let ok = act(&mut self.federate, self.now);
        if let Some(message) = message {
            self.follow(&before, message);
        }
        let federate = &self.federate;
        let (phase, was) = (federate.phase(), before.phase());
        assert!(ok || phase >= Phase::Ended, "an error is the end");
        assert!(phase >= was || phase <= Phase::Introducing, "from {was:?} back to {phase:?}");
        assert!(was < Phase::Ended || phase == was, "an end is an end");
        assert_eq!(federate.granted(), self.granted, "grants come from the RTI only");
        let demanded = federate.demanded_tag();
        assert!(demanded.is_none_or(|tag| demanded == self.provisional && tag > federate.current()));
        if federate.current() != before.current() {
            assert!(ok && federate.current() > before.current() && before.may_advance(federate.current()));
            let in_cycle = self.provisional == Some(federate.current());
            assert!(!self.has_upstream || federate.current() <= federate.granted() || in_cycle);
            assert!(before.stop_tag().is_none_or(|stop| federate.current() <= stop), "no tag is after the stop tag");
        }
        let mut copy = federate.clone();
        let messages = std::iter::from_fn(|| copy.poll_transmit(usize::MAX)).take(OUTBOX_MAX + 1).count();
        assert!(messages <= OUTBOX_MAX, "{messages} messages are due");
        if let Deadline::At(time) = federate.poll_timeout() {
            let mut copy = federate.clone();
            let _ = copy.handle_timeout(time);
            assert!(!copy.poll_timeout().is_due(time), "a time-out that was handled is over");
        }
    }

    /// Transmits the federate's output, as far as there is room.
    fn transmit(&mut self, mut room: usize) {
        while let Some(message) = self.federate.poll_transmit(room) {
            room -= message.encoded_len();
            assert!(!self.resigned, "{message:?} comes after RESIGN");
            match message {
                Message::LatestTagComplete(tag) => {
                    let tag = Some(from_wire(tag));
                    assert!(tag > self.completed, "what is complete only goes on");
                    self.completed = tag;
                }
                Message::NextEventTag(tag) => {
                    let tag = from_wire(tag);
                    assert!(tag >= self.federate.current(), "the next event {tag:?} is past");
                    assert!(tag == Tag::FOREVER || Some(tag) > self.completed, "the next event {tag:?} is complete");
                }
                Message::Resign => self.resigned = true,
                _ => {}
            }
        }
    }
}
