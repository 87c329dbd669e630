// SPDX-License-Identifier: Apache-2.0
//! Derives bounds from the recordings of federates with decentralized coordination.
//!
//! The receiver, its input and the tag identify a message at both ends, so the latencies contain the differences of the
//! clocks. A lag is the time from the earliest possible begin of a tag to a message of it; a wait within the tag counts
//! as part of it, which is the safe side.

use std::collections::BTreeMap;

use lf_compiler::maxwait::{Bounds, FederateBounds};
use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{Event, MessageType, Role, TracedMessage};

use super::clock::Clock;
use super::names::{self, TraceNames};
use super::read::Recorded;
use crate::failure::Failure;

/// A message: the receiver, its input and the tag.
type MessageKey = (u16, u16, Tag);

/// The results of a run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Measured {
    /// The measured bounds.
    pub(crate) bounds: Bounds,
    /// The number of messages that were seen at both ends.
    pub(crate) messages: usize,
}

impl Measured {
    /// Returns the file of bounds.
    pub(crate) fn to_yaml(&self, names: &TraceNames) -> String {
        format!(
            "# The longest latencies and lags in a run of {} with {} messages. Another run may take longer.\n\
             # The latencies contain the differences of the clocks.\n{}",
            names.program,
            self.messages,
            self.bounds.to_yaml()
        )
    }
}

/// Returns the measurements from the traces of federates.
///
/// # Errors
/// When they cannot be read.
pub(crate) fn measure(all: &[Recorded], names: &TraceNames) -> Result<Measured, Failure> {
    let (mut messages, mut bounds) = (Messages::default(), Bounds { clock_error_ns: Some(0), ..Bounds::default() });
    for recorded in all {
        let Role::Federate(id) = recorded.header.role else { continue };
        names::of_participant(names, &recorded.header).map_err(|reason| recorded.wrong(&reason))?;
        let mut clock = Clock::default();
        recorded.for_each(|record| clock.take(&record))?;
        let mut federate = Watched::new(id, &mut messages);
        recorded.in_order(|record| clock.time(record.at.as_nanos()), |at, event| federate.take(at, event))?;
        federate.add_to(&mut bounds, names);
    }
    Ok(messages.combine(bounds, names))
}

/// The times at which all federates sent and received their messages.
#[derive(Debug, Default)]
struct Messages {
    sent: BTreeMap<MessageKey, i64>,
    received: BTreeMap<MessageKey, i64>,
}

impl Messages {
    /// Adds the longest latencies.
    fn combine(&self, mut bounds: Bounds, names: &TraceNames) -> Measured {
        let mut messages = 0;
        for (message, received_at) in &self.received {
            // A message that was lost with a failed federate has no other end.
            let (Some(sent_at), (to, port, _)) = (self.sent.get(message), message) else { continue };
            let inputs = names.federates.get(usize::from(*to)).map_or(&[][..], |found| &found.inputs);
            let Some(input) = inputs.iter().find(|input| input.port == *port) else { continue };
            messages += 1;
            let longest = bounds.connections.entry(input.name.clone()).or_default();
            *longest = (*longest).max(received_at.saturating_sub(*sent_at).max(0));
        }
        Measured { bounds, messages }
    }
}

/// A federate, whose events arrive in order.
struct Watched<'a> {
    id: u16,
    messages: &'a mut Messages,
    /// The earliest time at which the next tag could begin, as far as that depends on clocks.
    due: Option<i64>,
    /// The earliest time at which the open tag could have begun.
    since: Option<i64>,
    /// The arrival of the first message for each tag that has not begun.
    causes: BTreeMap<Tag, i64>,
    /// The longest time from the earliest possible begin of a tag to a message of it.
    lag_ns: Option<i64>,
}

impl<'a> Watched<'a> {
    fn new(id: u16, messages: &'a mut Messages) -> Self {
        Self { id, messages, due: None, since: None, causes: BTreeMap::new(), lag_ns: None }
    }

    /// Handles an event at this time of the federation.
    fn take(&mut self, at: i64, event: Event) {
        match event {
            Event::Due(time) => self.due = Some(time.as_nanos()),
            Event::TagBegins(tag) => {
                if let Some(due) = self.due.take() {
                    self.since = Some(self.causes.get(&tag).map_or(due, |came| due.max(*came)));
                    self.causes = self.causes.split_off(&tag);
                }
            }
            Event::Sent(message) => {
                if let Some(key) = key(&message) {
                    self.messages.sent.insert(key, at);
                    let lag = self.since.map_or(0, |since| at.saturating_sub(since));
                    self.lag_ns = self.lag_ns.max(Some(lag.max(0)));
                }
            }
            // A message that waits for room arrived when it was first recorded.
            Event::Held(message) | Event::Received(message) => {
                if let Some(key @ (_, _, tag)) = key(&message) {
                    self.messages.received.entry(key).or_insert(at);
                    self.causes.entry(tag).or_insert(at);
                }
            }
            _ => {}
        }
    }

    /// Adds the longest lag.
    fn add_to(self, bounds: &mut Bounds, names: &TraceNames) {
        if self.lag_ns.is_some() {
            let known = FederateBounds { clock_error_ns: None, lag_ns: self.lag_ns };
            bounds.federates.insert(names::name(names, Role::Federate(self.id)), known);
        }
    }
}

/// Returns the key of a value that was sent to another federate without the RTI.
fn key(message: &TracedMessage) -> Option<MessageKey> {
    let (to, port) = message.to;
    message.tag.filter(|_| message.kind == MessageType::P2pTaggedMessage).map(|tag| (to, port, tag))
}

#[cfg(test)]
mod tests {
    use lf_compiler::plan::Plan;
    use lf_compiler::{SourceProvider, compile};
    use lf_linux::model::time::Instant;

    use super::*;

    struct One(&'static str);

    impl SourceProvider for One {
        fn read(&self, _: &str) -> Result<String, String> {
            Ok(self.0.to_owned())
        }
    }

    fn plan() -> Plan {
        let text = "target Rust { coordination: decentralized }
            reactor Source { output y: u32 timer t(0, 10 ms) reaction(t) -> y {= =} }
            reactor Sink { input x: u32 reaction(x) {= =} }
            federated reactor { a = new Source() b = new Sink() a.y -> b.x }";
        compile("Program.lf", &One(text)).plan.expect("it is right")
    }

    fn ns(time: i64) -> Tag {
        Tag::at(Instant::from_nanos(time))
    }

    fn due(time: i64) -> Event {
        Event::Due(Instant::from_nanos(time))
    }

    /// Returns a value for the input of the second federate.
    fn value(tag: i64) -> TracedMessage {
        TracedMessage { kind: MessageType::P2pTaggedMessage, peer: 0, to: (1, 0), tag: Some(ns(tag)), bytes: 4 }
    }

    fn watch(id: u16, messages: &mut Messages, events: &[(i64, Event)]) -> Option<i64> {
        let mut federate = Watched::new(id, messages);
        for (at, event) in events {
            federate.take(*at, *event);
        }
        federate.lag_ns
    }

    #[test]
    fn the_longest_of_each_is_the_bound() {
        let names = TraceNames::of(&plan());
        let (mut messages, mut bounds) = (Messages::default(), Bounds { clock_error_ns: Some(0), ..Bounds::default() });
        let mut source = Watched::new(0, &mut messages);
        let first = [(105, due(100)), (105, Event::TagBegins(ns(100))), (110, Event::Sent(value(100)))];
        let second = [(201, due(200)), (201, Event::TagBegins(ns(200))), (203, Event::Sent(value(200)))];
        first.into_iter().chain(second).for_each(|(at, event)| source.take(at, event));
        source.add_to(&mut bounds, &names);
        let held = [(150, Event::Held(value(100))), (180, Event::Received(value(100)))];
        watch(1, &mut messages, &[held[0], held[1], (210, Event::Received(value(200)))]);
        let measured = messages.combine(bounds, &names);
        assert_eq!(measured.messages, 2);
        assert_eq!(measured.bounds.connections, BTreeMap::from([("a.y -> b.x".to_owned(), 40)]));
        assert_eq!(measured.bounds.federates["a"].lag_ns, Some(10));
        let read = Bounds::parse("bounds.yaml", &measured.to_yaml(&names), &plan());
        assert_eq!(read, Ok(measured.bounds));
    }

    /// A tag with a message cannot begin before the message arrives, but one that only waited could.
    #[test]
    fn lags_count_from_where_a_tag_could_begin() {
        let begin = |due_at| [(151, due(due_at)), (151, Event::TagBegins(ns(100))), (153, Event::Sent(value(100)))];
        let watch = |tag, due_at| {
            let came = [(150, Event::Received(value(tag)))];
            watch(0, &mut Messages::default(), &[&came[..], &begin(due_at)].concat())
        };
        assert_eq!(watch(100, 100), Some(3));
        assert_eq!(watch(300, 120), Some(33));
    }
}
