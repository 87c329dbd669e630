// SPDX-License-Identifier: Apache-2.0
//! Which message at one participant is which at another.

use std::collections::BTreeMap;

use lf_linux::model::time::Tag;
use lf_linux::runtime::trace::{RTI, Subject};

use super::story::{Mark, Story};

/// What two ends of an arrow have in common.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    /// A value, or word that there is none: for whom, and the tag. Each input has one sender.
    Value(Subject, (u16, u16), Option<(i64, u32)>),
    /// A federate and its RTI, to which it goes or from which it comes.
    Control(Subject, u16, bool, Option<(i64, u32)>),
}

/// Where a message is on its way: sent, at the RTI, sent on by the RTI, received.
const STAGES: usize = 4;

/// Where on the way of a message each of its marks is: story and mark, in order of time.
type Way = [Vec<(usize, usize)>; STAGES];

/// Draws the arrows; says how many there are.
pub(crate) fn draw(stories: &mut [Story<'_>]) -> usize {
    let mut ways: BTreeMap<Key, Way> = BTreeMap::new();
    let complete = stories.iter().all(|story| story.lost == 0);
    for (index, story) in stories.iter().enumerate() {
        for (place, mark) in story.marks.iter().enumerate() {
            if let Some((key, stage)) = key(story, mark) {
                ways.entry(key).or_default()[stage].push((index, place));
            }
        }
    }
    let mut count = 0;
    for (key, way) in ways {
        // Without tags, only the number tells one from another, and that is not known where some are lost.
        if matches!(key, Key::Value(_, _, None)) && !complete {
            continue;
        }
        for number in 0..way.iter().map(Vec::len).max().unwrap_or(0) {
            let marks: Vec<_> = way.iter().filter_map(|stage| stage.get(number)).collect();
            let Some((last, others)) = marks.split_last().filter(|(_, others)| !others.is_empty()) else { continue };
            count += 1;
            let id = u64::try_from(count).unwrap_or(u64::MAX);
            for (story, mark) in others {
                stories[*story].marks[*mark].arrow = Some((id, false));
            }
            stories[last.0].marks[last.1].arrow = Some((id, true));
        }
    }
    count
}

/// Which arrow a mark belongs to, and where on its way.
fn key(story: &Story<'_>, mark: &Mark) -> Option<(Key, usize)> {
    let Mark { sent, word, .. } = mark;
    let tag = word.tag.map(|Tag { time, microstep }| (time.as_nanos(), microstep.0));
    if matches!(word.subject, Subject::Value | Subject::Absent) {
        let stage = match (story.is_rti, sent) {
            (false, true) => 0,
            (true, false) => 1,
            (true, true) => 2,
            (false, false) => 3,
        };
        return Some((Key::Value(word.subject, word.to, tag), stage));
    }
    let federate = if story.is_rti { Some(word.peer).filter(|peer| *peer != RTI) } else { story.id };
    let to_rti = story.is_rti != *sent;
    // The ways of control messages have two stages.
    Some((Key::Control(word.subject, federate?, to_rti, tag), usize::from(!sent)))
}
