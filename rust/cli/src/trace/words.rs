// SPDX-License-Identifier: Apache-2.0
//! Formats records as text, for tracks and for the table.

use lf_linux::model::time::{Instant, Tag};
use lf_linux::runtime::trace::{MessageType, RTI, WaitLimit, Waits};

use super::names::TraceNames;
use super::timeline::Timeline;

/// Returns a duration with at most four digits.
pub(crate) fn duration(ns: i64) -> String {
    const UNITS: [(&str, i64); 4] = [("s", 1_000_000_000), ("ms", 1_000_000), ("µs", 1_000), ("ns", 1)];
    let (unit, size) = UNITS.into_iter().find(|(_, size)| ns.abs() >= *size).unwrap_or(UNITS[3]);
    let (whole, part) = (ns / size, ns % size);
    match (whole.abs(), size) {
        (_, 1) | (100.., _) => format!("{whole} {unit}"),
        (10..100, _) => format!("{whole}.{} {unit}", part.abs() * 10 / size),
        _ => format!("{whole}.{:02} {unit}", part.abs() * 100 / size),
    }
}

/// Returns a tag, relative to the start if that is known: `(10 ms, 0)`.
pub(crate) fn tag(tag: Tag, start: Option<i64>) -> String {
    match (tag, start) {
        (Tag::NEVER, _) => "NEVER".to_owned(),
        (Tag::FOREVER, _) => "FOREVER".to_owned(),
        // The window that a federate offers.
        (Tag { time: Instant::NEVER, microstep }, _) => format!("(NEVER, {microstep})"),
        (Tag { time, microstep }, Some(start)) => {
            format!("({}, {microstep})", exactly(time.as_nanos().saturating_sub(start)))
        }
        (tag, None) => tag.to_string(),
    }
}

/// Returns a time in the largest unit of which it is a multiple.
fn exactly(ns: i64) -> String {
    const UNITS: [(&str, i64); 3] = [("s", 1_000_000_000), ("ms", 1_000_000), ("µs", 1_000)];
    let unit = UNITS.into_iter().find(|(_, size)| ns % size == 0);
    unit.map_or_else(|| format!("{ns} ns"), |(unit, size)| format!("{} {unit}", ns / size))
}

/// Returns the name of a federate.
pub(crate) fn federate(names: &TraceNames, id: u16) -> String {
    names.federates.get(usize::from(id)).map_or_else(|| format!("federate {id}"), |found| found.name.clone())
}

/// Returns the connection that ends at an input, by the federate and the number on the wire.
pub(crate) fn connection(names: &TraceNames, (id, port): (u16, u16)) -> String {
    let inputs = names.federates.get(usize::from(id)).map_or(&[][..], |found| &found.inputs);
    inputs
        .iter()
        .find(|input| input.port == port)
        .map_or_else(|| format!("input {port} of {}", federate(names, id)), |input| input.name.clone())
}

/// Returns the reason of a wait: the text after "waiting for".
pub(crate) fn waits(timeline: &Timeline<'_>, names: &TraceNames, waits: Waits) -> String {
    match waits {
        Waits::Anything if timeline.is_rti => "messages".to_owned(),
        Waits::Anything => "anything to do".to_owned(),
        Waits::Time(_) => "the time of a tag".to_owned(),
        Waits::Start => "the start".to_owned(),
        Waits::End => "others to take the last words".to_owned(),
        Waits::Grant(_) => "a grant".to_owned(),
        Waits::Input(_, input, WaitLimit::Endless) => timeline.input(input),
        Waits::Input(_, input, WaitLimit::Limited) => format!("{}, no longer than maxwait", timeline.input(input)),
        Waits::Room(_, RTI) => "room at the RTI".to_owned(),
        Waits::Room(_, id) => format!("room at {}", federate(names, id)),
    }
}

/// Returns the name of a message.
pub(crate) fn message(kind: MessageType) -> &'static str {
    match kind {
        MessageType::Timestamp => "start time",
        MessageType::StopRequest => "stop request",
        MessageType::StopReply => "stop reply",
        MessageType::StopGranted => "stop granted",
        MessageType::Resign => "resign",
        MessageType::Failed => "failed",
        // The names are those of LF's own tools.
        kind => kind.name(),
    }
}

/// Returns the tag of a wait.
pub(crate) fn tag_of(waits: Waits) -> Option<Tag> {
    match waits {
        Waits::Anything | Waits::Start | Waits::End => None,
        Waits::Time(tag) | Waits::Grant(tag) | Waits::Input(tag, ..) | Waits::Room(tag, _) => Some(tag),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_have_three_digits_and_their_unit() {
        for (ns, words) in [
            (0, "0 ns"),
            (999, "999 ns"),
            (1_234, "1.23 µs"),
            (12_345, "12.3 µs"),
            (123_456_789, "123 ms"),
            (2_000_000_000, "2.00 s"),
            (-1_500_000, "-1.50 ms"),
        ] {
            assert_eq!(duration(ns), words);
        }
    }
}
