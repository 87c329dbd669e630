// SPDX-License-Identifier: Apache-2.0
//! The struct that owns all parts of a federate: the purposes of its fields, and their names and those of the inboxes
//! of physical actions.

use proc_macro2::Ident;

use super::identifiers::{give, ident};
use crate::emit::Job;
use crate::emit::names::{Names, snake_case};
use crate::plan::{Federate, Plan};
use crate::tables::Tables;

/// The struct that owns all state, ports and queues of a federate.
pub(in crate::emit) struct Owner<'p> {
    pub(in crate::emit) job: &'p Job<'p>,
    pub(in crate::emit) plan: &'p Plan,
    pub(in crate::emit) federate: &'p Federate,
    pub(in crate::emit) tables: Tables<'p>,
    pub(in crate::emit) symbols: Identifiers,
}

impl<'p> Owner<'p> {
    pub(in crate::emit) fn new(job: &'p Job<'p>, federate: &'p Federate) -> Self {
        let tables = Tables::of(job.plan(), federate);
        let symbols = Identifiers::new(federate, &tables);
        Self { job, plan: job.plan(), federate, tables, symbols }
    }

    /// Returns the place expression of a port.
    pub(in crate::emit) fn port_place(&self, port: usize) -> String {
        let queued = if self.tables.ports[port].filled_by.is_some() { ".port" } else { "" };
        format!("self.{}{queued}", self.symbols.ports[port])
    }
}

/// All names, each unique.
pub(in crate::emit) struct Identifiers {
    /// The variable that holds the federated reactor during the construction of the instances.
    pub(in crate::emit) main: Ident,
    pub(in crate::emit) instances: Vec<Ident>,
    /// A port that a trigger fills lies in the trigger's field, so the two share their name.
    pub(in crate::emit) ports: Vec<Ident>,
    pub(in crate::emit) triggers: Vec<Ident>,
    /// The names by trigger; unused for those that are no physical actions.
    pub(in crate::emit) inboxes: Vec<Ident>,
}

impl Identifiers {
    pub(in crate::emit) fn new(federate: &Federate, tables: &Tables<'_>) -> Self {
        let (mut fields, mut statics) = (Names::default(), Names::reserving(&["TABLES", "FEDERATION", "DESCRIPTION"]));
        let main = ident(&fields.give("main"));
        let mut field = |path: &str| give(&mut fields, &ident(&snake_case(path)));
        let instances = federate.instances.iter().map(|instance| field(&instance.path)).collect();
        let triggers: Vec<Ident> = tables.triggers.iter().map(|trigger| field(trigger.name)).collect();
        let ports = tables.ports.iter().map(|port| match port.filled_by {
            Some(trigger) => triggers[usize::from(trigger.0)].clone(),
            None => field(port.name),
        });
        let ports = ports.collect();
        let inbox = |path: &str| ident(&statics.give(&format!("{}_INBOX", snake_case(path).to_uppercase())));
        let inboxes = tables.triggers.iter().map(|trigger| trigger.name).map(inbox).collect();
        Self { main, instances, ports, triggers, inboxes }
    }
}
