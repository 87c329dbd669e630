// SPDX-License-Identifier: Apache-2.0
//! Matches the records of a message at different participants.
//!
//! The number of an arrow follows from the common properties of its ends, so no table of all messages is necessary.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{MessageType, RTI};

use super::story::{Mark, Story};

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
    pub(super) fn between(stories: &[Story<'_>]) -> Self {
        Self { streams: BTreeMap::new(), complete: stories.iter().all(|story| story.lost == 0) }
    }

    /// Returns the arrow at the next mark of a recording.
    pub(super) fn at(&mut self, story: &Story<'_>, mark: &Mark) -> Option<Arrow> {
        let (stream, stage) = stream(story, mark)?;
        let tag = mark.word.tag;
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
fn stream(story: &Story<'_>, mark: &Mark) -> Option<(Lane, usize)> {
    let Mark { sent, word, .. } = mark;
    let is_absent = word.kind == MessageType::PortAbsent;
    if is_absent || word.is_value() {
        let stage = match (story.is_rti, sent) {
            (false, true) => 0,
            (true, false) => 1,
            (true, true) => 2,
            (false, false) => 3,
        };
        return Some((Lane::Value { is_absent, to: word.to }, stage));
    }
    let federate = if story.is_rti { Some(word.peer).filter(|peer| *peer != RTI) } else { story.id };
    let to_rti = story.is_rti != *sent;
    Some((Lane::Control(word.kind.byte(), federate?, to_rti), usize::from(!sent)))
}
