// SPDX-License-Identifier: Apache-2.0
//! The implementation of `Program`: from numbers to fields and methods. What a program does not have, the trait's own
//! methods say.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use lf_model::{PortId, ReactionId, TriggerId};
use proc_macro2::Ident;

use super::module::FederateModule;
use super::tables::ids;
use crate::languages::rust::reactor::{deadline_method, reaction_method, reset_method, tardy_method};
use crate::languages::rust::sending::serializer_type;
use crate::plan::{
    Argument, Mode, ModeIndex, Reaction, ReactionKind, ScheduledReaction, Serializer, Tardy, VariableKind,
};
use crate::tables::{Cell, TriggerRow};

/// Signatures of the methods, what each matches on, and what it answers for others.
const REACT: [&str; 3] = ["react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const MISS: [&str; 3] =
    ["miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const TARDY: [&str; 3] =
    ["handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const SHARE: [&str; 3] = ["share(&mut self, number: u16, level: &mut Level<'_>)", "number", "{}"];
const PORT: [&str; 3] = ["port(&mut self, port: PortId) -> Option<&mut dyn PortCell>", "port", "None,"];
const TRIGGER: [&str; 3] =
    ["trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell>", "trigger", "None,"];
const IN_MODE: [&str; 3] = ["in_mode(&mut self, trigger: TriggerId) -> Option<&mut dyn ModeCell>", "trigger", "None,"];
const ACTION: [&str; 3] =
    ["action(&mut self, trigger: TriggerId) -> Option<&mut dyn Schedulable<Value = c::Token>>", "trigger", "None,"];
const WATCHDOG: [&str; 3] = ["watchdog(&mut self, trigger: TriggerId) -> Option<&mut Watchdog>", "trigger", "None,"];
const INBOX: [&str; 3] = ["inbox(trigger: TriggerId) -> Option<&'static dyn Inbox<c::Token>>", "trigger", "None,"];
const RESET_MODE: [&str; 3] = ["reset_mode(&mut self, mode: ModeId)", "mode", "{}"];
const CAPTURE: [&str; 3] =
    ["capture(&mut self, trigger: TriggerId, tag: Tag) -> Result<(), Full>", "trigger", "Ok(()),"];
const ENCODE: [&str; 3] = [
    "encode(&self, output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError>",
    "output",
    "Err(PayloadError::Absent),",
];
const DELIVER: [&str; 3] = [
    "deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered>",
    "input",
    "Err(Undelivered::NoSuchPort),",
];
const DELIVER_TARDY: [&str; 3] = [
    "deliver_tardy(&mut self, input: InputId, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered>",
    "input",
    "Err(Undelivered::NoSuchPort),",
];

impl FederateModule<'_> {
    /// `impl Program for …`.
    pub(super) fn program(&self, owner: &str) -> String {
        let tables = &self.tables;
        let trigger = |index: usize| &self.symbols.triggers[index];
        let reacts = self.reactions("react", |number, _| Some(reaction_method(number)));
        let misses = self.reactions("miss_deadline", miss_method);
        let handles = self.reactions("handle_tardy", handler_method);
        let ports = (0..tables.ports.len()).map(|id| format!("PortId({id}) => Some(&mut {})", self.port_place(id)));
        let triggers = tables.triggers.iter().enumerate().filter(|(_, row)| row.cell != Cell::None);
        let triggers = triggers.map(|(id, _)| format!("TriggerId({id}) => Some(&mut self.{})", trigger(id)));
        let is_queue = |row: &TriggerRow<'_>| row.mode.is_some() && row.cell != Cell::Timer;
        let in_modes = tables.triggers.iter().enumerate().filter(|(_, row)| is_queue(row));
        let in_modes = in_modes.map(|(id, _)| format!("TriggerId({id}) => Some(&mut self.{})", trigger(id)));
        let captures = tables.triggers.iter().enumerate().filter_map(|(id, row)| {
            let source = self.port_place(usize::from(row.captures?.0));
            Some(format!("TriggerId({id}) => self.{}.capture(tag, &{source})", trigger(id)))
        });
        let encodes = tables.outputs.iter().enumerate().map(|(id, output)| {
            let by = self.by(self.federate.outputs[id].serializer.as_ref(), output.source);
            format!("OutputId({id}) => {}.encode{by}(bytes)", self.port_place(usize::from(output.source.0)))
        });
        let inputs = || tables.inputs.iter().enumerate();
        let queue = |input: &crate::tables::InputRow<'_>| trigger(usize::from(input.trigger.0));
        let by = |id: usize, input: &crate::tables::InputRow<'_>| {
            self.by(self.federate.inputs[id].serializer.as_ref(), input.fills)
        };
        let delivers = inputs()
            .map(|(id, input)| format!("InputId({id}) => self.{}.deliver{}(tag, bytes)", queue(input), by(id, input)));
        let tardies = inputs().filter(|(_, input)| input.tardy).map(|(id, input)| {
            let by = by(id, input);
            format!("InputId({id}) => self.{}.deliver_tardy{by}(tag, intended, bytes)", queue(input))
        });
        let mut text = format!(
            "impl Program for {owner} {{\n    fn tables(&self) -> &'static Tables {{\n        &TABLES\n    }}\n"
        );
        push_methods(
            &mut text,
            [
                (REACT, reacts),
                (MISS, misses),
                (TARDY, if tables.has_tardy_inputs() { handles } else { Vec::new() }),
                (SHARE, self.shares()),
                (PORT, ports.collect()),
                (TRIGGER, triggers.collect()),
                (CAPTURE, captures.collect()),
                (ENCODE, encodes.collect()),
                (DELIVER, delivers.collect()),
                (DELIVER_TARDY, tardies.collect()),
            ],
        );
        if tables.modes.is_empty() {
            return text + "}\n" + &self.bodies_in_c(owner);
        }
        text.push_str("\n    fn modes(&mut self) -> Option<&mut dyn ModeCells> {\n        Some(self)\n    }\n}\n\n");
        text = text + "impl ModeCells for " + owner + " {\n";
        push_methods(&mut text, [(IN_MODE, in_modes.collect()), (RESET_MODE, self.resets())]);
        text.replace(" {\n\n", " {\n") + "}\n" + &self.bodies_in_c(owner)
    }

    /// What bodies in C reach by number.
    fn bodies_in_c(&self, owner: &str) -> String {
        if self.layout().is_some() {
            return String::new();
        }
        let inboxes = self.tables.triggers.iter().enumerate().filter(|(_, row)| row.cell == Cell::Physical);
        let inboxes = inboxes.map(|(id, _)| format!("TriggerId({id}) => Some(&{})", self.symbols.inboxes[id]));
        let actions = self.cells(&[Cell::Logical, Cell::Physical]);
        let mut text = format!("\nimpl c::Bodies for {owner} {{\n");
        push_methods(
            &mut text,
            [(ACTION, actions), (WATCHDOG, self.cells(&[Cell::Watchdog])), (INBOX, inboxes.collect())],
        );
        text.replace(" {\n\n", " {\n") + "}\n"
    }

    /// The cells of these kinds, by trigger, for bodies in C.
    fn cells(&self, kinds: &[Cell]) -> Vec<String> {
        let cells = self.tables.triggers.iter().enumerate().filter(|(_, row)| kinds.contains(&row.cell));
        cells.map(|(id, _)| format!("TriggerId({id}) => Some(&mut self.{})", self.symbols.triggers[id])).collect()
    }

    /// What the names of methods that make bytes of values end with, where a serializer is given.
    fn by(&self, serializer: Option<&Serializer>, port: PortId) -> String {
        // A type that cannot be named has been refused when the tables were made.
        let ty = self.port_type(port).unwrap_or_default();
        serializer.map(|serializer| format!("_by::<{}>", serializer_type(serializer, &ty))).unwrap_or_default()
    }

    /// One arm per mode with `reset` state variables.
    fn resets(&self) -> Vec<String> {
        if self.layout().is_none() {
            return vec!["_ => c::reset_mode(mode)".to_owned()];
        }
        let arm = |(id, mode): (usize, &Mode)| {
            let mut calls = String::new();
            for (index, instance) in self.federate.instances.iter().enumerate() {
                let own = (mode.instance.0 == index).then_some(Some(mode.declared));
                let whole = (instance.mode == Some(ModeIndex(id))).then_some(None);
                let class = self.plan.class(instance);
                for of in [own, whole].into_iter().flatten().filter(|of| class.has_resets(*of)) {
                    let _ = write!(calls, "self.{}.{}(); ", self.symbols.instances[index], reset_method(of));
                }
            }
            (!calls.is_empty()).then(|| format!("ModeId({id}) => {{ {calls}}}"))
        };
        self.federate.modes.iter().enumerate().filter_map(arm).collect()
    }

    /// One arm per reaction with a body for which there is a method. In C, there is a function for all of them.
    fn reactions(&self, function: &str, method: impl Fn(usize, &Reaction) -> Option<Ident>) -> Vec<String> {
        let of_c = self.layout().is_none();
        let arm = |(id, reaction): (usize, &ScheduledReaction)| {
            let call = match &reaction.kind {
                ReactionKind::Copy { from, to } if function == "react" => {
                    let (from, to) = (self.port_place(from.0), self.port_place(to.0));
                    let copy = if of_c { "c::copy(ctx, " } else { "ctx.copy(" };
                    format!("{copy}&{from}, &mut {to})")
                }
                _ => self.call(reaction, &method)?,
            };
            Some((format!("ReactionId({id}) => {call}"), matches!(reaction.kind, ReactionKind::Copy { .. })))
        };
        let arms = self.federate.reactions.iter().enumerate().filter_map(arm);
        let (copies, bodies): (Vec<_>, Vec<_>) = arms.partition(|(_, is_copy)| of_c && *is_copy);
        let of_c = (of_c && !bodies.is_empty()).then(|| format!("_ => c::{function}(self, reaction, ctx)"));
        let bodies = bodies.into_iter().filter(|_| self.layout().is_some());
        copies.into_iter().chain(bodies).map(|(arm, _)| arm).chain(of_c).collect()
    }

    /// The call of a method of a reaction with a body, if there is that method.
    fn call(&self, reaction: &ScheduledReaction, method: impl Fn(usize, &Reaction) -> Option<Ident>) -> Option<String> {
        let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
        let declared = &self.plan.class(&self.federate.instances[instance.0]).reactions[number - 1];
        let method = method(*number, declared)?;
        let field = &self.symbols.instances[instance.0];
        let arguments = declared.parameters.iter().zip(arguments).map(|(parameter, argument)| {
            let mutable = if parameter.effect && parameter.kind != VariableKind::Timer { "mut " } else { "" };
            match argument {
                Argument::Port(port) => format!(", &{mutable}{}", self.port_place(port.0)),
                Argument::Ports(ports) | Argument::Bank { ports, .. } => {
                    let places = ports.iter().map(|port| format!("&{mutable}{}", self.port_place(port.0)));
                    let places = places.collect::<Vec<_>>().join(", ");
                    let name = if mutable.is_empty() { "Multiport" } else { "MultiportMut" };
                    format!(", &{mutable}{name}::new(&{mutable}[{places}])")
                }
                Argument::Trigger(trigger) => format!(", &{mutable}self.{}", self.symbols.triggers[trigger.0]),
                Argument::Mode(mode) => {
                    let is_history = matches!(parameter.kind, VariableKind::Mode { history: true });
                    format!(", Transition::{}(ModeId({mode}))", if is_history { "history" } else { "reset" })
                }
            }
        });
        Some(format!("self.{field}.{method}(ctx{})", arguments.collect::<String>()))
    }

    /// One arm per level at which several instances have reactions, where there are threads for them. Copies are left
    /// to the engine: two of different modes have one port to set.
    fn shares(&self) -> Vec<String> {
        if self.workers() < 2 {
            return Vec::new();
        }
        let mut levels: BTreeMap<u16, BTreeMap<usize, Vec<ReactionId>>> = BTreeMap::new();
        for (id, (reaction, row)) in (0..).zip(self.federate.reactions.iter().zip(&self.tables.reactions)) {
            if let ReactionKind::Body { instance, .. } = reaction.kind {
                levels.entry(row.level).or_default().entry(instance.0).or_default().push(ReactionId(id));
            }
        }
        let arm = |(level, instances): (u16, BTreeMap<usize, Vec<ReactionId>>)| {
            // The reactions of one instance are in different modes. They share what they change, so they are one job.
            let mut groups: Vec<_> = instances.into_values().collect();
            groups.sort_by_key(|reactions| reactions[0].0);
            let jobs: Vec<String> = groups.iter().map(|reactions| self.job(reactions)).collect();
            let (jobs, workers) = (jobs.join(",\n                "), self.workers());
            let run = format!("level.run::<{workers}, {{ TABLES.note_words() }}>(&lf::Threads::<{workers}>, ");
            (groups.len() > 1).then(|| format!("{level} => {run}&mut [\n                {jobs},\n            ])"))
        };
        levels.into_iter().filter_map(arm).collect()
    }

    /// Reactions of one instance as a job.
    fn job(&self, reactions: &[ReactionId]) -> String {
        let (mut actions, mut calls) = (Vec::new(), Vec::new());
        for id in reactions {
            let reaction = &self.federate.reactions[usize::from(id.0)];
            let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { continue };
            let declared = &self.plan.class(&self.federate.instances[instance.0]).reactions[number - 1];
            actions.extend(declared.parameters.iter().zip(arguments).filter_map(
                |(parameter, argument)| match argument {
                    Argument::Trigger(trigger) if parameter.effect => Some(TriggerId(u16::try_from(trigger.0).ok()?)),
                    _ => None,
                },
            ));
            let only = if reactions.len() == 1 { "_".to_owned() } else { format!("{id:?}") };
            calls.extend(
                self.call(reaction, miss_method).map(|call| format!("({only}, Part::MissedDeadline) => {call}")),
            );
            let handles = self.call(reaction, handler_method).filter(|_| self.tables.has_tardy_inputs());
            calls.extend(handles.map(|call| format!("({only}, Part::Tardy) => {call}")));
            let body = self.call(reaction, |number, _| Some(reaction_method(number)));
            calls.extend(body.map(|call| format!("({only}, _) => {call}")));
        }
        let run = match &calls[..] {
            [only] => only.replacen("(_, _) => ", "|_, _, ctx| ", 1),
            _ if reactions.len() == 1 => format!("|id, part, ctx| match (id, part) {{ {} }}", calls.join(", ")),
            _ => format!("|id, part, ctx| match (id, part) {{ {}, _ => {{}} }}", calls.join(", ")),
        };
        format!("Job::new({}, {}, &mut {run})", ids(reactions), ids(&actions))
    }
}

fn miss_method(number: usize, declared: &Reaction) -> Option<Ident> {
    declared.deadline.as_ref().map(|_| deadline_method(number))
}

fn handler_method(number: usize, declared: &Reaction) -> Option<Ident> {
    Some(match declared.tardy.as_ref()? {
        Tardy::Handler(_) => tardy_method(number),
        Tardy::Body => reaction_method(number),
    })
}

/// The methods that have arms.
fn push_methods<const N: usize>(text: &mut String, methods: [([&str; 3], Vec<String>); N]) {
    for ([signature, id, otherwise], arms) in methods {
        if arms.is_empty() {
            continue;
        }
        *text = format!("{text}\n    fn {signature} {{\n        match {id} {{\n");
        let is_whole = arms.iter().any(|arm| arm.starts_with("_ => "));
        for arm in arms {
            *text = format!("{text}            {arm},\n");
        }
        let otherwise = if is_whole { String::new() } else { format!("            _ => {otherwise}\n") };
        *text = format!("{text}{otherwise}        }}\n    }}\n");
    }
}
