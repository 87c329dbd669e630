// SPDX-License-Identifier: Apache-2.0
//! The serialization of values between federates, from the settings of connections and ports.

use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::plan::Serializer;
use crate::resolve::{CheckedConnection, CheckedPort, Given, Sending};

/// Returns the serialization of a state variable that is handed over.
pub(super) fn of_state(sending: &Sending<'_>) -> Option<Serializer> {
    chosen(sending.serializer.map(|given| given.value), sending.max_length.map(|given| given.value))
}

/// Returns the serialization of a connection: its own setting, or else that of one of its ports.
pub(super) fn of_connection(
    connection: &CheckedConnection<'_>,
    from: &CheckedPort<'_>,
    to: &CheckedPort<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Serializer> {
    let (own, from, to) = (connection.sending, from.sending, to.sending);
    let name = one_of(own.serializer, from.serializer, to.serializer, "serializer", diagnostics);
    let max_length = one_of(own.max_length, from.max_length, to.max_length, "length", diagnostics);
    chosen(name, max_length)
}

fn chosen(name: Option<&str>, max_length: Option<usize>) -> Option<Serializer> {
    // This is LF's name for the layout of the type itself.
    let name = name.filter(|name| *name != "native").map(str::to_owned);
    let found = Serializer { name, max_length };
    (found != Serializer::default()).then_some(found)
}

/// Returns the connection's setting, or that of the ports, which must not contradict each other.
fn one_of<T: Copy + PartialEq>(
    own: Option<Given<T>>,
    from: Option<Given<T>>,
    to: Option<Given<T>>,
    what: &str,
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    if let (None, Some(from), Some(to)) = (own, from, to)
        && from.value != to.value
    {
        let message = format!("the port at the other end of the connection says another {what}");
        let diagnostic = Diagnostic::new(Code::BadAttribute, to.span, message).also(from.span, "the other one");
        diagnostics.push(diagnostic.hint("say it at one of the ports alone, or before the connection"));
    }
    own.or(from).or(to).map(|given| given.value)
}
