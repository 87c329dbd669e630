// SPDX-License-Identifier: Apache-2.0
//! Stated or measured bounds on the delays of messages, in a file:
//!
//! ```yaml
//! latency: 5 ms                        # from sending a message to its arrival, on every connection
//! clock-error: 100 us                  # between any two clocks
//! execution: 200 us                    # of every reaction
//! hosts:                               # latencies between hosts, as `at` names them; in both directions
//!   - { between: [10.0.0.1, 10.0.0.2], latency: 800 us }
//! connections:                         # latencies of single connections
//!   a.dip -> b.peer_1: 1.2 ms
//! federates:
//!   a:
//!     clock-error: 50 us               # between its clock and the RTI's
//!     lag: 1 ms                        # from where it may begin a tag to its last message of the tag
//! reactors: { DistAlg: 50 us }         # the execution of every reaction of a reactor
//! reactions: { a.algorithm.reaction_2: 80 us }
//! ```
//!
//! The more specific bound takes precedence: a connection over hosts over `latency`, a federate's `lag` over the
//! execution of its reactions, a reaction over its reactor over `execution`. A key may be missing if others supply its
//! value.

use core::fmt;
use std::collections::BTreeMap;
use std::fmt::Write;

use lf_model::units::{nanoseconds, number_and_unit};
use serde::Deserialize;
use serde_saphyr::{Location, Spanned};

use crate::diagnostics::did_you_mean;
use crate::plan::{Federate, NetworkInput, Plan, ReactionKind, ScheduledReaction, Time};
use crate::yaml::{self, FileError};

/// Bounds, in nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// From sending a message to its arrival.
    pub latency_ns: Option<i64>,
    /// Between any two clocks.
    pub clock_error_ns: Option<i64>,
    /// Of a reaction.
    pub execution_ns: Option<i64>,
    /// Latencies between hosts.
    pub hosts: Vec<HostLatency>,
    /// Latencies of connections, by their names in the plan.
    pub connections: BTreeMap<String, i64>,
    /// The bounds of single federates.
    pub federates: BTreeMap<String, FederateBounds>,
    /// The execution of every reaction of a reactor.
    pub reactors: BTreeMap<String, i64>,
    /// The execution of reactions, by their names in the plan.
    pub reactions: BTreeMap<String, i64>,
}

/// The latency between two hosts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostLatency {
    /// The hosts, as `at` names them; `localhost` for federates without one.
    pub between: [String; 2],
    /// In nanoseconds.
    pub latency_ns: i64,
}

/// The bounds of a federate, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FederateBounds {
    /// Between its clock and the RTI's.
    pub clock_error_ns: Option<i64>,
    /// From the earliest possible begin of a tag to its last message of the tag.
    pub lag_ns: Option<i64>,
}

/// A bound that is necessary and missing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MissingBound {
    /// The latency of this connection.
    Latency(String),
    /// The difference of the clocks of these federates.
    ClockError(String, String),
    /// The execution of this reaction.
    Execution(String),
}

impl fmt::Display for MissingBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latency(name) => write!(f, "nothing bounds the latency of `{name}`; say `latency: 5 ms`"),
            Self::ClockError(one, other) => {
                write!(f, "nothing bounds the clock error between {one} and {other}; say `clock-error: 100 us`")
            }
            Self::Execution(name) => write!(f, "nothing bounds the execution of `{name}`; say `execution: 200 us`"),
        }
    }
}

impl Bounds {
    /// Reads a file of bounds and checks it against the program.
    ///
    /// # Errors
    /// Returns all errors of the file, in the order of its lines; only the first one if the file is not valid YAML or
    /// has a key or a value of the wrong kind.
    pub fn parse(path: &str, text: &str, plan: &Plan) -> Result<Self, Vec<FileError>> {
        let raw: RawBounds = yaml::read(path, text).map_err(|error| vec![error])?;
        let mut reader = BoundsReader { path, plan, errors: Vec::new() };
        let bounds = reader.bounds(&raw);
        reader.errors.sort_by_key(|error| (error.line, error.column));
        if reader.errors.is_empty() { Ok(bounds) } else { Err(reader.errors) }
    }

    /// Returns the file with these bounds.
    pub fn to_yaml(&self) -> String {
        let mut text = String::new();
        for (key, ns) in
            [("latency", self.latency_ns), ("clock-error", self.clock_error_ns), ("execution", self.execution_ns)]
        {
            if let Some(ns) = ns {
                let _ = writeln!(text, "{key}: {}", Time(ns));
            }
        }
        if !self.hosts.is_empty() {
            text.push_str("hosts:\n");
        }
        for HostLatency { between: [one, other], latency_ns } in &self.hosts {
            let _ = writeln!(text, "  - {{ between: [\"{one}\", \"{other}\"], latency: {} }}", Time(*latency_ns));
        }
        list(&mut text, "connections", &self.connections);
        if !self.federates.is_empty() {
            text.push_str("federates:\n");
        }
        for (name, federate) in &self.federates {
            let _ = writeln!(text, "  {name}:");
            for (key, ns) in [("clock-error", federate.clock_error_ns), ("lag", federate.lag_ns)] {
                if let Some(ns) = ns {
                    let _ = writeln!(text, "    {key}: {}", Time(ns));
                }
            }
        }
        list(&mut text, "reactors", &self.reactors);
        list(&mut text, "reactions", &self.reactions);
        text
    }

    /// Returns the bound of the latency of a connection into a federate.
    pub(super) fn latency(&self, plan: &Plan, to: &Federate, input: &NetworkInput) -> Option<i64> {
        let host = |federate: &Federate| federate.host.clone().unwrap_or_else(|| "localhost".to_owned());
        let (one, other) = (host(&plan.federates[usize::from(input.federate)]), host(to));
        let same = |hosts: &HostLatency| {
            hosts.between == [one.clone(), other.clone()] || hosts.between == [other.clone(), one.clone()]
        };
        let of_hosts = || self.hosts.iter().find(|hosts| same(hosts)).map(|hosts| hosts.latency_ns);
        self.connections.get(&input.name).copied().or_else(of_hosts).or(self.latency_ns)
    }

    /// Returns the bound of the difference between two clocks.
    pub(super) fn clock_error(&self, one: &Federate, other: &Federate) -> Option<i64> {
        let own = |federate: &Federate| self.federates.get(&federate.name).and_then(|bounds| bounds.clock_error_ns);
        match (own(one), own(other)) {
            (Some(one), Some(other)) => Some(one.saturating_add(other)),
            _ => self.clock_error_ns,
        }
    }

    /// Returns the bound of a reaction's execution.
    pub(super) fn execution(&self, plan: &Plan, federate: &Federate, reaction: &ScheduledReaction) -> Option<i64> {
        let ReactionKind::Body { instance, .. } = &reaction.kind else { return Some(0) };
        let class = &plan.class(&federate.instances[instance.0]).name;
        self.reactions.get(&reaction.name).or_else(|| self.reactors.get(class)).copied().or(self.execution_ns)
    }

    /// Returns the bound of a federate's time from the earliest possible begin of a tag to sending: its lag, or the
    /// execution of the reactions that come before.
    pub(super) fn lag(&self, plan: &Plan, federate: &Federate, before: usize) -> Result<i64, MissingBound> {
        if let Some(lag_ns) = self.federates.get(&federate.name).and_then(|bounds| bounds.lag_ns) {
            return Ok(lag_ns);
        }
        federate.reactions[..before].iter().try_fold(0_i64, |sum, reaction| {
            let execution = self.execution(plan, federate, reaction);
            let execution = execution.ok_or_else(|| MissingBound::Execution(reaction.name.clone()))?;
            Ok(sum.saturating_add(execution))
        })
    }
}

fn list(text: &mut String, key: &str, times: &BTreeMap<String, i64>) {
    if !times.is_empty() {
        let _ = writeln!(text, "{key}:");
    }
    for (name, ns) in times {
        let _ = writeln!(text, "  {name}: {}", Time(*ns));
    }
}

/// Reads a time from 0 on: `5 ms`, `1.2us`, `0`.
///
/// # Errors
/// Returns a sentence about the error.
pub fn parse_time(text: &str) -> Result<i64, String> {
    match number_and_unit(text) {
        // The unit of 0 is optional.
        (number, "") => match nanoseconds(number, "s") {
            Ok(0) => Ok(0),
            Ok(_) => Err(format!("`{number}` needs a unit of time, like `{number} ms`")),
            Err(error) => Err(error.to_string()),
        },
        (number, unit) => nanoseconds(number, unit).map_err(|error| error.to_string()),
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
struct RawBounds {
    latency: Option<Spanned<String>>,
    clock_error: Option<Spanned<String>>,
    execution: Option<Spanned<String>>,
    hosts: Vec<RawHosts>,
    connections: BTreeMap<String, Spanned<String>>,
    federates: BTreeMap<String, Spanned<RawFederate>>,
    reactors: BTreeMap<String, Spanned<String>>,
    reactions: BTreeMap<String, Spanned<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHosts {
    between: Vec<Spanned<String>>,
    latency: Spanned<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
struct RawFederate {
    clock_error: Option<Spanned<String>>,
    lag: Option<Spanned<String>>,
}

struct BoundsReader<'a> {
    path: &'a str,
    plan: &'a Plan,
    errors: Vec<FileError>,
}

impl BoundsReader<'_> {
    fn bounds(&mut self, raw: &RawBounds) -> Bounds {
        let plan = self.plan;
        let federates = &plan.federates;
        let connections = federates.iter().flat_map(|federate| &federate.inputs).filter(|input| !input.physical);
        let connections: Vec<&str> = connections.map(|input| input.name.as_str()).collect();
        let names: Vec<&str> = federates.iter().map(|federate| federate.name.as_str()).collect();
        let reactors: Vec<&str> = plan.classes.iter().map(|class| class.name.as_str()).collect();
        let reactions = federates.iter().flat_map(|federate| &federate.reactions);
        let reactions = reactions.filter(|reaction| matches!(reaction.kind, ReactionKind::Body { .. }));
        let reactions: Vec<&str> = reactions.map(|reaction| reaction.name.as_str()).collect();
        let mut known = BTreeMap::new();
        for (name, federate) in &raw.federates {
            self.known(name, federate.referenced, "federate", &names);
            let clock_error_ns = self.time(federate.value.clock_error.as_ref());
            let lag_ns = self.time(federate.value.lag.as_ref());
            known.insert(name.clone(), FederateBounds { clock_error_ns, lag_ns });
        }
        Bounds {
            latency_ns: self.time(raw.latency.as_ref()),
            clock_error_ns: self.time(raw.clock_error.as_ref()),
            execution_ns: self.time(raw.execution.as_ref()),
            hosts: raw.hosts.iter().filter_map(|hosts| self.hosts(hosts)).collect(),
            connections: self.times(&raw.connections, "connection", &connections),
            federates: known,
            reactors: self.times(&raw.reactors, "reactor", &reactors),
            reactions: self.times(&raw.reactions, "reaction", &reactions),
        }
    }

    fn times(&mut self, raw: &BTreeMap<String, Spanned<String>>, what: &str, names: &[&str]) -> BTreeMap<String, i64> {
        let mut times = BTreeMap::new();
        for (name, time) in raw {
            self.known(name, time.referenced, what, names);
            if let Some(ns) = self.time(Some(time)) {
                times.insert(name.clone(), ns);
            }
        }
        times
    }

    fn hosts(&mut self, raw: &RawHosts) -> Option<HostLatency> {
        let latency_ns = self.time(Some(&raw.latency))?;
        let [one, other] = &raw.between[..] else {
            self.error(raw.latency.referenced, "`between` names two hosts".to_owned(), None);
            return None;
        };
        let federates = &self.plan.federates;
        let names: Vec<&str> =
            federates.iter().map(|federate| federate.host.as_deref().unwrap_or("localhost")).collect();
        for host in [one, other] {
            self.known(&host.value, host.referenced, "host", &names);
        }
        Some(HostLatency { between: [one.value.clone(), other.value.clone()], latency_ns })
    }

    fn known(&mut self, name: &str, at: Location, what: &str, names: &[&str]) {
        if !names.contains(&name) {
            let message = format!("{} has no {what} named \"{name}\"", self.plan.name);
            self.error(at, message, did_you_mean(name, names.iter().copied()));
        }
    }

    fn time(&mut self, text: Option<&Spanned<String>>) -> Option<i64> {
        let text = text?;
        match parse_time(&text.value) {
            Ok(ns) => Some(ns),
            Err(message) => {
                self.error(text.referenced, message, None);
                None
            }
        }
    }

    fn error(&mut self, at: Location, message: String, hint: Option<String>) {
        let (line, column) = yaml::place(at);
        self.errors.push(FileError { path: self.path.to_owned(), line, column, message, hint });
    }
}
