// SPDX-License-Identifier: Apache-2.0
//! Matches the records of a message at different participants.
//!
//! The number of an arrow follows from the common properties of its ends, so no table of all messages is necessary.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{MessageType, RTI};

use super::timeline::{MessageMark, Timeline};

/// A sequence of messages in order of their tags, except for some of the RTI's.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Lane {
    /// Values or absences for an input of a federate. Each input has one sender.
    Value { is_absent: bool, to: (u16, u16) },
    /// Control messages: the type byte, the federate, and whether they go to the RTI.
    Control(u8, u16, bool),
}

/// The stages of a message in transit: sent, received by the RTI, forwarded by the RTI, received. Control messages are
/// sent and received.
const STAGES: usize = 4;

/// The progress of a sequence at one stage.
#[derive(Clone, Copy, Default)]
struct Passed {
    count: usize,
    tag: Option<Tag>,
    /// The number of earlier messages with the same tag.
    repeated: usize,
}

/// An arrow that begins, continues or ends at a mark.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrow {
    pub(super) id: u64,
    pub(super) ends: bool,
}

/// The arrows of all recordings.
pub(super) struct Arrows {
    streams: BTreeMap<Lane, [Passed; STAGES]>,
    /// Whether no records are lost.
    complete: bool,
}

impl Arrows {
    pub(super) fn between(timelines: &[Timeline<'_>]) -> Self {
        Self { streams: BTreeMap::new(), complete: timelines.iter().all(|timeline| timeline.lost == 0) }
    }

    /// Returns the arrow at the next mark of a recording.
    pub(super) fn at(&mut self, timeline: &Timeline<'_>, mark: &MessageMark) -> Option<Arrow> {
        let (stream, stage) = stream(timeline, mark)?;
        let tag = mark.message.tag;
        // Without tags, only the number distinguishes messages, which is unknown if some are lost.
        if tag.is_none() && matches!(stream, Lane::Value { .. }) && !self.complete {
            return None;
        }
        let passed = &mut self.streams.entry(stream).or_default()[stage];
        passed.repeated = if passed.count > 0 && passed.tag == tag { passed.repeated + 1 } else { 0 };
        passed.tag = tag;
        passed.count += 1;
        let mut hasher = DefaultHasher::new();
        (stream, tag.map(|tag| (tag.time.as_nanos(), tag.microstep.0)), passed.repeated).hash(&mut hasher);
        let last = if matches!(stream, Lane::Value { .. }) { STAGES - 1 } else { 1 };
        Some(Arrow { id: hasher.finish(), ends: stage == last })
    }

    /// Returns the number of messages that were seen at two stages at least.
    pub(super) fn count(&self) -> usize {
        let both = |stages: &[Passed; STAGES]| {
            let mut counts = stages.map(|passed| passed.count);
            counts.sort_unstable();
            counts[STAGES - 2]
        };
        self.streams.values().map(both).sum()
    }
}

/// Returns the sequence and the stage of a mark.
fn stream(timeline: &Timeline<'_>, mark: &MessageMark) -> Option<(Lane, usize)> {
    let MessageMark { sent, message, .. } = mark;
    let is_absent = message.kind == MessageType::PortAbsent;
    if is_absent || message.is_value() {
        let stage = match (timeline.is_rti, sent) {
            (false, true) => 0,
            (true, false) => 1,
            (true, true) => 2,
            (false, false) => 3,
        };
        return Some((Lane::Value { is_absent, to: message.to }, stage));
    }
    let federate = if timeline.is_rti { Some(message.peer).filter(|peer| *peer != RTI) } else { timeline.id };
    let to_rti = timeline.is_rti != *sent;
    Some((Lane::Control(message.kind.byte(), federate?, to_rti), usize::from(!sent)))
}
