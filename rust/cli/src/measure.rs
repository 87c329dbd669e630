// SPDX-License-Identifier: Apache-2.0
//! `lfz run --measure`: bounds from what federates have observed in a run.
//!
//! Each federate writes down when it begins tags, sends and receives, in the federation's physical time (see
//! `lf_linux`). A message is the same at both ends by its receiver, its input and its tag, so the latencies contain
//! what the clocks differ by. A lag is the time from where a tag could begin to a message of it; a wait within the tag
//! counts as part of it, which is on the safe side.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lf_compiler::maxwait::{Bounds, FederateBounds};
use lf_compiler::plan::{Federate, Plan};

use crate::failure::Failure;

/// A tag: nanoseconds and microstep.
type Tag = (i64, u32);

/// A message: the receiver, its input and the tag.
type MessageKey = (u16, u16, Tag);

/// What came of a run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Measured {
    /// The bounds that it showed.
    pub(crate) bounds: Bounds,
    /// How many messages were seen at both ends.
    pub(crate) messages: usize,
}

impl Measured {
    /// The file of bounds.
    pub(crate) fn to_yaml(&self, plan: &Plan) -> String {
        format!(
            "# What a run of {} showed on {} messages: the longest latencies and lags. It may take longer \
             another time.\n\
             # The latencies contain the differences of the clocks.\n{}",
            plan.name,
            self.messages,
            self.bounds.to_yaml()
        )
    }
}

/// The file into which a federate writes what it observes.
pub(crate) fn file(folder: &Path, federate: &Federate) -> PathBuf {
    folder.join(format!("{}.observations", federate.name))
}

/// Reads what all federates have written.
///
/// # Errors
/// When a file is missing or not understood.
pub(crate) fn read(plan: &Plan, folder: &Path) -> Result<Measured, Failure> {
    let mut all = Vec::new();
    for federate in &plan.federates {
        let path = file(folder, federate);
        let wrong = |reason: String| Failure::message(format!("cannot use {}: {reason}", path.display()));
        let text = std::fs::read_to_string(&path).map_err(|error| wrong(error.to_string()))?;
        all.push(Observations::parse(federate.id, &text).map_err(wrong)?);
    }
    Ok(combine(plan, &all))
}

/// What one federate has observed.
#[derive(Debug, Default)]
struct Observations {
    /// When messages went out.
    sent: BTreeMap<MessageKey, i64>,
    /// When messages came.
    received: BTreeMap<MessageKey, i64>,
    /// The longest time from where a tag could begin to a message of it.
    lag_ns: Option<i64>,
}

impl Observations {
    /// Reads lines like `begins TIME MICROSTEP DUE AT`, `sends FEDERATE PORT TIME MICROSTEP AT` and `receives PORT TIME
    /// MICROSTEP AT`, in the order in which things happened.
    fn parse(federate: u16, text: &str) -> Result<Self, String> {
        let mut found = Self::default();
        // Since when the open tag could have begun.
        let mut since = None;
        // When the latest message for each tag that has not begun came.
        let mut causes: BTreeMap<Tag, i64> = BTreeMap::new();
        for line in text.lines() {
            let wrong = || format!("`{line}` is no observation");
            let mut words = line.split(' ');
            let kind = words.next().unwrap_or_default();
            let numbers: Vec<i64> = words.map(|word| word.parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
            let port = |number: i64| u16::try_from(number).map_err(|_| wrong());
            let tag = |time: i64, step: i64| u32::try_from(step).map(|step| (time, step)).map_err(|_| wrong());
            match (kind, &numbers[..]) {
                ("begins", &[time, step, due, _]) => {
                    let tag = tag(time, step)?;
                    since = Some(causes.get(&tag).map_or(due, |came| due.max(*came)));
                    causes = causes.split_off(&tag);
                }
                ("sends", &[to, to_port, time, step, at]) => {
                    found.sent.insert((port(to)?, port(to_port)?, tag(time, step)?), at);
                    let lag = since.map_or(0, |since| at.saturating_sub(since));
                    found.lag_ns = found.lag_ns.max(Some(lag.max(0)));
                }
                ("receives", &[to_port, time, step, at]) => {
                    let tag = tag(time, step)?;
                    found.received.entry((federate, port(to_port)?, tag)).or_insert(at);
                    causes.entry(tag).or_insert(at);
                }
                _ => return Err(wrong()),
            }
        }
        Ok(found)
    }
}

/// The longest latencies and lags.
fn combine(plan: &Plan, all: &[Observations]) -> Measured {
    let mut bounds = Bounds { clock_error_ns: Some(0), ..Bounds::default() };
    let mut messages = 0;
    for (federate, observed) in plan.federates.iter().zip(all) {
        if let Some(lag_ns) = observed.lag_ns {
            let known = FederateBounds { clock_error_ns: None, lag_ns: Some(lag_ns) };
            bounds.federates.insert(federate.name.clone(), known);
        }
        for (message, received_at) in &observed.received {
            let (_, port, _) = message;
            let Some(input) = federate.input_of(*port).map(|input| &federate.inputs[input.0]) else { continue };
            let sent_at = all.get(usize::from(input.federate)).and_then(|sender| sender.sent.get(message));
            // What was lost with a federate that failed has no other end.
            let Some(sent_at) = sent_at else { continue };
            messages += 1;
            let latency = received_at.saturating_sub(*sent_at).max(0);
            let longest = bounds.connections.entry(input.name.clone()).or_default();
            *longest = (*longest).max(latency);
        }
    }
    Measured { bounds, messages }
}

#[cfg(test)]
mod tests {
    use lf_compiler::{SourceProvider, compile};

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

    #[test]
    fn the_longest_of_each_is_the_bound() {
        let source = "begins 100 0 100 105\nsends 1 0 100 0 110\nbegins 200 0 200 201\nsends 1 0 200 0 203\n";
        let sink = "receives 0 100 0 150\nbegins 100 0 100 151\nreceives 0 200 0 210\n";
        let all = [(0, source), (1, sink)].map(|(id, text)| Observations::parse(id, text).expect("it is right"));
        let measured = combine(&plan(), &all);
        assert_eq!(measured.messages, 2);
        assert_eq!(measured.bounds.connections, BTreeMap::from([("a.y -> b.x".to_owned(), 40)]));
        assert_eq!(measured.bounds.federates["a"].lag_ns, Some(10));
        let read = Bounds::parse("bounds.yaml", &measured.to_yaml(&plan()), &plan());
        assert_eq!(read, Ok(measured.bounds));
    }

    /// A tag that a message causes cannot begin before that has come, but one that only waited could.
    #[test]
    fn lags_count_from_where_a_tag_could_begin() {
        let passes_on = "receives 0 100 0 150\nbegins 100 0 100 151\nsends 1 0 100 0 153\n";
        assert_eq!(Observations::parse(0, passes_on).expect("it is right").lag_ns, Some(3));
        let waits = "receives 0 300 0 150\nbegins 100 0 120 151\nsends 1 0 100 0 153\n";
        assert_eq!(Observations::parse(0, waits).expect("it is right").lag_ns, Some(33));
    }

    #[test]
    fn other_lines_are_named() {
        for wrong in ["begins 1 2 3", "sends a 0 1 0 1", "receives 70000 1 0 1", "receives 0 1 -1 1", "ends"] {
            assert!(Observations::parse(0, wrong).is_err_and(|reason| reason.contains(wrong)), "{wrong}");
        }
    }
}
