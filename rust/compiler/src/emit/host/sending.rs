// SPDX-License-Identifier: Apache-2.0
//! The transfer of values to other federates: the ports that send and receive, the serializers of `@serializer` and
//! `@max_length`, and the dependencies of crates on them.

use crate::emit::Job;
use crate::emit::view::View;
use crate::plan::{ClassIndex, Federate, NetworkInput, PortIndex, ReactionKind, Serializer, TriggerKind, Type};

/// Returns the type of a serializer for values of a type, which is spelled as at the place of use.
pub(in crate::emit) fn serializer_type(serializer: &Serializer, ty: &str) -> String {
    match (&serializer.name, serializer.max_length) {
        (None, length) => format!("::lf::MaxLength<{}>", length.unwrap_or_default()),
        (Some(_), Some(length)) => format!("::lf::model::Postcard<{length}>"),
        (Some(_), None) => format!("::lf::model::Postcard<{{ <{ty} as ::lf::model::Bounded>::BYTES }}>"),
    }
}

/// A port at the end of a connection to another federate.
#[derive(Clone, Debug)]
pub(in crate::emit) struct SentPort<'p> {
    /// Its name in its reactor.
    pub(in crate::emit) name: &'p str,
    /// The type as it is written at the source of the connection, where errors are shown.
    pub(in crate::emit) ty: &'p Type,
    pub(in crate::emit) serializer: Option<&'p Serializer>,
}

/// Returns the ports of a federate that send to other federates or receive from them, with their storage.
pub(in crate::emit) fn sent_ports(federate: &Federate) -> impl Iterator<Item = (PortIndex, SentPort<'_>)> {
    let outputs = federate.outputs.iter().map(|output| (output.source, &output.ty, output.serializer.as_ref()));
    let inputs = federate
        .inputs
        .iter()
        .filter_map(|input| Some((federate.filled(input)?, &input.ty, input.serializer.as_ref())));
    outputs.chain(inputs).map(|(port, ty, serializer)| {
        let name = federate.declared_port(port).map_or("", |(_, name)| name);
        (port, SentPort { name, ty, serializer })
    })
}

impl Federate {
    /// Returns the class and the name in it of the element with this path.
    pub(in crate::emit) fn declared<'a>(&self, path: &'a str) -> Option<(ClassIndex, &'a str)> {
        let (owner, name) = path.rsplit_once('.')?;
        // A channel is declared with its multiport.
        let name = name.split('[').next().unwrap_or(name);
        let instance = self.instances.iter().find(|instance| instance.path == owner)?;
        Some((instance.class, name))
    }

    /// Returns the class and the name in it of a port.
    pub(in crate::emit) fn declared_port(&self, port: PortIndex) -> Option<(ClassIndex, &str)> {
        self.declared(&self.ports[port.0].path)
    }

    /// Returns the port that an input from another federate fills.
    pub(in crate::emit) fn filled(&self, input: &NetworkInput) -> Option<PortIndex> {
        match self.triggers[input.trigger.0].kind {
            TriggerKind::NetworkInput { fills, .. } => Some(fills),
            _ => None,
        }
    }
}

/// Returns the ports of a federate whose values connections copy, by class and name.
pub(in crate::emit) fn copied_ports(federate: &Federate) -> impl Iterator<Item = (ClassIndex, &str)> {
    let delayed = federate.triggers.iter().filter_map(|trigger| match trigger.kind {
        TriggerKind::Delay { source, .. } => Some(source),
        _ => None,
    });
    let copied = federate.reactions.iter().filter_map(|reaction| match reaction.kind {
        ReactionKind::Copy { from, .. } => Some(from),
        _ => None,
    });
    delayed.chain(copied).filter_map(|port| federate.declared_port(port))
}

/// Returns whether some values are serialized by postcard. All crates of a program share the preambles, so all of them
/// then need its crates.
fn uses_postcard(view: &View<'_>) -> bool {
    let is_postcard = |input: &NetworkInput| {
        input.serializer.as_ref().and_then(|serializer| serializer.name.as_deref()) == Some("postcard")
    };
    let mut own = view.plan.federates.iter().filter(|federate| view.is_own(federate.instances[0].class));
    own.any(|federate| federate.inputs.iter().any(is_postcard))
}

/// Returns the features of the crate `lf` that sending needs.
pub(super) fn features(view: &View<'_>) -> Option<&'static str> {
    uses_postcard(view).then_some("postcard")
}

/// Returns the lines of the manifest for the crates that sending needs and that the program does not depend on itself.
pub(super) fn dependencies(job: &Job<'_>) -> String {
    if !uses_postcard(job.view) {
        return String::new();
    }
    let std = if job.is_image { "" } else { ", \"std\"" };
    let crates =
        [("serde", "1", format!("\"derive\"{std}")), ("postcard", "1.1", "\"experimental-derive\"".to_owned())];
    let line = |(name, version, features): (&str, &str, String)| {
        format!("{name} = {{ version = \"{version}\", default-features = false, features = [{features}] }}\n")
    };
    let own = &job.view.cargo.dependencies;
    crates.into_iter().filter(|(name, ..)| own.iter().all(|own| own.name != *name)).map(line).collect()
}
