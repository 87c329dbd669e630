// SPDX-License-Identifier: Apache-2.0
//! A federate with a small program and a virtual clock, driven as an event loop would drive it.

pub(crate) mod dialogue;

use std::collections::{BTreeMap, VecDeque};

use lf_coordination::federate::{Config, Event, Federate, FederateError, Phase};
use lf_coordination::to_wire;
use lf_model::time::{Instant, Interval, Tag};
use lf_testkit::messages::encoded;
use lf_wire::{Decoded, Limits, Message, decode};

/// The federate's program; the recordings describe it in words.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Program {
    /// A timer with offset 0 and period 100 ms; the firings that `sends` accepts send their number (int32: 1, 2, …) to
    /// federate 1, port 0, without `after`; firing `stops` first requests a stop.
    Source { sends: fn(i32) -> bool, stops: Option<i32> },
    /// A reaction to an input from federate 0; keepalive.
    Sink,
}

/// The nonce by which the federate authenticates.
pub(crate) const NONCE: [u8; 8] = *b"a nonce!";

const PERIOD_NS: i64 = 100_000_000;

/// The driver: state machine, program, and a clock that only moves when the federate has nothing else to do.
pub(crate) struct Driver<'a> {
    pub(crate) federate: Federate<'a>,
    program: Program,
    time_out: Interval,
    /// The federate's own clock.
    pub(crate) now: Instant,
    /// Messages of the federate that the test has not read yet, each as bytes.
    pub(crate) out: VecDeque<Vec<u8>>,
    /// Tags at which an input is present.
    inputs: BTreeMap<Tag, Vec<u8>>,
    fired: i32,
    /// The federate's last error.
    pub(crate) error: Option<FederateError>,
}

impl<'a> Driver<'a> {
    pub(crate) fn new(config: Config<'a>, program: Program, time_out: Interval, now: Instant) -> Self {
        let federate = Federate::new(config).unwrap();
        let (out, inputs) = (VecDeque::new(), BTreeMap::new());
        Self { federate, program, time_out, now, out, inputs, fired: 0, error: None }
    }

    pub(crate) fn connect(&mut self) {
        self.federate.handle_connected(self.now, NONCE);
        self.transmit();
    }

    /// Passes the federate these bytes, which are complete messages.
    pub(crate) fn receive(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let Decoded::Complete { message, len } = decode(bytes, &Limits::NONE).unwrap() else {
                panic!("a message is cut: {bytes:?}")
            };
            self.handle(message);
            bytes = &bytes[len..];
        }
    }

    fn handle(&mut self, message: Message<'_>) {
        match self.federate.handle_message(self.now, message) {
            Ok(Event::Started(start)) => self.federate.limit_stop(Tag::at(start + self.time_out)),
            Ok(Event::Message { tag, payload, port }) => {
                assert_eq!(port, 0);
                self.inputs.insert(tag, payload.to_vec());
            }
            Ok(_) => {}
            Err(error) => self.error = Some(error),
        }
        self.transmit();
        if self.federate.phase() == Phase::Running {
            self.federate.next_event(self.now, self.next_tag());
            self.transmit();
        }
    }

    /// Returns the program's next event, not looking beyond the time-out.
    fn next_tag(&self) -> Tag {
        let start = self.federate.start_time().unwrap();
        let stop = Tag::at(start + self.time_out).min(self.federate.stop_tag().unwrap_or(Tag::FOREVER));
        let next = match self.program {
            Program::Source { .. } => Tag::at(start + Interval::from_nanos(i64::from(self.fired) * PERIOD_NS)),
            Program::Sink => {
                // The start is an event of every program.
                let first = (self.federate.current() == Tag::NEVER).then_some(Tag::at(start));
                first.or(self.inputs.keys().next().copied()).unwrap_or(Tag::FOREVER)
            }
        };
        next.min(stop)
    }

    /// Runs the next tag, if it may begin before `until`; returns whether it did.
    pub(crate) fn step(&mut self, until: Instant) -> bool {
        if self.federate.phase() != Phase::Running {
            return false;
        }
        let tag = self.next_tag();
        let due = self.federate.clock().local(tag.time);
        if !self.federate.next_event(self.now, tag) || due > until {
            return false;
        }
        self.now = self.now.max(due);
        self.federate.begin(tag).unwrap();
        let input = self.inputs.remove(&tag).is_some();
        self.fire(tag);
        self.federate.complete(input);
        self.transmit();
        let last = tag == Tag::at(self.federate.start_time().unwrap() + self.time_out);
        if last || Some(tag) == self.federate.stop_tag() {
            self.federate.finish();
        } else {
            self.federate.next_event(self.now, self.next_tag());
        }
        self.transmit();
        true
    }

    /// Fires the timer of the source, if it is due at this tag.
    fn fire(&mut self, tag: Tag) {
        let Program::Source { sends, stops } = self.program else { return };
        let start = self.federate.start_time().unwrap();
        if tag != Tag::at(start + Interval::from_nanos(i64::from(self.fired) * PERIOD_NS)) {
            return;
        }
        self.fired += 1;
        if Some(self.fired) == stops {
            self.federate.request_stop(tag.next_microstep());
            self.transmit();
        }
        if sends(self.fired) && self.federate.may_send(tag) {
            let payload = self.fired.to_le_bytes();
            self.push(&Message::TaggedMessage { port: 0, federate: 1, tag: to_wire(tag), payload: &payload });
            self.federate.sent();
        }
    }

    fn transmit(&mut self) {
        while let Some(message) = self.federate.poll_transmit(usize::MAX) {
            self.push(&message);
        }
        self.federate.handle_written(self.now);
    }

    fn push(&mut self, message: &Message<'_>) {
        self.out.push_back(encoded(message));
    }
}
