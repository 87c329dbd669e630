// SPDX-License-Identifier: Apache-2.0
//! Names of a federate's fields and of the constants that number its reactions, triggers and ports.

use proc_macro2::Ident;
use quote::format_ident;

use crate::emit::names::{Names, ident, snake_case};
use crate::plan::{
    Federate, InputIndex, OutputIndex, Port, PortIndex, ReactionIndex, ReactionKind, TriggerIndex, TriggerKind,
};

/// All names, each given once.
pub(super) struct Symbols {
    main: Ident,
    instances: Vec<Ident>,
    ports: Vec<Ident>,
    triggers: Vec<Ident>,
    filling: Vec<Option<TriggerIndex>>,
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
        // A port that a trigger fills lies in the trigger's field, so the two share their name.
        let triggers: Vec<Ident> = federate.triggers.iter().map(|trigger| field(&trigger.path)).collect();
        let filling = filling_triggers(federate);
        let port = |(port, filling): (&Port, &Option<TriggerIndex>)| match filling {
            Some(trigger) => triggers[trigger.0].clone(),
            None => field(&port.path),
        };
        let ports = federate.ports.iter().zip(&filling).map(port).collect();
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
            filling,
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

    /// The trigger whose queue fills a port.
    pub(super) fn filled_by(&self, port: PortIndex) -> Option<TriggerIndex> {
        self.filling[port.0]
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

/// For each port the trigger that fills it.
fn filling_triggers(federate: &Federate) -> Vec<Option<TriggerIndex>> {
    let mut filling = vec![None; federate.ports.len()];
    for (index, trigger) in federate.triggers.iter().enumerate() {
        if let TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } = trigger.kind {
            filling[fills.0] = Some(TriggerIndex(index));
        }
    }
    filling
}
