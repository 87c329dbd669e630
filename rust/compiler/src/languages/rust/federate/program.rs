// SPDX-License-Identifier: Apache-2.0
//! The implementation of `Program`: from numbers to fields and methods. What a program does not have, the trait's own
//! methods say.

use lf_model::PortId;

use super::module::Module;
use crate::languages::rust::reactor::{deadline_method, reaction_method, tardy_method};
use crate::languages::rust::sending::serializer_type;
use crate::plan::{Argument, Reaction, ReactionKind, ScheduledReaction, Serializer, Tardy, VariableKind};
use crate::tables::Cell;

/// Signatures of the methods, what each matches on, and what it answers for others.
const REACT: [&str; 3] = ["react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const MISS: [&str; 3] =
    ["miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const TARDY: [&str; 3] =
    ["handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>)", "reaction", "{}"];
const PORT: [&str; 3] = ["port(&mut self, port: PortId) -> Option<&mut dyn PortCell>", "port", "None,"];
const TRIGGER: [&str; 3] =
    ["trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell>", "trigger", "None,"];
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

impl Module<'_> {
    /// `impl Program for …`.
    pub(super) fn program(&self, owner: &str) -> String {
        let tables = &self.tables;
        let trigger = |index: usize| &self.symbols.triggers[index];
        let reacts = self.reactions(|number, _| Some(reaction_method(number)));
        let misses = self.reactions(|number, declared| declared.deadline.as_ref().map(|_| deadline_method(number)));
        let handles = self.reactions(|number, declared| match declared.tardy.as_ref()? {
            Tardy::Handler(_) => Some(tardy_method(number)),
            Tardy::Body => Some(reaction_method(number)),
        });
        let ports = (0..tables.ports.len()).map(|id| format!("PortId({id}) => Some(&mut {})", self.port_place(id)));
        let triggers = tables.triggers.iter().enumerate().filter(|(_, row)| row.cell != Cell::None);
        let triggers = triggers.map(|(id, _)| format!("TriggerId({id}) => Some(&mut self.{})", trigger(id)));
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
        let methods = [
            (REACT, reacts),
            (MISS, misses),
            (TARDY, if tables.has_tardy_inputs() { handles } else { Vec::new() }),
            (PORT, ports.collect()),
            (TRIGGER, triggers.collect()),
            (CAPTURE, captures.collect()),
            (ENCODE, encodes.collect()),
            (DELIVER, delivers.collect()),
            (DELIVER_TARDY, tardies.collect()),
        ];
        for ([signature, id, otherwise], arms) in methods {
            if arms.is_empty() {
                continue;
            }
            text = text + "\n    fn " + signature + " {\n        match " + id + " {\n";
            for arm in arms {
                text = text + "            " + &arm + ",\n";
            }
            text = text + "            _ => " + otherwise + "\n        }\n    }\n";
        }
        text + "}\n"
    }

    /// What the names of methods that make bytes of values end with, where a serializer is given.
    fn by(&self, serializer: Option<&Serializer>, port: PortId) -> String {
        // A type that cannot be named has been refused when the tables were made.
        let ty = self.port_type(port).unwrap_or_default();
        serializer.map(|serializer| format!("_by::<{}>", serializer_type(serializer, &ty))).unwrap_or_default()
    }

    /// One arm per reaction with a body for which there is a method.
    fn reactions(&self, method: impl Fn(usize, &Reaction) -> Option<proc_macro2::Ident>) -> Vec<String> {
        let arm = |(id, reaction): (usize, &ScheduledReaction)| {
            let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
            let declared = &self.plan.class(&self.federate.instances[instance.0]).reactions[number - 1];
            let method = method(*number, declared)?;
            let field = &self.symbols.instances[instance.0];
            let arguments = declared.parameters.iter().zip(arguments).map(|(parameter, argument)| {
                let mutable = if parameter.effect && parameter.kind != VariableKind::Timer { "mut " } else { "" };
                match argument {
                    Argument::Port(port) => format!(", &{mutable}{}", self.port_place(port.0)),
                    Argument::Ports(ports) => {
                        let places = ports.iter().map(|port| format!("&{mutable}{}", self.port_place(port.0)));
                        let places = places.collect::<Vec<_>>().join(", ");
                        let name = if mutable.is_empty() { "Multiport" } else { "MultiportMut" };
                        format!(", &{mutable}{name}::new(&{mutable}[{places}])")
                    }
                    Argument::Trigger(trigger) => format!(", &{mutable}self.{}", self.symbols.triggers[trigger.0]),
                }
            });
            Some(format!("ReactionId({id}) => self.{field}.{method}(ctx{})", arguments.collect::<String>()))
        };
        self.federate.reactions.iter().enumerate().filter_map(arm).collect()
    }
}
