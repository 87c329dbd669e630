// SPDX-License-Identifier: Apache-2.0
//! Where the time of each participant went.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use super::names::Names;
use super::story::{Story, What};
use super::words::{self, duration};

/// A column of durations.
const WIDTH: usize = 9;

/// How often something was, how long all of it took, and the longest.
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

/// The table, for people.
pub(crate) fn table(stories: &[Story<'_>], names: &Names) -> String {
    let mut text = String::new();
    for story in stories {
        if !text.is_empty() {
            text.push('\n');
        }
        // Writing into a text does not fail.
        let _ = of_participant(&mut text, story, names);
    }
    text
}

fn of_participant(text: &mut String, story: &Story<'_>, names: &Names) -> fmt::Result {
    let whole = story.span.1 - story.span.0;
    writeln!(text, "{}: {}", story.name, duration(whole))?;
    if story.lost > 0 {
        writeln!(text, "  the oldest {} records are lost: what follows is about the others", story.lost)?;
    }
    let (mut waits, mut reactions, mut lag) = (BTreeMap::<_, Sum>::new(), BTreeMap::<_, Sum>::new(), Sum::default());
    let mut running = Sum::default();
    for slice in &story.slices {
        match slice.what {
            What::Waits(why) => waits.entry(words::waits(story, names, why)).or_default().add(slice.length()),
            What::Reaction(reaction, _, worker, tag) => {
                reactions.entry(reaction).or_default().add(slice.length());
                if worker == 0 {
                    running.add(slice.length());
                }
                if let Some(tag) = tag {
                    lag.add(slice.begin - tag.time.as_nanos());
                }
            }
            What::Tag(_) => {}
        }
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
        let (name, at) = story.reaction(reaction);
        let at = at.map_or_else(String::new, |at| format!(" ({at})"));
        let (mean, longest) = (duration(sum.mean()), duration(sum.longest));
        writeln!(text, "  {:>WIDTH$} {mean:>WIDTH$} {longest:>WIDTH$}  {name}{at}", sum.count)?;
    }
    let (mean, longest) = (duration(lag.mean()), duration(lag.longest));
    writeln!(text, "  from the time of a tag to its reactions: {mean} in the mean, {longest} at most")
}
