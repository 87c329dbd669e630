// SPDX-License-Identifier: Apache-2.0
//! The names for the numbers in recordings: a table beside the build output of a program.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::plan::{Federate, InputIndex, Plan, ReactionKind};

/// The name of the table's file, beside the build output and in folders of recordings. It is JSON.
pub const FILE: &str = "trace.json";

/// The table of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TraceNames {
    /// The program.
    pub program: String,
    /// Its federates in order of id; one for a program that is not federated.
    pub federates: Vec<TracedFederate>,
}

/// The names of a federate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TracedFederate {
    /// Its name.
    pub name: String,
    /// The reactions, in the order of the numbers in records.
    pub reactions: Vec<TracedReaction>,
    /// The inputs, in the order of the numbers in records.
    pub inputs: Vec<TracedInput>,
    /// The number of connections to others.
    pub outputs: usize,
}

/// A reaction.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TracedReaction {
    /// Its name.
    pub name: String,
    /// `File.lf:LINE`, if it stands in the program.
    pub at: Option<String>,
}

/// An input from another federate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TracedInput {
    /// Its name.
    pub name: String,
    /// Its number on the wire.
    pub port: u16,
}

impl TraceNames {
    /// Returns the names of a program.
    pub fn of(plan: &Plan) -> Self {
        let federates = plan.federates.iter().map(|federate| TracedFederate::of(plan, federate)).collect();
        Self { program: plan.name.clone(), federates }
    }
}

impl TracedFederate {
    fn of(plan: &Plan, federate: &Federate) -> Self {
        let at = |kind: &ReactionKind| {
            let ReactionKind::Body { instance, reaction, .. } = kind else { return None };
            let at = plan.class(&federate.instances[instance.0]).reactions[reaction - 1].at;
            let file = Path::new(plan.path(at)).file_name()?.to_string_lossy();
            Some(format!("{file}:{}", at.line))
        };
        let reactions = federate.reactions.iter();
        let ports = (0..federate.inputs.len()).map(|input| federate.port_of(InputIndex(input)));
        Self {
            name: federate.name.clone(),
            reactions: reactions
                .map(|found| TracedReaction { name: found.name.clone(), at: at(&found.kind) })
                .collect(),
            inputs: federate
                .inputs
                .iter()
                .zip(ports)
                .map(|(input, port)| TracedInput { name: input.name.clone(), port })
                .collect(),
            outputs: federate.outputs.len(),
        }
    }
}
