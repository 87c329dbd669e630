// SPDX-License-Identifier: Apache-2.0
//! The names for the numbers in records: a table that is written beside what a program is built into.

use std::path::{Path, PathBuf};

use lf_compiler::plan::{Federate, Plan, ReactionKind};
use lf_linux::runtime::trace::{Header, Role};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The table's file, beside what was built and in folders of traces.
pub(crate) const FILE: &str = "trace.json";

/// The table of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Names {
    /// The program.
    pub(crate) program: String,
    /// Its federates in order of id; one for a program that is not federated.
    pub(crate) federates: Vec<Participant>,
}

/// What a federate has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Participant {
    pub(crate) name: String,
    /// In the order of the numbers in records.
    pub(crate) reactions: Vec<Reaction>,
    pub(crate) inputs: Vec<Input>,
    /// How many connections lead to others.
    pub(crate) outputs: usize,
}

/// A reaction.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Reaction {
    pub(crate) name: String,
    /// `File.lf:LINE`, if it stands in the program.
    pub(crate) at: Option<String>,
}

/// What comes from another federate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Input {
    pub(crate) name: String,
    /// Its number on the wire.
    pub(crate) port: u16,
}

impl Names {
    /// The names of a program.
    pub(crate) fn of(plan: &Plan) -> Self {
        let federates = plan.federates.iter().map(|federate| Participant::of(plan, federate)).collect();
        Self { program: plan.name.clone(), federates }
    }

    /// Reads a table.
    ///
    /// # Errors
    /// When it cannot be read, or is none.
    pub(crate) fn read(file: &Path) -> Result<Self, Failure> {
        let wrong = |reason: &dyn std::fmt::Display| {
            Failure::message(format!(
                "cannot use {}: {reason}; name the {FILE} that `lfz build` has written beside the program with --names",
                file.display()
            ))
        };
        let text = std::fs::read_to_string(file).map_err(|error| wrong(&error))?;
        serde_json::from_str(&text).map_err(|error| wrong(&error))
    }

    /// Writes the table into a folder.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn write(&self, folder: &Path) -> Result<PathBuf, Failure> {
        let file = folder.join(FILE);
        let text = serde_json::to_string_pretty(self).map_err(std::io::Error::from)?;
        std::fs::write(&file, text)
            .map_err(|error| Failure::message(format!("cannot write {}: {error}", file.display())))?;
        Ok(file)
    }

    /// What the participant with this header is called.
    pub(crate) fn name(&self, role: Role) -> String {
        match role {
            Role::Rti => "RTI".to_owned(),
            Role::Federate(id) => {
                self.federates.get(usize::from(id)).map_or_else(|| format!("federate {id}"), |found| found.name.clone())
            }
            Role::Program => self.program.clone(),
        }
    }

    /// The participant with this header, which has tables of these sizes: none for an RTI.
    ///
    /// # Errors
    /// When the table has no such participant, or another one under its number: it is of another build.
    pub(crate) fn of_participant(&self, header: &Header) -> Result<Option<&Participant>, String> {
        let index = match header.role {
            Role::Rti => return Ok(None),
            Role::Federate(id) => usize::from(id),
            Role::Program => 0,
        };
        let size = |count: usize| u16::try_from(count).unwrap_or(u16::MAX);
        let fits = |found: &&Participant| {
            header.sizes == [&found.reactions.len(), &found.inputs.len(), &found.outputs].map(|count| size(*count))
        };
        self.federates.get(index).filter(fits).map(Some).ok_or_else(|| {
            let [reactions, inputs, outputs] = header.sizes;
            format!(
                "it was recorded by another program, or another version of it, than the table of names is for: it has \
                 {reactions} reactions, {inputs} inputs and {outputs} outputs; name the {FILE} of that build with \
                 --names"
            )
        })
    }
}

impl Participant {
    fn of(plan: &Plan, federate: &Federate) -> Self {
        let at = |kind: &ReactionKind| {
            let ReactionKind::Body { instance, reaction, .. } = kind else { return None };
            let at = plan.class(&federate.instances[instance.0]).reactions[reaction - 1].at;
            let file = Path::new(plan.path(at)).file_name()?.to_string_lossy();
            Some(format!("{file}:{}", at.line))
        };
        let reactions = federate.reactions.iter();
        let ports = (0..federate.inputs.len()).map(|input| federate.port_of(lf_compiler::plan::InputIndex(input)));
        Self {
            name: federate.name.clone(),
            reactions: reactions.map(|found| Reaction { name: found.name.clone(), at: at(&found.kind) }).collect(),
            inputs: federate
                .inputs
                .iter()
                .zip(ports)
                .map(|(input, port)| Input { name: input.name.clone(), port })
                .collect(),
            outputs: federate.outputs.len(),
        }
    }
}
