// SPDX-License-Identifier: Apache-2.0
//! Facts that only the plan of a whole program has about its declarations: times, capacities, levels and waits.

use std::collections::BTreeSet;

use lf_compiler::diagnostics::Span;
use lf_compiler::maxwait::{Bounds, Offsets};
use lf_compiler::plan::{Federate, Location, NetworkInput, Plan, ReactionKind, Time, TriggerKind};
use lf_compiler::{SourceProvider as _, compile};

use super::asked::Asked;
use super::buffers::Buffers;

/// The file beside a program with the bounds of its federation, as `lfz run --measure bounds.yaml` writes it.
const BOUNDS: &str = "bounds.yaml";

/// The number of instances whose values are listed each by itself.
const LISTED_MAX: usize = 4;

/// The plan of a program, and the safe waits of its federates as far as bounds are known.
pub(super) struct Facts {
    plan: Plan,
    offsets: Option<Offsets>,
}

impl Facts {
    /// Returns the facts of the program whose main file is at a path, if it is correct.
    pub(super) fn of(buffers: &Buffers, path: &str) -> Option<Self> {
        let plan = compile(path, buffers).plan?;
        let beside = std::path::Path::new(path).with_file_name(BOUNDS);
        let bounds = beside.to_str().and_then(|file| Some((file, buffers.read(file).ok()?)));
        let bounds = bounds.and_then(|(file, text)| Bounds::parse(file, &text, &plan).ok());
        let offsets = bounds.filter(|_| plan.is_decentralized()).and_then(|bounds| Offsets::of(&plan, &bounds).ok());
        Some(Self { plan, offsets })
    }

    /// Returns the facts of a program with the file at a place: its own, or else another open one that imports it.
    pub(super) fn of_program_with(buffers: &Buffers, asked: &Asked<'_>) -> Option<Self> {
        let has_file = |facts: &Self| facts.plan.files.iter().any(|file| file.path == asked.path);
        let others = buffers.paths().filter(|path| *path != asked.path);
        let mut all = std::iter::once(asked.path).chain(others).filter_map(|path| Self::of(buffers, path));
        all.find(has_file)
    }

    /// Returns sentences about what is declared at a place.
    pub(super) fn about(&self, asked: &Asked<'_>, declared: Span) -> Vec<String> {
        let Some(at) = self.location(asked, declared) else { return Vec::new() };
        let mut lines = Vec::new();
        for federate in &self.plan.federates {
            if self.plan.is_federated() && federate.at == at {
                lines.extend(self.of_federate(federate));
            }
        }
        lines.extend(self.of_triggers(at));
        lines.extend(self.of_ports(at));
        lines.extend(self.of_reaction(at));
        lines
    }

    fn location(&self, asked: &Asked<'_>, span: Span) -> Option<Location> {
        let source = asked.names.sources().get(span.file)?;
        let file = self.plan.files.iter().position(|file| file.path == source.path())?;
        let place = source.position(span.start);
        Some(Location { file: lf_compiler::plan::FileIndex(file), line: place.line, column: place.column })
    }

    /// Returns the federates with the places of their instances, and how each of them waits.
    pub(super) fn waits(&self, path: &str) -> Vec<(Location, String)> {
        let is_here = |federate: &&Federate| self.plan.path(federate.at) == path;
        let all = self.plan.federates.iter().filter(|_| self.plan.is_federated()).filter(is_here);
        all.map(|federate| (federate.at, self.wait(federate))).collect()
    }

    /// Returns how a federate waits for others, in few words.
    fn wait(&self, federate: &Federate) -> String {
        let inputs = || federate.inputs.iter().filter(|input| !input.physical);
        let senders: BTreeSet<u16> = inputs().map(|input| input.federate).collect();
        let names: Vec<&str> = senders.iter().map(|id| self.name(*id)).collect();
        let names = names.join(", ");
        if names.is_empty() {
            return "waits for nobody".to_owned();
        }
        if !self.plan.is_decentralized() {
            return format!("waits for {names}");
        }
        let waits: BTreeSet<i64> = inputs().map(|input| input.max_wait_ns).collect();
        let (least, most) = (waits.first().copied().unwrap_or_default(), waits.last().copied().unwrap_or_default());
        let wait = match (least, most) {
            (_, 0) => "does not wait".to_owned(),
            (i64::MAX, _) => format!("waits until {names} told"),
            (least, most) if least == most => format!("waits {} for {names}", Time(most)),
            (least, most) => format!("waits {} to {} for {names}", Time(least), Time(most)),
        };
        match self.safe_wait(federate) {
            Some(safe) if safe > least => format!("{wait}; safe: {}", Time(safe)),
            _ => wait,
        }
    }

    /// Returns the least wait with which no message is late, in nanoseconds.
    fn safe_wait(&self, federate: &Federate) -> Option<i64> {
        let offsets = self.offsets.as_ref()?;
        offsets.federates.iter().find(|one| one.name == federate.name)?.offset_ns
    }

    fn name(&self, federate: u16) -> &str {
        self.plan.federates.get(usize::from(federate)).map_or("?", |federate| &federate.name)
    }

    fn of_federate(&self, federate: &Federate) -> Vec<String> {
        let mut lines = vec![format!("federate {}: {}", federate.id, self.wait(federate))];
        for upstream in &federate.upstream {
            let name = self.name(upstream.federate);
            lines.push(match upstream.delay_ns {
                None => format!("`{name}` sends without delay"),
                Some(0) => format!("`{name}` sends with a delay of at least one microstep"),
                Some(delay) => format!("`{name}` sends with a delay of at least {}", Time(delay)),
            });
        }
        if let Some(safe) = self.safe_wait(federate) {
            lines.push(format!("by `{BOUNDS}` the least safe `@maxwait` is {}", Time(safe)));
        }
        lines
    }

    /// Returns the times of a timer, an action or a watchdog.
    fn of_triggers(&self, at: Location) -> Vec<String> {
        let all = self.plan.federates.iter().flat_map(|federate| &federate.triggers);
        let told = all.filter(|trigger| trigger.at == Some(at)).filter_map(|trigger| {
            let line = match &trigger.kind {
                TriggerKind::Timer { offset_ns, period_ns, .. } => match period_ns {
                    Some(period) => format!("first at {}, then every {}", Time(*offset_ns), Time(*period)),
                    None => format!("once at {}", Time(*offset_ns)),
                },
                TriggerKind::Action { min_delay_ns, min_spacing_ns, .. } => {
                    let spacing = min_spacing_ns.map(|ns| format!(", minimum spacing {}", Time(ns)));
                    let spacing = spacing.unwrap_or_default();
                    format!("minimum delay {}{spacing}, capacity {}", Time(*min_delay_ns), trigger.capacity)
                }
                TriggerKind::Watchdog { timeout_ns, .. } => format!("timeout {}", Time(*timeout_ns)),
                _ => return None,
            };
            Some((trigger.path.as_str(), line))
        });
        merged(told)
    }

    /// Returns the levels of a port's readers, and where its messages come from.
    fn of_ports(&self, at: Location) -> Vec<String> {
        let mut told = Vec::new();
        for federate in &self.plan.federates {
            for port in federate.ports.iter().filter(|port| port.at == at) {
                let levels: BTreeSet<u16> =
                    port.reactions.iter().map(|reaction| federate.reactions[reaction.0].level).collect();
                if !levels.is_empty() {
                    told.push((port.path.as_str(), format!("read at level {}", listed(&levels))));
                }
            }
            for input in &federate.inputs {
                let trigger = &federate.triggers[input.trigger.0];
                let TriggerKind::NetworkInput { fills, .. } = trigger.kind else { continue };
                let port = &federate.ports[fills.0];
                if port.at == at {
                    told.push((port.path.as_str(), self.of_input(input, trigger.capacity)));
                }
            }
        }
        merged(told.into_iter())
    }

    fn of_input(&self, input: &NetworkInput, capacity: usize) -> String {
        let after = input.delay_ns.map(|ns| format!(" after {}", Time(ns))).unwrap_or_default();
        let wait = match input.max_wait_ns {
            _ if !self.plan.is_decentralized() || input.physical => String::new(),
            i64::MAX => ", waits until it is known".to_owned(),
            wait => format!(", waits {}", Time(wait)),
        };
        format!("messages of `{}`{after}, capacity {capacity}{wait}", self.name(input.federate))
    }

    fn of_reaction(&self, at: Location) -> Vec<String> {
        let mut told = Vec::new();
        for federate in &self.plan.federates {
            for scheduled in &federate.reactions {
                let ReactionKind::Body { instance, reaction, .. } = scheduled.kind else { continue };
                let instance = &federate.instances[instance.0];
                let class = self.plan.class(instance);
                if class.reactions.get(reaction - 1).is_some_and(|one| one.at == at) {
                    let deadline = scheduled.deadline_ns.map(|ns| format!(", deadline {}", Time(ns)));
                    let line = format!("level {}{}", scheduled.level, deadline.unwrap_or_default());
                    told.push((instance.path.as_str(), line));
                }
            }
        }
        merged(told.into_iter())
    }
}

/// Returns each sentence once: alone where it is true of all instances, or else with the instances that it is about.
fn merged<'p>(told: impl Iterator<Item = (&'p str, String)>) -> Vec<String> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for (path, line) in told {
        match all.iter_mut().find(|(known, _)| *known == line) {
            Some((_, paths)) => paths.push(path),
            None => all.push((line, vec![path])),
        }
    }
    let all_paths: BTreeSet<&str> = all.iter().flat_map(|(_, paths)| paths.iter().copied()).collect();
    if all.len() == 1 || all_paths.len() == 1 {
        return all.into_iter().map(|(line, _)| line).collect();
    }
    let rest = all.len().saturating_sub(LISTED_MAX);
    let mut lines: Vec<String> = all
        .iter()
        .take(LISTED_MAX)
        .map(|(line, paths)| {
            let more = if paths.len() > 1 { format!(" and {} more", paths.len() - 1) } else { String::new() };
            format!("`{}`{more}: {line}", paths[0])
        })
        .collect();
    if rest > 0 {
        lines.push(format!("{rest} further ones"));
    }
    lines
}

fn listed(levels: &BTreeSet<u16>) -> String {
    levels.iter().map(u16::to_string).collect::<Vec<_>>().join(", ")
}
