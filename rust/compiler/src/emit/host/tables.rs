// SPDX-License-Identifier: Apache-2.0
//! The tables of a federate as Rust: a row per line, without the fields that equal `DEFAULT`.

use lf_model::time::Interval;
use lf_model::{ActionTiming, ModeId, ModeTrigger, Policy, ReactionKind, TriggerKind};

use super::module::FederateModule;
use super::print::{Fields, interval, optional};
use crate::emit::EmitError;
use crate::tables::{HandedOverRow, ModeEvents};

impl FederateModule<'_> {
    /// Returns the tables, which are checked at compile time.
    pub(super) fn tables_text(&self) -> Result<String, EmitError> {
        let mut text = self.modes_text();
        text.push_str("/// The tables of this program for the engine.\npub const TABLES: Tables = Tables {\n");
        let tables = [
            ("reactions", self.reaction_rows()),
            ("triggers", self.trigger_rows()),
            ("ports", self.port_rows()),
            ("outputs", self.output_rows()?),
            ("inputs", self.input_rows()?),
        ];
        let workers = self.owner.job.workers();
        let mut omits = self.owner.tables.absence.is_empty() || self.owner.tables.modes.is_empty();
        for (name, rows) in tables {
            if rows.is_empty() {
                omits = true;
                continue;
            }
            text = text + "    " + name + ": &[\n";
            for row in rows {
                text = text + "        " + &row + ",\n";
            }
            text.push_str("    ],\n");
        }
        if self.owner.tables.own_ports.is_empty() {
            omits = true;
        } else {
            text = format!("{text}    own_ports: &{:?},\n", self.owner.tables.own_ports);
        }
        if self.owner.tables.handed_over.is_empty() {
            omits = true;
        } else {
            text.push_str("    handed_over: &[\n");
            for row in self.handed_over_rows() {
                text = text + "        " + &row + ",\n";
            }
            text.push_str("    ],\n");
        }
        if !self.owner.tables.absence.is_empty() {
            text = text + "    absence: " + &ids(&self.owner.tables.absence) + ",\n";
        }
        if !self.owner.tables.modes.is_empty() {
            text.push_str("    modes: Some(&MODES),\n");
        }
        if workers > 1 {
            text = text + "    workers: " + &workers.to_string() + ",\n";
        }
        text.push_str(if omits { "    ..Tables::DEFAULT\n};\n" } else { "};\n" });
        text.push_str("const _: () = TABLES.check();\n\n/// The memory that the engine needs for this program.\n");
        text.push_str("pub type Storage = lf::model::storage_for!(TABLES);\n");
        Ok(text)
    }

    /// Returns the modes and their contents, if there are any.
    fn modes_text(&self) -> String {
        if self.owner.tables.modes.is_empty() {
            return String::new();
        }
        let mut text = String::from("/// The modes, the mode of each reaction, and the triggers in modes.\n");
        text.push_str("const MODES: Modes = Modes::new(\n    &[\n");
        for mode in &self.owner.tables.modes {
            let mut row = Fields::of("ModeInfo");
            row.set("name", format_args!("{:?}", mode.name)).set("instance", mode.instance);
            row.set("parent", format_args!("{:?}", mode.parent)).set("initial", mode.initial);
            text = text + "        " + &row.row() + ",\n";
        }
        let reactions: Vec<Option<ModeId>> = self.owner.tables.reactions.iter().map(|reaction| reaction.mode).collect();
        text = text + "    ],\n    " + &ids(&reactions) + ",\n    &[\n";
        for ModeTrigger { trigger, mode, offset } in self.owner.tables.mode_triggers() {
            let mut row = Fields::of("ModeTrigger");
            row.set("trigger", format_args!("{trigger:?}")).set("mode", format_args!("{mode:?}"));
            text = text + "        " + &row.set("offset", optional(offset)).row() + ",\n";
        }
        let ModeEvents { entry, startup, reset, shutdown } = self.owner.tables.mode_events();
        let mut events = Fields::of("ModeEvents");
        events.set("entry", format_args!("{entry:?}")).set("startup", ids(startup));
        events.set("reset", ids(reset)).set("shutdown", ids(shutdown));
        text + "    ],\n    " + &events.row() + ",\n);\n\n"
    }

    fn handed_over_rows(&self) -> Vec<String> {
        let row = |state: &HandedOverRow<'_>| {
            let mut row = Fields::of("HandedOver");
            row.set("name", format_args!("{:?}", state.name)).set("id", format_args!("{:#018x}", state.id));
            row.set("max_len", self.bodies.state_len(&self.owner, state)).row()
        };
        self.owner.tables.handed_over.iter().map(row).collect()
    }

    fn reaction_rows(&self) -> Vec<String> {
        let row = |reaction: &crate::tables::ReactionRow<'_>| {
            let mut row = Fields::of("ReactionInfo");
            row.set("name", format_args!("{:?}", reaction.name)).set("level", reaction.level);
            row.set_if(reaction.deadline.is_some(), "deadline", optional(reaction.deadline));
            row.set_if(reaction.tardy, "tardy", true);
            let kind = match reaction.kind {
                ReactionKind::Body => String::new(),
                ReactionKind::Send(output) => format!("ReactionKind::Send({output:?})"),
            };
            row.set_if(!kind.is_empty(), "kind", kind).row()
        };
        self.owner.tables.reactions.iter().map(row).collect()
    }

    fn trigger_rows(&self) -> Vec<String> {
        let row = |trigger: &crate::tables::TriggerRow<'_>| {
            let mut row = Fields::of("TriggerInfo");
            row.set("name", format_args!("{:?}", trigger.name)).set("kind", trigger_kind(&trigger.kind));
            row.set("reactions", ids(&trigger.reactions)).row()
        };
        self.owner.tables.triggers.iter().map(row).collect()
    }

    fn port_rows(&self) -> Vec<String> {
        let row = |port: &crate::tables::PortRow<'_>| {
            let mut row = Fields::of("PortInfo");
            row.set("name", format_args!("{:?}", port.name)).set("reactions", ids(&port.reactions));
            row.set("delays", ids(&port.delays)).row()
        };
        self.owner.tables.ports.iter().map(row).collect()
    }

    fn output_rows(&self) -> Result<Vec<String>, EmitError> {
        let row = |(index, output): (usize, &crate::tables::OutputRow<'_>)| {
            let mut row = Fields::of("NetworkOutput");
            row.set("name", format_args!("{:?}", output.name)).set("source", format_args!("{:?}", output.source));
            row.set("federate", output.federate).set("port", output.port);
            row.set_if(output.delay.is_some(), "delay", optional(output.delay));
            row.set("max_len", self.max_len(output.source, self.owner.federate.outputs[index].serializer.as_ref())?);
            row.set_if(output.tells_absence, "tells_absence", true).set_if(output.physical, "physical", true);
            Ok(row.row())
        };
        self.owner.tables.outputs.iter().enumerate().map(row).collect()
    }

    fn input_rows(&self) -> Result<Vec<String>, EmitError> {
        let row = |(index, input): (usize, &crate::tables::InputRow<'_>)| {
            let mut row = Fields::of("NetworkInput");
            row.set("name", format_args!("{:?}", input.name)).set("trigger", format_args!("{:?}", input.trigger));
            row.set("federate", input.federate).set_if(input.delay.is_some(), "delay", optional(input.delay));
            row.set("max_len", self.max_len(input.fills, self.owner.federate.inputs[index].serializer.as_ref())?);
            row.set_if(input.level != u16::MAX, "level", input.level);
            row.set_if(input.awaited, "awaited", true).set_if(input.physical, "physical", true);
            row.set_if(input.tardy, "tardy", true);
            row.set_if(input.max_wait != Interval::ZERO, "max_wait", interval(input.max_wait));
            row.set_if(input.absent_after != Interval::ZERO, "absent_after", interval(input.absent_after));
            Ok(row.set_if(!input.readers.is_empty(), "readers", ids(&input.readers)).row())
        };
        self.owner.tables.inputs.iter().enumerate().map(row).collect()
    }
}

fn trigger_kind(kind: &TriggerKind) -> String {
    let timing = |timing: &ActionTiming| {
        let mut fields = Fields::with_default("ActionTiming", "NONE");
        fields.set_if(timing.min_delay != Interval::ZERO, "min_delay", interval(timing.min_delay));
        fields.set_if(timing.min_spacing.is_some(), "min_spacing", optional(timing.min_spacing));
        let policy = format!("Policy::{:?}", timing.policy);
        fields.set_if(timing.policy != Policy::Defer, "policy", policy);
        if *timing == ActionTiming::NONE { "ActionTiming::NONE".to_owned() } else { fields.row() }
    };
    match kind {
        TriggerKind::Startup => "TriggerKind::Startup".to_owned(),
        TriggerKind::Shutdown => "TriggerKind::Shutdown".to_owned(),
        TriggerKind::Reset => "TriggerKind::Reset".to_owned(),
        TriggerKind::Timer { offset, period } => {
            format!("TriggerKind::Timer {{ offset: {}, period: {} }}", interval(*offset), interval(*period))
        }
        TriggerKind::Logical(action) => format!("TriggerKind::Logical({})", timing(action)),
        TriggerKind::Physical(action) => format!("TriggerKind::Physical({})", timing(action)),
        TriggerKind::Delay { fills, delay } => {
            format!("TriggerKind::Delay {{ fills: {fills:?}, delay: {} }}", interval(*delay))
        }
        TriggerKind::PhysicalDelay { fills, delay } => {
            format!("TriggerKind::PhysicalDelay {{ fills: {fills:?}, delay: {} }}", interval(*delay))
        }
        TriggerKind::NetworkInput { fills } => format!("TriggerKind::NetworkInput {{ fills: {fills:?} }}"),
    }
}

/// Returns a list of ids: `&[ReactionId(0), ReactionId(3)]`.
pub(in crate::emit) fn ids(ids: &[impl core::fmt::Debug]) -> String {
    format!("&{ids:?}")
}
