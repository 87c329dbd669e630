// SPDX-License-Identifier: Apache-2.0
//! How values go to other federates: the serializers of `@serializer` and `@max_length`, and what crates need for them.

use super::sendable::{Growing, growing};
use super::types::is_copy;
use crate::emit::{EmitError, Job};
use crate::plan::{ClassIndex, Federate, NetworkInput, Plan, PortIndex, ReactionKind, Serializer, TriggerKind, Type};

/// The serializers that there are; the first is the layout of the type itself.
pub(super) const SERIALIZERS: &[&str] = &["native", "postcard"];

/// The type of a serializer for values of a type, which is spelled as where it is used.
pub(super) fn serializer_type(serializer: &Serializer, ty: &str) -> String {
    match (&serializer.name, serializer.max_length) {
        (None, length) => format!("::lf::MaxLength<{}>", length.unwrap_or_default()),
        (Some(_), Some(length)) => format!("::lf::model::Postcard<{length}>"),
        (Some(_), None) => format!("::lf::model::Postcard<{{ <{ty} as ::lf::model::Bounded>::BYTES }}>"),
    }
}

/// How many bytes a value of a type takes at most, as an expression.
pub(super) fn max_len(serializer: Option<&Serializer>, ty: &str) -> String {
    match serializer {
        Some(Serializer { name: Some(_), max_length: Some(length) }) => length.to_string(),
        Some(Serializer { name: Some(_), max_length: None }) => format!("<{ty} as lf::model::Bounded>::BYTES"),
        Some(bound) => format!("<{} as lf::model::Serializer<{ty}>>::MAX_LEN", serializer_type(bound, ty)),
        None if is_copy(ty) && ty.bytes().all(|byte| byte.is_ascii_alphanumeric()) => format!("{ty}::MAX_LEN"),
        None => format!("<{ty} as Payload>::MAX_LEN"),
    }
}

/// A port at the end of a connection to another federate.
#[derive(Clone, Debug)]
pub(in crate::languages) struct SentPort<'p> {
    /// Its name in its reactor.
    pub(super) name: &'p str,
    /// The type as it is written at the source of the connection, where errors are shown.
    pub(super) ty: &'p Type,
    pub(super) serializer: Option<&'p Serializer>,
}

/// The ports of a federate whose values come from others or go to them, with their storage.
pub(in crate::languages) fn sent_ports(federate: &Federate) -> impl Iterator<Item = (PortIndex, SentPort<'_>)> {
    let outputs = federate.outputs.iter().map(|output| (output.source, &output.ty, output.serializer.as_ref()));
    let inputs = federate
        .inputs
        .iter()
        .filter_map(|input| Some((filled(federate, input)?, &input.ty, input.serializer.as_ref())));
    outputs.chain(inputs).map(|(port, ty, serializer)| {
        let name = declared(federate, port).map_or("", |(_, name)| name);
        (port, SentPort { name, ty, serializer })
    })
}

fn filled(federate: &Federate, input: &NetworkInput) -> Option<PortIndex> {
    match federate.triggers[input.trigger.0].kind {
        TriggerKind::NetworkInput { fills, .. } => Some(fills),
        _ => None,
    }
}

/// The class and the name of a port.
pub(in crate::languages) fn declared(federate: &Federate, port: PortIndex) -> Option<(ClassIndex, &str)> {
    let (owner, name) = federate.ports[port.0].path.rsplit_once('.')?;
    // A channel is declared with its multiport.
    let name = name.split('[').next().unwrap_or(name);
    let instance = federate.instances.iter().find(|instance| instance.path == owner)?;
    Some((instance.class, name))
}

/// The ports of a federate whose values connections copy, by class and name.
pub(super) fn copied_ports(federate: &Federate) -> impl Iterator<Item = (ClassIndex, &str)> {
    let delayed = federate.triggers.iter().filter_map(|trigger| match trigger.kind {
        TriggerKind::Delay { source, .. } => Some(source),
        _ => None,
    });
    let copied = federate.reactions.iter().filter_map(|reaction| match reaction.kind {
        ReactionKind::Copy { from, .. } => Some(from),
        _ => None,
    });
    delayed.chain(copied).filter_map(|port| declared(federate, port))
}

/// Whether some values are sent as postcard writes them. Preambles are shared by all crates of a program, so all of
/// them need its crates then.
fn uses_postcard(plan: &Plan) -> bool {
    let is_named = |input: &NetworkInput| input.serializer.as_ref().is_some_and(|serializer| serializer.name.is_some());
    let mut own = plan.federates.iter().filter(|federate| !plan.is_foreign(federate.instances[0].class));
    own.any(|federate| federate.inputs.iter().any(is_named))
}

/// The features of the crate `lf` that sending needs.
pub(super) fn features(plan: &Plan) -> Option<&'static str> {
    uses_postcard(plan).then_some("postcard")
}

/// The lines of the manifest for the crates that sending needs and that the program does not ask for itself.
pub(super) fn dependencies(job: &Job<'_>) -> String {
    if !uses_postcard(job.plan) {
        return String::new();
    }
    let std = if job.is_image { "" } else { ", \"std\"" };
    let crates =
        [("serde", "1", format!("\"derive\"{std}")), ("postcard", "1.1", "\"experimental-derive\"".to_owned())];
    let line = |(name, version, features): (&str, &str, String)| {
        format!("{name} = {{ version = \"{version}\", default-features = false, features = [{features}] }}\n")
    };
    let own = &job.plan.target.cargo.dependencies;
    crates.into_iter().filter(|(name, ..)| own.iter().all(|own| own.name != *name)).map(line).collect()
}

/// Refuses what needs a heap, where an image sends or receives it, or forwards it.
pub(super) fn check_heap(job: &Job<'_>) -> Result<(), EmitError> {
    if !job.is_image {
        return Ok(());
    }
    let forwarded = job.plan.federates.iter().filter(|_| job.rti).flat_map(|federate| &federate.inputs);
    let forwarded = forwarded.filter(|input| !input.direct).map(|input| (&input.ty, input.serializer.as_ref()));
    let own = job.federate.into_iter().flat_map(sent_ports).map(|(_, port)| (port.ty, port.serializer));
    for (ty, serializer) in own.chain(forwarded) {
        let by_serde = serializer.is_some_and(|serializer| serializer.name.is_some());
        let length = serializer.and_then(|serializer| serializer.max_length).unwrap_or(1000);
        let (parsed, text) = (syn::parse_str(&ty.text).ok(), &ty.text);
        let instead = match parsed.as_ref().and_then(growing) {
            None => continue,
            Some(Growing::Text) if by_serde => "heapless::String<N>".to_owned(),
            Some(Growing::Text) => format!("heapless::String<{length}>"),
            Some(Growing::List(_)) if by_serde => "heapless::Vec<T, N>".to_owned(),
            Some(Growing::List(element)) => {
                let element = quote::quote!(#element).to_string().replace(' ', "");
                format!("heapless::Vec<{element}, {length}>")
            }
        };
        let what = if job.federate.is_some() { "sends or receives it" } else { "forwards it" };
        let message = format!(
            "`{text}` needs a heap, which `{}`, a board's image that {what}, does not have: write `{instead}` at both \
             ends",
            job.name
        );
        return Err(EmitError::new(job.plan, ty.at, message));
    }
    Ok(())
}
