// SPDX-License-Identifier: Apache-2.0
//! The implementation of `Program`: maps numbers to fields and methods. The trait's own methods remain for all parts
//! that a program does not have.

use super::arms::{arms_in_turn, merge, reaction_arm};
use super::bodies::ReactionPart;
use super::module::FederateModule;
use crate::tables::{Cell, TriggerRow};

/// Signatures of the methods, the value that each matches on, and its result for other values.
const REACT: [&str; 3] = ["react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const MISS: [&str; 3] =
    ["miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const TARDY: [&str; 3] =
    ["handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const SHARE: [&str; 3] = ["share(&mut self, number: u16, level: &mut Level<'_>)", "number", "{}"];
const CLEAR_PORT: [&str; 3] = ["clear_port(&mut self, port: PortId)", "port", "{}"];
const TRIGGER: [&str; 3] =
    ["trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell>", "trigger", "None,"];
const IN_MODE: [&str; 3] = ["in_mode(&mut self, trigger: TriggerId) -> Option<&mut dyn ModeCell>", "trigger", "None,"];
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

const HAND_OVER: [&str; 3] = [
    "hand_over(&self, state: u16, bytes: &mut [u8]) -> Result<usize, PayloadError>",
    "state",
    "Err(PayloadError::Absent),",
];
const TAKE_OVER: [&str; 3] = [
    "take_over(&mut self, state: u16, bytes: &[u8]) -> Result<(), PayloadError>",
    "state",
    "Err(PayloadError::Absent),",
];

impl FederateModule<'_> {
    /// Returns `impl Program for …`.
    pub(super) fn program(&self, owner: &str) -> String {
        let tables = &self.owner.tables;
        let trigger = |index: usize| &self.owner.symbols.triggers[index];
        let calls = |part: ReactionPart| self.bodies.reactions(&self.owner, part);
        let arms = |part: ReactionPart| calls(part).iter().map(reaction_arm).collect();
        let in_turn = |id: usize| tables.runs_in_turn(id) && self.owner.job.workers() < 2;
        let clears = (0..tables.ports.len()).map(|id| format!("PortId({id}) => {}.clear()", self.port(id)));
        let triggers = tables.triggers.iter().enumerate().filter(|(_, row)| row.cell != Cell::None);
        let triggers = triggers.map(|(id, _)| format!("TriggerId({id}) => Some(&mut {})", trigger(id)));
        let is_queue = |row: &TriggerRow<'_>| row.mode.is_some() && row.cell != Cell::Timer;
        let in_modes = tables.triggers.iter().enumerate().filter(|(_, row)| is_queue(row));
        let in_modes = in_modes.map(|(id, _)| format!("TriggerId({id}) => Some(&mut {})", trigger(id)));
        let captures = tables.triggers.iter().enumerate().filter_map(|(id, row)| {
            let source = self.port(usize::from(row.captures?.0));
            Some(format!("TriggerId({id}) => {}.capture(tag, &{source})", trigger(id)))
        });
        let encodes = tables.outputs.iter().enumerate().map(|(id, output)| {
            let by = self.by(self.owner.federate.outputs[id].serializer.as_ref(), output.source);
            format!("OutputId({id}) => {}.encode{by}(bytes)", self.port(usize::from(output.source.0)))
        });
        let inputs = || tables.inputs.iter().enumerate();
        let queue = |input: &crate::tables::InputRow<'_>| trigger(usize::from(input.trigger.0));
        let by = |id: usize, input: &crate::tables::InputRow<'_>| {
            self.by(self.owner.federate.inputs[id].serializer.as_ref(), input.fills)
        };
        let delivers = inputs()
            .map(|(id, input)| format!("InputId({id}) => {}.deliver{}(tag, bytes)", queue(input), by(id, input)));
        let tardies = inputs().filter(|(_, input)| input.tardy).map(|(id, input)| {
            let by = by(id, input);
            format!("InputId({id}) => {}.deliver_tardy{by}(tag, intended, bytes)", queue(input))
        });
        let [handed_over, taken_over] = self.bodies.handovers(&self.owner);
        let mut text = format!(
            "impl Program for {owner} {{\n    fn tables(&self) -> &'static Tables {{\n        &TABLES\n    }}\n"
        );
        push_methods(
            &mut text,
            [
                (REACT, arms_in_turn(&calls(ReactionPart::Body), in_turn)),
                (MISS, arms(ReactionPart::MissedDeadline)),
                (TARDY, if tables.has_tardy_inputs() { arms(ReactionPart::Tardy) } else { Vec::new() }),
                (SHARE, self.bodies.shares(&self.owner)),
                (CLEAR_PORT, clears.collect()),
                (TRIGGER, triggers.collect()),
                (CAPTURE, captures.collect()),
                (ENCODE, encodes.collect()),
                (DELIVER, delivers.collect()),
                (DELIVER_TARDY, tardies.collect()),
                (HAND_OVER, handed_over),
                (TAKE_OVER, taken_over),
            ],
        );
        if tables.modes.is_empty() {
            return text + "}\n" + &self.bodies.implementations(&self.owner, owner);
        }
        text.push_str("\n    fn modes(&mut self) -> Option<&mut dyn ModeCells> {\n        Some(self)\n    }\n}\n\n");
        text = text + "impl ModeCells for " + owner + " {\n";
        push_methods(&mut text, [(IN_MODE, in_modes.collect()), (RESET_MODE, self.bodies.resets(&self.owner))]);
        text.replace(" {\n\n", " {\n") + "}\n" + &self.bodies.implementations(&self.owner, owner)
    }
}

/// Adds the methods that have arms, and merges these.
pub(in crate::emit) fn push_methods<const N: usize>(text: &mut String, methods: [([&str; 3], Vec<String>); N]) {
    for ([signature, id, otherwise], arms) in methods {
        if arms.is_empty() {
            continue;
        }
        text.extend(["\n    fn ", signature, " {\n        match ", id, " {\n"]);
        let arms = merge(&arms);
        let is_whole = arms.iter().any(|arm| arm.starts_with("_ => "));
        text.extend(arms.iter().flat_map(|arm| ["            ", arm, ",\n"]));
        if !is_whole {
            text.extend(["            _ => ", otherwise, "\n"]);
        }
        text.push_str("        }\n    }\n");
    }
}
