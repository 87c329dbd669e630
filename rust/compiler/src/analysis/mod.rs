// SPDX-License-Identifier: Apache-2.0
//! Computes the plan from instances and federates: storage of ports, levels, order of execution, delays and capacities.

mod builder;
mod classes;
mod ends;
mod federate;
mod followers;
mod graph;
mod last_tag;
mod network;
mod order;
mod physical;
mod rate;
mod sending;
mod serializer;
mod triggers;
mod waits;
mod zero_delay;

pub(crate) use rate::{direct_capacity, in_flight};
pub use triggers::NETWORK_CAPACITY;

use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::elaborated::Elaborated;
use crate::instances::InstanceId;
use crate::plan::{self, Plan};
use crate::resolve::{Class, Program, Unit, is_of_federations, program_name};
use builder::Context;
use classes::Places;
use std::collections::BTreeSet;

use graph::Graph;
use zero_delay::Cycles;

/// The TCP port of an RTI if the program sets none.
const RTI_PORT: u16 = 15_045;

/// Computes the plan. Returns `None` if the diagnostics have errors.
pub(crate) fn analyse(
    program: &Program,
    elaborated: &Elaborated<'_>,
    mut target: plan::Target,
    diagnostics: &mut Diagnostics,
) -> Option<Plan> {
    let mut graph = Graph::build(elaborated, diagnostics)?;
    sending::check(&mut graph, program, diagnostics);
    let order = order::order(&graph, diagnostics);
    idle_properties(program, elaborated.parts.federated, diagnostics);
    if !elaborated.parts.federated {
        target.coordination = plan::Coordination::Centralized;
    }
    let network = network::number(&graph);
    let waits = waits::waits(&graph, &network, &target, diagnostics);
    if diagnostics.has_errors() {
        return None;
    }
    let levels = order?;
    let sources = diagnostics.sources().clone();
    let places = Places::new(&sources);
    let decentralized = target.coordination == plan::Coordination::Decentralized;
    let described = classes::describe(elaborated, decentralized, &places);
    let zero_delay = Cycles::without_delay(&graph);
    let cycles = Cycles::of_any_delay(&graph);
    let mut federates = Vec::new();
    for part in 0..elaborated.parts.list.len() {
        let context = Context {
            program: elaborated,
            graph: &graph,
            levels: &levels,
            network: &network,
            decentralized,
            waits: &waits,
            zero_delay: &zero_delay,
            cycles: &cycles,
            places: &places,
            described: &described,
        };
        federates.push(federate::plan(&context, part, diagnostics));
    }
    let files = program.units.iter().enumerate().map(|(index, unit)| plan::SourceFile {
        path: unit.path.clone(),
        language: Some(program.language(index)).filter(|language| *language != target.language),
        imports: imports(index, unit),
        preambles: unit.ast.preambles.iter().map(|preamble| places.code(&preamble.code)).collect(),
    });
    let main = described.index[&elaborated.tree.instances[InstanceId::MAIN].class];
    let name = program_name(program).to_owned();
    let rti = elaborated.parts.federated.then(|| rti(elaborated.main(), &name, &target, diagnostics));
    let mut classes = described.classes;
    // All times have been evaluated by now.
    for (index, parameter) in classes[main.0].parameters.iter_mut().enumerate() {
        parameter.fixed = elaborated.tree.fixed(index);
    }
    Some(Plan { files: files.collect(), target, rti, main, classes, federates, name })
}

/// Returns the files whose reactors a file has imported.
fn imports(index: usize, unit: &Unit) -> Vec<plan::FileIndex> {
    let others: BTreeSet<usize> =
        unit.scope.values().map(|reactor| reactor.unit).filter(|unit| *unit != index).collect();
    others.into_iter().map(plan::FileIndex).collect()
}

fn rti(main: &Class<'_>, name: &str, target: &plan::Target, diagnostics: &mut Diagnostics) -> plan::Rti {
    let host = main.ast.host.as_ref();
    if let Some(host) = host.filter(|host| host.user.is_some()) {
        let message = "the user of the RTI's host has no effect";
        let hint = format!("write `at {}`", host.address);
        diagnostics.push(Diagnostic::new(Code::NoEffect, host.span, message).hint(hint));
    }
    plan::Rti {
        host: host.map_or_else(|| "localhost".to_owned(), |host| host.address.clone()),
        port: target.rti_port.or(host.and_then(|host| host.port)).unwrap_or(RTI_PORT),
        federation_id: target.federation_id.clone().unwrap_or_else(|| name.to_owned()),
    }
}

/// Reports properties of federations in a program that is none.
fn idle_properties(program: &Program, is_federated: bool, diagnostics: &mut Diagnostics) {
    if is_federated {
        return;
    }
    let Some(target) = program.units.first().and_then(|unit| unit.ast.target.as_ref()) else { return };
    for property in target.properties.iter().filter(|property| is_of_federations(&property.key.text)) {
        let message = format!("`{}` has no effect in a program that is not federated", property.key.text);
        let hint = "remove it, or make the main reactor `federated`";
        diagnostics.push(Diagnostic::new(Code::IdleProperty, property.key.span, message).hint(hint));
    }
}
