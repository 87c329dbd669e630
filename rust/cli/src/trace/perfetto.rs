// SPDX-License-Identifier: Apache-2.0
//! The file for Perfetto: a process for each participant, with tracks for tags, reactions, waits and messages.
//!
//! The messages are those of Perfetto's `protos/perfetto/trace`, as far as this writer needs them.

use std::io::{self, Write};

use lf_linux::model::Part;
use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{MessageType, RTI};
use prost::Message;

use super::arrows::Arrow;
use super::names::TraceNames;
use super::timeline::{MessageMark, Slice, SliceKind, Timeline};
use super::words;

#[derive(Clone, PartialEq, Message)]
struct Trace {
    #[prost(message, repeated, tag = "1")]
    packet: Vec<TracePacket>,
}

#[derive(Clone, PartialEq, Message)]
struct TracePacket {
    /// The time in nanoseconds.
    #[prost(uint64, optional, tag = "8")]
    timestamp: Option<u64>,
    #[prost(uint32, tag = "10")]
    trusted_packet_sequence_id: u32,
    #[prost(message, optional, tag = "11")]
    track_event: Option<TrackEvent>,
    #[prost(message, optional, tag = "60")]
    track_descriptor: Option<TrackDescriptor>,
}

#[derive(Clone, PartialEq, Message)]
struct TrackDescriptor {
    #[prost(uint64, tag = "1")]
    uuid: u64,
    #[prost(string, tag = "2")]
    name: String,
    #[prost(message, optional, tag = "3")]
    process: Option<ProcessDescriptor>,
    #[prost(uint64, optional, tag = "5")]
    parent_uuid: Option<u64>,
    #[prost(int32, optional, tag = "11")]
    child_ordering: Option<i32>,
    #[prost(int32, optional, tag = "12")]
    sibling_order_rank: Option<i32>,
}

#[derive(Clone, PartialEq, Message)]
struct ProcessDescriptor {
    #[prost(int32, tag = "1")]
    pid: i32,
    #[prost(string, tag = "6")]
    process_name: String,
}

#[derive(Clone, PartialEq, Message)]
struct TrackEvent {
    #[prost(message, repeated, tag = "4")]
    debug_annotations: Vec<DebugAnnotation>,
    #[prost(int32, tag = "9")]
    kind: i32,
    #[prost(uint64, tag = "11")]
    track_uuid: u64,
    #[prost(string, repeated, tag = "22")]
    categories: Vec<String>,
    #[prost(string, optional, tag = "23")]
    name: Option<String>,
    #[prost(fixed64, repeated, packed = "false", tag = "47")]
    flow_ids: Vec<u64>,
    #[prost(fixed64, repeated, packed = "false", tag = "48")]
    terminating_flow_ids: Vec<u64>,
}

#[derive(Clone, PartialEq, Message)]
struct DebugAnnotation {
    #[prost(int64, optional, tag = "4")]
    int_value: Option<i64>,
    #[prost(string, optional, tag = "6")]
    string_value: Option<String>,
    #[prost(string, tag = "10")]
    name: String,
}

const SLICE_BEGIN: i32 = 1;
const SLICE_END: i32 = 2;
const INSTANT: i32 = 3;

/// The order of a track's children by their ranks.
const EXPLICIT: i32 = 3;

/// The writer of all packets.
const SEQUENCE: u32 = 1;

/// The names of a participant's tracks, in their order. Those of workers follow.
const TRACKS: [&str; 4] = ["tags", "reactions", "waits", "messages"];

/// The tracks of a participant, one packet after another.
pub(crate) struct Writer<'a, O> {
    pub(crate) timeline: &'a Timeline<'a>,
    pub(crate) names: &'a TraceNames,
    /// The number, from 1.
    pub(crate) number: i32,
    pub(crate) output: O,
}

impl<O: Write> Writer<'_, O> {
    /// Writes the descriptions of the tracks.
    ///
    /// # Errors
    /// When it cannot be written, as in all other methods.
    pub(crate) fn begin(&mut self) -> io::Result<()> {
        let process = ProcessDescriptor { pid: self.number, process_name: self.timeline.name.clone() };
        self.describe(TrackDescriptor {
            uuid: self.uuid(0),
            process: Some(process),
            child_ordering: Some(EXPLICIT),
            ..TrackDescriptor::default()
        })?;
        let workers = (1..=self.timeline.workers).map(|worker| format!("worker {worker}"));
        let names = TRACKS.iter().map(|name| (*name).to_owned()).chain(workers);
        for (rank, name) in (1u16..).zip(names) {
            self.describe(TrackDescriptor {
                uuid: self.uuid(rank),
                name,
                parent_uuid: Some(self.uuid(0)),
                sibling_order_rank: Some(rank.into()),
                ..TrackDescriptor::default()
            })?;
        }
        Ok(())
    }

    /// Writes a packet. The packets of a trace stand one after another.
    fn put(&mut self, packet: TracePacket) -> io::Result<()> {
        self.output.write_all(&Trace { packet: vec![packet] }.encode_to_vec())
    }

    /// Returns the number of a track: the participant's own (0), one of [`TRACKS`], or a worker's.
    fn uuid(&self, track: u16) -> u64 {
        (u64::from(self.number.unsigned_abs()) << 16) + u64::from(track)
    }

    fn describe(&mut self, descriptor: TrackDescriptor) -> io::Result<()> {
        self.put(TracePacket {
            trusted_packet_sequence_id: SEQUENCE,
            track_descriptor: Some(descriptor),
            ..TracePacket::default()
        })
    }

    fn event(&mut self, at: i64, event: TrackEvent) -> io::Result<()> {
        self.put(TracePacket {
            // No time is before 1970, or the boot of a board.
            timestamp: Some(u64::try_from(at).unwrap_or(0)),
            trusted_packet_sequence_id: SEQUENCE,
            track_event: Some(event),
            ..TracePacket::default()
        })
    }

    /// Writes an interval.
    pub(crate) fn slice(&mut self, slice: &Slice) -> io::Result<()> {
        let tagged = |tag: Tag| self.of_tag(tag);
        let (track, category, name, mut annotations) = match slice.what {
            SliceKind::Tag(tag) => (1, "tag", words::tag(tag, self.timeline.start), tagged(tag)),
            SliceKind::Reaction(reaction, part, worker, tag) => {
                let (name, at) = self.timeline.reaction(reaction);
                let (name, category) = match part {
                    Part::Body => (name, "reaction"),
                    Part::MissedDeadline => (format!("{name}: deadline missed"), "deadline"),
                    Part::Tardy => (format!("{name}: tardy"), "tardy"),
                };
                let mut annotations = tag.map(tagged).unwrap_or_default();
                annotations.extend(at.map(|at| text("lf", at)));
                (if worker == 0 { 2 } else { 4 + worker }, category, name, annotations)
            }
            SliceKind::Waits(waits) => {
                let tag = words::tag_of(waits).map(tagged).unwrap_or_default();
                (3, "wait", words::waits(self.timeline, self.names, waits), tag)
            }
        };
        if slice.is_open {
            annotations.push(text("end", "not recorded"));
        }
        let (track_uuid, categories) = (self.uuid(track), vec![category.to_owned()]);
        let name = Some(name);
        let begin = TrackEvent {
            debug_annotations: annotations,
            kind: SLICE_BEGIN,
            track_uuid,
            categories,
            name,
            ..TrackEvent::default()
        };
        self.event(slice.begin, begin)?;
        self.event(slice.end, TrackEvent { kind: SLICE_END, track_uuid, ..TrackEvent::default() })
    }

    /// Writes a message, with the arrow that begins, continues or ends there.
    pub(crate) fn mark(&mut self, mark: &MessageMark, arrow: Option<Arrow>) -> io::Result<()> {
        let message = &mark.message;
        let mut annotations = message.tag.map(|tag| self.of_tag(tag)).unwrap_or_default();
        annotations.push(number("bytes", message.bytes.into()));
        let (from, to) = (if mark.sent { "to" } else { "from" }, self.peer(message.peer));
        let what = match message.kind {
            MessageType::PortAbsent => format!("absent: {}", words::connection(self.names, message.to)),
            _ if message.is_value() => words::connection(self.names, message.to),
            kind => words::message(kind).to_owned(),
        };
        let (mut flow_ids, mut terminating_flow_ids) = (Vec::new(), Vec::new());
        if let Some(Arrow { id, ends }) = arrow {
            if ends { &mut terminating_flow_ids } else { &mut flow_ids }.push(id);
        }
        let event = TrackEvent {
            debug_annotations: annotations,
            kind: INSTANT,
            track_uuid: self.uuid(4),
            categories: vec![if mark.sent { "sent" } else { "received" }.to_owned()],
            name: Some(format!("{what} {from} {to}")),
            flow_ids,
            terminating_flow_ids,
        };
        self.event(mark.at, event)
    }

    /// Returns the name of the other end of a connection.
    fn peer(&self, peer: u16) -> String {
        match peer {
            RTI if self.timeline.is_rti => "a federate".to_owned(),
            RTI => "the RTI".to_owned(),
            id => words::federate(self.names, id),
        }
    }

    fn of_tag(&self, tag: Tag) -> Vec<DebugAnnotation> {
        vec![text("tag", &words::tag(tag, self.timeline.start))]
    }
}

fn text(name: &str, value: &str) -> DebugAnnotation {
    DebugAnnotation { name: name.to_owned(), string_value: Some(value.to_owned()), ..DebugAnnotation::default() }
}

fn number(name: &str, value: i64) -> DebugAnnotation {
    DebugAnnotation { name: name.to_owned(), int_value: Some(value), ..DebugAnnotation::default() }
}
