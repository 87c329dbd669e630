// SPDX-License-Identifier: Apache-2.0
//! Values that go from federate to federate: how they become bytes, and whether they can at all.

use super::graph::Graph;
use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::instances::Tree;
use crate::languages::{Language, Preambles};
use crate::plan::Serializer;
use crate::resolve::{Class, Connection, Given, Port, Program};

/// How the values of a connection become bytes: what it says itself, or else what one of its ports says.
pub(super) fn serializer(
    connection: &Connection<'_>,
    from: &Port<'_>,
    to: &Port<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Serializer> {
    let (own, from, to) = (connection.sending, from.sending, to.sending);
    let name = one_of(own.serializer, from.serializer, to.serializer, "serializer", diagnostics);
    let max_length = one_of(own.max_length, from.max_length, to.max_length, "length", diagnostics);
    // LF's name for the layout of the type itself.
    let name = name.filter(|name| *name != "native").map(str::to_owned);
    let found = Serializer { name, max_length };
    (found != Serializer::default()).then_some(found)
}

/// What the connection says, or the ports, which must not contradict each other.
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

/// Reports ports whose values cannot go to another federate, as far as that is known without the target language's
/// own compiler; each declaration once.
pub(super) fn check(
    graph: &Graph,
    program: &Program,
    classes: &[Class<'_>],
    tree: &Tree,
    language: &dyn Language,
    diagnostics: &mut Diagnostics,
) {
    let texts = |preambles: &'_ [crate::syntax::ast::Preamble]| -> Vec<String> {
        preambles.iter().map(|preamble| preamble.code.text.clone()).collect()
    };
    let all: Vec<String> = program
        .units
        .iter()
        .flat_map(|unit| {
            let inner = unit.ast.reactors.iter().flat_map(|reactor| texts(&reactor.body.preambles));
            texts(&unit.ast.preambles).into_iter().chain(inner)
        })
        .collect();
    let mut seen = std::collections::BTreeSet::new();
    for link in graph.links.iter().filter(|link| link.network) {
        let class = tree.instances[graph.instance[link.from]].class;
        let declared = &classes[class.0];
        let port = &declared.ports[graph.port_of(link.from)];
        let of_file = texts(&program.units[declared.id.unit].ast.preambles);
        let visible = [of_file, texts(&declared.ast.body.preambles)].concat();
        let preambles = Preambles { visible: &visible, all: &all };
        let Some(why) = language.unsendable(&port.ty, link.serializer.as_ref(), preambles) else { continue };
        if seen.insert((class, graph.port_of(link.from))) {
            let diagnostic = Diagnostic::new(Code::Unsendable, port.ty_span, why.message);
            diagnostics.push(diagnostic.also(link.span, "it goes to another federate here").hint(why.hint));
        }
    }
}
