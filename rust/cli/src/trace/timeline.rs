// SPDX-License-Identifier: Apache-2.0
//! Converts the records of a participant to intervals and messages on the time axis of the federation.

use std::collections::BTreeMap;

use lf_linux::model::Part;
use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{Event, MessageType, Record, TracedMessage, Waits};

use super::clock::Clock;
use super::names::TracedFederate;
use super::read::Recorded;
use crate::failure::Failure;

/// The timeline of a participant. Each pass derives it from the records again, because they can be many.
#[derive(Debug)]
pub(crate) struct Timeline<'a> {
    recorded: &'a Recorded,
    pub(crate) name: String,
    pub(crate) is_rti: bool,
    /// The id of the federate.
    pub(crate) id: Option<u16>,
    pub(crate) names: Option<&'a TracedFederate>,
    /// The times of the first and the last record.
    pub(crate) span: (i64, i64),
    /// The start time of the federation.
    pub(crate) start: Option<i64>,
    /// The number of missing records before the first.
    pub(crate) lost: u64,
    /// The number of workers that have run reactions.
    pub(crate) workers: u16,
    clock: Clock,
    /// Whether the program does not wait for the time of tags.
    fast: bool,
}

/// An element of a timeline.
#[derive(Debug)]
pub(crate) enum TimelineElement {
    Slice(Slice),
    Message(MessageMark),
}

/// An interval.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slice {
    pub(crate) begin: i64,
    pub(crate) end: i64,
    pub(crate) what: SliceKind,
    /// Whether the participant ended in the middle of it.
    pub(crate) is_open: bool,
}

/// The kind of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SliceKind {
    Tag(Tag),
    /// A reaction: its number, its part, its worker, and its tag.
    Reaction(u16, Part, u16, Option<Tag>),
    Waits(Waits),
}

/// A sent or received message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MessageMark {
    pub(crate) at: i64,
    pub(crate) sent: bool,
    pub(crate) message: TracedMessage,
}

impl Slice {
    pub(crate) fn length(&self) -> i64 {
        self.end - self.begin
    }
}

impl<'a> Timeline<'a> {
    /// Scans the records of a participant for the properties that all later passes need.
    ///
    /// # Errors
    /// When they cannot be read.
    pub(crate) fn of(
        recorded: &'a Recorded,
        name: String,
        id: Option<u16>,
        names: Option<&'a TracedFederate>,
    ) -> Result<Self, Failure> {
        let (mut clock, mut start, mut fast, mut lost, mut workers) = (Clock::default(), None, false, 0, 0);
        let mut own = None;
        recorded.for_each(|record| {
            clock.take(&record);
            let at = record.at.as_nanos();
            let (begin, end) = own.unwrap_or((at, at));
            own = Some((at.min(begin), at.max(end)));
            match record.event {
                Event::Starts(time, is_fast) => (start, fast) = (Some(time.as_nanos()), is_fast),
                Event::Lost(count) => lost = count + recorded.overwritten(),
                Event::ReactionBegins(_, _, worker) => workers = workers.max(worker),
                _ => {}
            }
        })?;
        let span = own.map_or((0, 0), |(begin, end)| (clock.time(begin), clock.time(end)));
        let is_rti = recorded.is_rti();
        Ok(Self { recorded, name, is_rti, id, names, span, start, lost, workers, clock, fast })
    }

    /// Calls `found` with all intervals and messages, each when it ends.
    ///
    /// # Errors
    /// When the records cannot be read.
    pub(crate) fn for_each(&self, found: &mut dyn FnMut(TimelineElement)) -> Result<(), Failure> {
        let mut builder = TimelineBuilder { open: BTreeMap::new(), tag: None, fast: self.fast, found };
        let time = |record: &Record| self.clock.time(record.at.as_nanos());
        self.recorded.in_order(time, |at, event| builder.take(at, event))?;
        builder.end(self.span.1);
        Ok(())
    }

    /// Returns the name of an input.
    pub(crate) fn input(&self, input: u16) -> String {
        let found = self.names.and_then(|names| names.inputs.get(usize::from(input)));
        found.map_or_else(|| format!("input {input}"), |input| input.name.clone())
    }

    /// Returns the name of a reaction, and its place in the source.
    pub(crate) fn reaction(&self, reaction: u16) -> (String, Option<&str>) {
        let found = self.names.and_then(|names| names.reactions.get(usize::from(reaction)));
        found.map_or_else(
            || (format!("reaction {reaction}"), None),
            |reaction| (reaction.name.clone(), reaction.at.as_deref()),
        )
    }
}

/// The tracks, on each of which one interval at a time can be open.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Track {
    Tag,
    Reaction(u16),
    Wait,
}

/// Returns whether a message is drawn: one with a tag, with a value, or about the end of a participant.
fn is_shown(message: &TracedMessage) -> bool {
    message.tag.is_some() || message.is_value() || matches!(message.kind, MessageType::Resign | MessageType::Failed)
}

struct TimelineBuilder<'a> {
    open: BTreeMap<Track, (i64, SliceKind)>,
    tag: Option<Tag>,
    fast: bool,
    found: &'a mut dyn FnMut(TimelineElement),
}

impl TimelineBuilder<'_> {
    fn take(&mut self, at: i64, event: Event) {
        match event {
            Event::TagBegins(tag) => {
                self.tag = Some(tag);
                self.begin(Track::Tag, at, SliceKind::Tag(tag));
            }
            Event::TagEnds(_) => {
                self.close(Track::Tag, at, false);
                self.tag = None;
            }
            Event::ReactionBegins(reaction, part, worker) => {
                self.begin(Track::Reaction(worker), at, SliceKind::Reaction(reaction, part, worker, self.tag));
            }
            Event::ReactionEnds(_, worker) => self.close(Track::Reaction(worker), at, false),
            Event::WaitBegins(waits) => self.begin(Track::Wait, at, SliceKind::Waits(waits)),
            Event::WaitEnds => self.close(Track::Wait, at, false),
            // The messages of the handshake and of clock synchronization are not drawn.
            Event::Sent(message) | Event::Received(message) if !is_shown(&message) => {}
            Event::Sent(message) => (self.found)(TimelineElement::Message(MessageMark { at, sent: true, message })),
            Event::Received(message) => {
                (self.found)(TimelineElement::Message(MessageMark { at, sent: false, message }));
            }
            Event::Begins(_)
            | Event::Clock(_)
            | Event::Starts(..)
            | Event::Due(_)
            | Event::Physical(_)
            | Event::Held(_)
            | Event::Data(_)
            | Event::Ends(_)
            | Event::Lost(_)
            | Event::Seam => {}
        }
    }

    fn begin(&mut self, place: Track, at: i64, what: SliceKind) {
        // An open interval ends where the next one begins; its own end was not recorded.
        self.close(place, at, true);
        self.open.insert(place, (at, what));
    }

    /// Ends the open interval of a track, if there is one: a ring may have lost the beginning.
    fn close(&mut self, place: Track, end: i64, is_open: bool) {
        let Some((begin, what)) = self.open.remove(&place) else { return };
        let due = match what {
            SliceKind::Waits(Waits::Grant(tag) | Waits::Input(tag, ..)) if !self.fast => Some(tag),
            _ => None,
        };
        // Before the time of its tag a participant would wait in any case.
        let mut begin = begin;
        if let Some(tag) = due.filter(|tag| tag.time.as_nanos() > begin) {
            let until = tag.time.as_nanos().min(end);
            self.slice(Slice { begin, end: until, what: SliceKind::Waits(Waits::Time(tag)), is_open: false });
            begin = until;
        }
        if due.is_none() || begin < end {
            self.slice(Slice { begin, end, what, is_open });
        }
    }

    fn slice(&mut self, slice: Slice) {
        (self.found)(TimelineElement::Slice(slice));
    }

    fn end(&mut self, at: i64) {
        while let Some((place, _)) = self.open.first_key_value() {
            self.close(*place, at, true);
        }
    }
}
