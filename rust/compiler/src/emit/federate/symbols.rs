// SPDX-License-Identifier: Apache-2.0
//! Names of a federate's fields and of the constants that number its reactions, triggers and ports.

use proc_macro2::Ident;
use quote::format_ident;

use crate::emit::names::{Names, ident, snake_case};
use crate::plan::{Federate, InputIndex, OutputIndex, PortIndex, ReactionIndex, ReactionKind, TriggerIndex};

/// All names, each given once.
pub(super) struct Symbols {
    main: Ident,
    instances: Vec<Ident>,
    ports: Vec<Ident>,
    triggers: Vec<Ident>,
    reaction_ids: Vec<Ident>,
    trigger_ids: Vec<Ident>,
    port_ids: Vec<Ident>,
    output_ids: Vec<Ident>,
    input_ids: Vec<Ident>,
}

impl Symbols {
    pub(super) fn new(federate: &Federate) -> Self {
        let mut fields = Names::default();
        let main = ident(&fields.give("main"));
        let mut field = |path: &str| fields.give_ident(&ident(&snake_case(path)));
        let instances = federate.instances.iter().map(|instance| field(&instance.path)).collect();
        let ports = federate.ports.iter().map(|port| field(&port.path)).collect();
        let triggers = federate.triggers.iter().map(|trigger| field(&trigger.path)).collect();
        let mut constants = Names::reserving(&["TABLES", "DESCRIPTION"]);
        let mut constant = |prefix: &str, path: &str| {
            let name = format!("{prefix}_{}", snake_case(&path.replace(" -> ", ".to."))).to_uppercase();
            ident(&constants.give(&name))
        };
        let reaction_ids = federate
            .reactions
            .iter()
            .map(|reaction| match &reaction.kind {
                ReactionKind::Body { instance, reaction: number, .. } => {
                    let path = federate.instances.get(instance.0).map_or("", |instance| &instance.path);
                    constant("REACTION", &format!("{path}_{number}"))
                }
                ReactionKind::Send(_) => constant("SEND", &reaction.name),
            })
            .collect();
        Self {
            main,
            instances,
            ports,
            triggers,
            reaction_ids,
            trigger_ids: federate.triggers.iter().map(|trigger| constant("TRIGGER", &trigger.path)).collect(),
            port_ids: federate.ports.iter().map(|port| constant("PORT", &port.path)).collect(),
            output_ids: federate.outputs.iter().map(|output| constant("OUTPUT", &output.name)).collect(),
            input_ids: federate.inputs.iter().map(|input| constant("INPUT", &input.name)).collect(),
        }
    }

    /// The variable that holds the federated reactor while the instances are made.
    pub(super) fn main(&self) -> &Ident {
        &self.main
    }

    pub(super) fn instance(&self, index: usize) -> &Ident {
        &self.instances[index]
    }

    pub(super) fn port(&self, index: PortIndex) -> &Ident {
        &self.ports[index.0]
    }

    pub(super) fn trigger(&self, index: TriggerIndex) -> &Ident {
        &self.triggers[index.0]
    }

    pub(super) fn reaction_id(&self, index: ReactionIndex) -> &Ident {
        &self.reaction_ids[index.0]
    }

    pub(super) fn trigger_id(&self, index: TriggerIndex) -> &Ident {
        &self.trigger_ids[index.0]
    }

    pub(super) fn port_id(&self, index: PortIndex) -> &Ident {
        &self.port_ids[index.0]
    }

    pub(super) fn output_id(&self, index: OutputIndex) -> &Ident {
        &self.output_ids[index.0]
    }

    pub(super) fn input_id(&self, index: InputIndex) -> &Ident {
        &self.input_ids[index.0]
    }

    /// The static inbox of a physical action.
    pub(super) fn inbox(&self, index: TriggerIndex) -> Ident {
        format_ident!("INBOX_OF_{}", self.trigger_ids[index.0])
    }
}
