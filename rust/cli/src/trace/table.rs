// SPDX-License-Identifier: Apache-2.0
//! The table of each participant's times.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use super::names::TraceNames;
use super::timeline::{Slice, SliceKind, Timeline};
use super::words::{self, duration};

/// The width of a column of durations.
const WIDTH: usize = 9;

/// The number of intervals, their total and the longest.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    count: i64,
    total: i64,
    longest: i64,
}

impl Sum {
    fn add(&mut self, length: i64) {
        self.count += 1;
        self.total += length;
        self.longest = self.longest.max(length);
    }

    fn mean(&self) -> i64 {
        self.total / self.count.max(1)
    }
}

/// The times of one participant.
#[derive(Debug, Default)]
pub(crate) struct Sums {
    waits: BTreeMap<String, Sum>,
    reactions: BTreeMap<u16, Sum>,
    running: Sum,
    /// The time from the time of a tag to its reactions.
    lag: Sum,
}

impl Sums {
    /// Adds an interval.
    pub(crate) fn add(&mut self, slice: &Slice, timeline: &Timeline<'_>, names: &TraceNames) {
        match slice.what {
            SliceKind::Waits(why) => {
                self.waits.entry(words::waits(timeline, names, why)).or_default().add(slice.length());
            }
            SliceKind::Reaction(reaction, _, worker, tag) => {
                self.reactions.entry(reaction).or_default().add(slice.length());
                if worker == 0 {
                    self.running.add(slice.length());
                }
                if let Some(tag) = tag {
                    self.lag.add(slice.begin - tag.time.as_nanos());
                }
            }
            SliceKind::Tag(_) => {}
        }
    }

    /// Returns the part of the table about this participant, for users.
    pub(crate) fn table(self, timeline: &Timeline<'_>) -> String {
        let mut text = String::new();
        // Writing into a text does not fail.
        let _ = self.write(&mut text, timeline);
        text
    }

    fn write(self, text: &mut String, timeline: &Timeline<'_>) -> fmt::Result {
        let Self { waits, reactions, running, lag } = self;
        let whole = timeline.span.1 - timeline.span.0;
        writeln!(text, "{}: {}", timeline.name, duration(whole))?;
        if timeline.lost > 0 {
            writeln!(text, "  the oldest {} records are lost: what follows is about the others", timeline.lost)?;
        }
        let row = |text: &mut String, name: &str, sum: &Sum| {
            let part = sum.total.saturating_mul(1000) / whole.max(1);
            let (total, longest) = (duration(sum.total), duration(sum.longest));
            writeln!(
                text,
                "  {total:>WIDTH$} {:>3}.{} %  {name} ({} times, longest {longest})",
                part / 10,
                part % 10,
                sum.count
            )
        };
        if running.count > 0 {
            row(text, "running reactions", &running)?;
        }
        let mut waits: Vec<_> = waits.into_iter().collect();
        waits.sort_by_key(|(_, sum)| -sum.total);
        for (why, sum) in &waits {
            row(text, &format!("waiting for {why}"), sum)?;
        }
        let rest = whole - running.total - waits.iter().map(|(_, sum)| sum.total).sum::<i64>();
        let part = rest.max(0).saturating_mul(1000) / whole.max(1);
        writeln!(
            text,
            "  {:>WIDTH$} {:>3}.{} %  the rest: sockets, queues, starting and ending",
            duration(rest),
            part / 10,
            part % 10
        )?;
        if reactions.is_empty() {
            return Ok(());
        }
        writeln!(text, "  {:>WIDTH$} {:>WIDTH$} {:>WIDTH$}  reaction", "count", "mean", "longest")?;
        for (reaction, sum) in reactions {
            let (name, at) = timeline.reaction(reaction);
            let at = at.map_or_else(String::new, |at| format!(" ({at})"));
            let (mean, longest) = (duration(sum.mean()), duration(sum.longest));
            writeln!(text, "  {:>WIDTH$} {mean:>WIDTH$} {longest:>WIDTH$}  {name}{at}", sum.count)?;
        }
        let (mean, longest) = (duration(lag.mean()), duration(lag.longest));
        writeln!(text, "  from the time of a tag to its reactions: {mean} in the mean, {longest} at most")
    }
}
