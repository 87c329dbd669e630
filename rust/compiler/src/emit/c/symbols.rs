// SPDX-License-Identifier: Apache-2.0
//! Names of functions, types and storage, each given once.

use std::collections::{BTreeMap, BTreeSet};

use crate::emit::names::{Names, plain};
use crate::emit::view::View;
use crate::plan::{ClassIndex, Federate, FileIndex, Plan, ReactionKind};

/// The parts of the program in a participant, with their names.
pub(super) struct Symbols<'p> {
    pub(super) view: &'p View<'p>,
    pub(super) plan: &'p Plan,
    pub(super) federate: &'p Federate,
    /// The prefixes of functions and of types.
    names: BTreeMap<ClassIndex, [String; 2]>,
    files: Vec<String>,
    /// By port: the number of reactions, connections and inputs of others that read its values.
    readers: Vec<usize>,
    /// The children of each class of which this federate has instances.
    children: BTreeSet<(ClassIndex, usize)>,
    /// The reactions of each class that it has.
    reactions: BTreeSet<(ClassIndex, usize)>,
}

impl<'p> Symbols<'p> {
    pub(super) fn new(view: &'p View<'p>, federate: &'p Federate) -> Self {
        let plan = view.plan;
        let (mut class_names, mut type_names) = (Names::reserving(&["lf", "program", "sizes"]), Names::default());
        let mut names = BTreeMap::new();
        let used = federate.instances.iter().map(|instance| instance.class).chain([plan.main]);
        for class in used {
            names.entry(class).or_insert_with(|| {
                let name = plain(&view.class(class).name);
                // LF's own names of types, which macros of some programs use.
                [class_names.give(&name), format!("_{}", type_names.give(&name.to_lowercase()))]
            });
        }
        Self {
            view,
            plan,
            federate,
            names,
            files: preamble_headers(plan),
            readers: readers(plan, federate),
            children: federate.children(plan.main),
            reactions: federate.bodies(),
        }
    }

    /// Returns the classes, each with the name that begins all names of its file.
    pub(super) fn classes(&self) -> impl Iterator<Item = (ClassIndex, &str)> {
        self.names.iter().map(|(class, [name, _])| (*class, name.as_str()))
    }

    /// Returns the name of a class.
    pub(super) fn class(&self, class: ClassIndex) -> &str {
        self.names.get(&class).map_or("", |[name, _]| name)
    }

    /// Returns the prefix of the names of a class's types.
    pub(super) fn types(&self, class: ClassIndex) -> &str {
        self.names.get(&class).map_or("", |[_, types]| types)
    }

    /// Returns the header with the preambles of an LF file, without its extension.
    pub(super) fn file(&self, file: FileIndex) -> &str {
        &self.files[file.0]
    }

    /// Returns the number of readers of a port's values.
    pub(super) fn readers(&self, port: usize) -> usize {
        self.readers[port]
    }

    /// Returns whether the runtime copies values to a port, or from it.
    pub(super) fn is_copied(&self, port: usize) -> bool {
        self.federate.reactions.iter().any(|reaction| match &reaction.kind {
            ReactionKind::Copy { from, to } => from.0 == port || to.0 == port,
            _ => false,
        })
    }

    /// Returns whether this federate has an instance of this child of a class.
    pub(super) fn makes(&self, class: ClassIndex, child: usize) -> bool {
        self.children.contains(&(class, child))
    }

    /// Returns whether this federate has a reaction of a class, by its number.
    pub(super) fn reacts(&self, class: ClassIndex, reaction: usize) -> bool {
        self.reactions.contains(&(class, reaction))
    }

    /// Returns the variable with the state of the federated reactor, or of an instance.
    pub(super) fn instance(instance: Option<usize>) -> String {
        instance.map_or_else(|| "lf_self_main".to_owned(), |index| format!("lf_self_{index}"))
    }
}

/// Returns the header with the preambles of each LF file, without the extension.
pub(super) fn preamble_headers(plan: &Plan) -> Vec<String> {
    let mut names = Names::default();
    let header = |file: &crate::plan::SourceFile| {
        let stem = super::text::stem(super::text::name_of(&file.path));
        format!("{}_preambles", names.give(&plain(stem)))
    };
    plan.files.iter().map(header).collect()
}

fn readers(plan: &Plan, federate: &Federate) -> Vec<usize> {
    let mut readers: Vec<usize> = federate.ports.iter().map(|port| port.delays.len()).collect();
    for output in &federate.outputs {
        readers[output.source.0] += 1;
    }
    for reaction in &federate.reactions {
        match &reaction.kind {
            ReactionKind::Body { instance, reaction, arguments } => {
                let declared = &plan.class(&federate.instances[instance.0]).reactions[reaction - 1];
                for (parameter, argument) in declared.parameters.iter().zip(arguments) {
                    if !parameter.triggers && !parameter.uses {
                        continue;
                    }
                    argument.ports().iter().for_each(|port| readers[port.0] += 1);
                }
            }
            ReactionKind::Copy { from, .. } => readers[from.0] += 1,
            ReactionKind::Send(_) => {}
        }
    }
    readers
}
