// SPDX-License-Identifier: Apache-2.0
//! The lengths of values for other federates, and types that cannot be sent from or to a board.

use crate::emit::host::{sent_ports, serializer_type};
use crate::emit::{EmitError, Job};
use crate::languages::rust::{Growing, growing, is_copy};
use crate::plan::{Federate, Serializer};
use crate::tables::handed_over;

/// Returns the maximum number of bytes of a value of a type, as an expression.
pub(super) fn max_len(serializer: Option<&Serializer>, ty: &str) -> String {
    match serializer {
        Some(Serializer { name: Some(_), max_length: Some(length) }) => length.to_string(),
        Some(Serializer { name: Some(_), max_length: None }) => format!("<{ty} as lf::model::Bounded>::BYTES"),
        Some(bound) => format!("<{} as lf::model::Serializer<{ty}>>::MAX_LEN", serializer_type(bound, ty)),
        None if is_copy(ty) && ty.bytes().all(|byte| byte.is_ascii_alphanumeric()) => format!("{ty}::MAX_LEN"),
        None => format!("<{ty} as Payload>::MAX_LEN"),
    }
}

/// Refuses types that need a heap, if an image sends, receives or forwards them.
pub(super) fn check_heap(job: &Job<'_>) -> Result<(), EmitError> {
    if !job.is_image {
        return Ok(());
    }
    let forwarded = job.plan().federates.iter().filter(|_| job.rti).flat_map(|federate| &federate.inputs);
    let forwarded = forwarded.filter(|input| !input.direct).map(|input| (&input.ty, input.serializer.as_ref()));
    let own = job.federate.into_iter().flat_map(sent_ports).map(|(_, port)| (port.ty, port.serializer));
    let is_own = |federate: &Federate| job.federate.is_some_and(|own| own.id == federate.id);
    let concerned = job.plan().federates.iter().filter(|federate| job.rti || is_own(federate));
    let states = concerned.flat_map(|federate| handed_over(job.plan(), federate)).map(|row| row.state);
    let states = states.filter_map(|state| Some((&state.ty, state.handed_over.as_ref()?.serializer.as_ref(), "")));
    let sent = own.chain(forwarded).map(|(ty, serializer)| (ty, serializer, " at both ends"));
    for (ty, serializer, place) in sent.chain(states) {
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
            "`{text}` needs a heap, which `{}`, a board's image that {what}, does not have: write `{instead}`{place}",
            job.name
        );
        return Err(EmitError::new(job.plan(), ty.at, message));
    }
    Ok(())
}
