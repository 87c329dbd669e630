// SPDX-License-Identifier: Apache-2.0
//! From the records of a participant to what lasted from when until when, on the time axis of the federation.

use std::collections::BTreeMap;

use lf_linux::model::Part;
use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{Event, Waits, Word};

use super::clock::Clock;
use super::names::Participant;
use super::read::Recorded;

/// What a participant did.
#[derive(Debug)]
pub(crate) struct Story<'a> {
    pub(crate) name: String,
    pub(crate) is_rti: bool,
    /// The federate's number.
    pub(crate) id: Option<u16>,
    pub(crate) names: Option<&'a Participant>,
    pub(crate) slices: Vec<Slice>,
    pub(crate) marks: Vec<Mark>,
    /// From the first to the last record.
    pub(crate) span: (i64, i64),
    /// The start of the federation.
    pub(crate) start: Option<i64>,
    /// How many records are missing before the first.
    pub(crate) lost: u64,
}

/// Something that lasts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slice {
    pub(crate) begin: i64,
    pub(crate) end: i64,
    pub(crate) what: What,
    /// The participant has ended in the middle of it.
    pub(crate) is_open: bool,
}

/// What it is that lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum What {
    Tag(Tag),
    /// A reaction by its number, what of it, in which worker, and at which tag.
    Reaction(u16, Part, u16, Option<Tag>),
    Waits(Waits),
}

/// A message that goes or comes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mark {
    pub(crate) at: i64,
    pub(crate) sent: bool,
    pub(crate) word: Word,
    /// The arrow that begins, goes on or ends here, and whether it ends.
    pub(crate) arrow: Option<(u64, bool)>,
}

impl Slice {
    pub(crate) fn length(&self) -> i64 {
        self.end - self.begin
    }
}

impl<'a> Story<'a> {
    /// Puts the records of a participant together.
    pub(crate) fn of(recorded: &Recorded, name: String, id: Option<u16>, names: Option<&'a Participant>) -> Self {
        let clock = Clock::of(&recorded.records);
        let mut records: Vec<_> =
            recorded.records.iter().map(|record| (clock.time(record.at.as_nanos()), record.event)).collect();
        // What workers did is recorded when all have ended.
        records.sort_by_key(|(at, _)| *at);
        let is_rti = recorded.is_rti();
        let span = (records.first().map_or(0, |(at, _)| *at), records.last().map_or(0, |(at, _)| *at));
        let mut teller = Teller {
            open: BTreeMap::new(),
            tag: None,
            fast: false,
            slices: Vec::new(),
            marks: Vec::new(),
            start: None,
            lost: 0,
        };
        // A ring keeps the start, whatever it has lost.
        for (_, event) in &records {
            if let Event::Starts(time, fast) = event {
                (teller.start, teller.fast) = (Some(time.as_nanos()), *fast);
            }
        }
        for (at, event) in records {
            teller.take(at, event);
        }
        teller.end(span.1);
        let Teller { slices, marks, start, lost, .. } = teller;
        Self { name, is_rti, id, names, slices, marks, span, start, lost }
    }

    /// The name of an input.
    pub(crate) fn input(&self, input: u16) -> String {
        let found = self.names.and_then(|names| names.inputs.get(usize::from(input)));
        found.map_or_else(|| format!("input {input}"), |input| input.name.clone())
    }

    /// The name of a reaction, and where it stands.
    pub(crate) fn reaction(&self, reaction: u16) -> (String, Option<&str>) {
        let found = self.names.and_then(|names| names.reactions.get(usize::from(reaction)));
        found.map_or_else(
            || (format!("reaction {reaction}"), None),
            |reaction| (reaction.name.clone(), reaction.at.as_deref()),
        )
    }
}

/// The places at which one thing at a time can last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Track {
    Tag,
    Reaction(u16),
    Wait,
}

struct Teller {
    open: BTreeMap<Track, (i64, What)>,
    tag: Option<Tag>,
    /// Nobody waits for the time of tags.
    fast: bool,
    slices: Vec<Slice>,
    marks: Vec<Mark>,
    start: Option<i64>,
    lost: u64,
}

impl Teller {
    fn take(&mut self, at: i64, event: Event) {
        match event {
            Event::TagBegins(tag) => {
                self.tag = Some(tag);
                self.begin(Track::Tag, at, What::Tag(tag));
            }
            Event::TagEnds(_) => {
                self.close(Track::Tag, at, false);
                self.tag = None;
            }
            Event::ReactionBegins(reaction, part, worker) => {
                self.begin(Track::Reaction(worker), at, What::Reaction(reaction, part, worker, self.tag));
            }
            Event::ReactionEnds(_, worker) => self.close(Track::Reaction(worker), at, false),
            Event::WaitBegins(waits) => self.begin(Track::Wait, at, What::Waits(waits)),
            Event::WaitEnds => self.close(Track::Wait, at, false),
            Event::Sent(word) => self.marks.push(Mark { at, sent: true, word, arrow: None }),
            Event::Received(word) => self.marks.push(Mark { at, sent: false, word, arrow: None }),
            Event::Lost(count) => self.lost += count,
            Event::Clock(_) | Event::Starts(..) | Event::Ends(_) => {}
        }
    }

    fn begin(&mut self, place: Track, at: i64, what: What) {
        // What lasts already ends where the next begins; no end of it was recorded.
        self.close(place, at, true);
        self.open.insert(place, (at, what));
    }

    /// Ends what lasts at a place, if something does: in a ring the beginning may be lost.
    fn close(&mut self, place: Track, end: i64, is_open: bool) {
        let Some((begin, what)) = self.open.remove(&place) else { return };
        let due = match what {
            What::Waits(Waits::Grant(tag) | Waits::Input(tag, ..)) if !self.fast => Some(tag),
            _ => None,
        };
        // Before the time of its tag a participant would wait in any case.
        let mut begin = begin;
        if let Some(tag) = due.filter(|tag| tag.time.as_nanos() > begin) {
            let until = tag.time.as_nanos().min(end);
            self.slices.push(Slice { begin, end: until, what: What::Waits(Waits::Time(tag)), is_open: false });
            begin = until;
        }
        if due.is_none() || begin < end {
            self.slices.push(Slice { begin, end, what, is_open });
        }
    }

    fn end(&mut self, at: i64) {
        while let Some((place, _)) = self.open.first_key_value() {
            self.close(*place, at, true);
        }
    }
}
