// SPDX-License-Identifier: Apache-2.0
//! Checks that the trace of every federate is that of the same program run unfederated.
//!
//! Reactions of one instance are ordered, those of different instances at one tag need not be. So the check compares
//! traces instance by instance.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use lf_model::time::Tag;

use super::Violation;
use crate::program::{InstanceId, Record};

/// The difference between two traces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Difference {
    /// The federate did `found`, and the unfederated program did `expected`.
    Other { found: Record, expected: Record },
    /// The unfederated program did not do this.
    More(Record),
    /// Only the unfederated program did this.
    Less(Record),
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Other { found, expected } => write!(
                f,
                "ran reaction {} at {} (seeing {:x}), and unfederated it is reaction {} at {} (seeing {:x})",
                found.reaction, found.tag, found.digest, expected.reaction, expected.tag, expected.digest
            ),
            Self::More(record) => {
                write!(f, "ran reaction {} at {}, which unfederated does not run", record.reaction, record.tag)
            }
            Self::Less(record) => {
                write!(f, "did not run reaction {} at {}, which unfederated runs", record.reaction, record.tag)
            }
        }
    }
}

/// The part of a federate's trace that has to match the unfederated one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Expected {
    /// The tag before which the records have to match.
    pub(crate) before: Tag,
    /// Whether records may be missing at the end, because the federate ended early.
    pub(crate) prefix: bool,
}

/// Compares the traces of federates with that of the same program run unfederated, where one is expected.
pub(crate) fn traces(federates: &[Vec<Record>], alone: &[Record], expected: &[Option<Expected>]) -> Option<Violation> {
    let last = alone.iter().find(|record| record.last_tag).map(|record| record.tag);
    let alone = by_instance(alone);
    for (federate, (trace, expected)) in federates.iter().zip(expected).enumerate() {
        if let Some(violation) = tag_order(federate, trace) {
            return Some(violation);
        }
        let Some(expected) = expected else { continue };
        let ended_together = trace.iter().all(|record| !record.last_tag || Some(record.tag) == last);
        let found = by_instance(trace);
        let of_this = alone.keys().filter(|instance| instance.federate == federate);
        let instances: BTreeSet<_> = found.keys().chain(of_this).collect();
        for instance in instances {
            let records = |all: &BTreeMap<InstanceId, Vec<Record>>| all.get(instance).cloned().unwrap_or_default();
            if let Some(difference) = compare(&records(&found), &records(&alone), *expected, ended_together) {
                return Some(Violation::Trace { federate, difference });
            }
        }
    }
    None
}

/// Compares the trace of an instance of a transient federate with that of the same federate alone, which begins with
/// the same tag and receives the same: it is the beginning of that, apart from the last tag.
pub(crate) fn incarnation(instance: usize, trace: &[Record], alone: &[Record]) -> Option<Violation> {
    let expected = Expected { before: Tag::FOREVER, prefix: true };
    let alone = by_instance(alone);
    by_instance(trace).into_iter().find_map(|(of, found)| {
        let other = alone.get(&of).map(Vec::as_slice).unwrap_or_default();
        let difference = compare(&found, other, expected, false)?;
        Some(Violation::Trace { federate: instance, difference })
    })
}

/// Checks only that the tags of each federate do not decrease.
pub(crate) fn in_order(federates: &[Vec<Record>]) -> Option<Violation> {
    federates.iter().enumerate().find_map(|(federate, trace)| tag_order(federate, trace))
}

fn by_instance(trace: &[Record]) -> BTreeMap<InstanceId, Vec<Record>> {
    let mut instances: BTreeMap<InstanceId, Vec<Record>> = BTreeMap::new();
    for record in trace {
        instances.entry(record.instance).or_default().push(*record);
    }
    instances
}

fn tag_order(federate: usize, trace: &[Record]) -> Option<Violation> {
    let pairs = trace.iter().zip(trace.iter().skip(1));
    let (before, after) =
        pairs.map(|(before, after)| (before.tag, after.tag)).find(|(before, after)| before > after)?;
    Some(Violation::TagOrder { federate, before, after })
}

/// Compares the records of one federate. A federate without further events ends by itself, at a tag of its own: the
/// comparison of its last records ignores the tag and all that follows from it.
fn compare(found: &[Record], other: &[Record], expected: Expected, ended_together: bool) -> Option<Difference> {
    let counts = |record: &&Record| record.tag < expected.before && (ended_together || !record.last_tag);
    let mut found = found.iter().filter(counts);
    let mut other = other.iter().filter(counts);
    loop {
        match (found.next(), other.next()) {
            (None, None) => return None,
            (None, Some(_)) if expected.prefix => return None,
            (None, Some(expected)) => return Some(Difference::Less(*expected)),
            (Some(found), None) => return Some(Difference::More(*found)),
            (Some(found), Some(expected)) if !same(found, expected) => {
                return Some(Difference::Other { found: *found, expected: *expected });
            }
            (Some(_), Some(_)) => {}
        }
    }
}

fn same(found: &Record, expected: &Record) -> bool {
    (found.tag, found.reaction, found.digest) == (expected.tag, expected.reaction, expected.digest)
}
