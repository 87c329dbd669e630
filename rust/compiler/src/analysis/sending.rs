// SPDX-License-Identifier: Apache-2.0
//! Values that go from federate to federate, or are copied on their way, and whether they can.

use super::graph::Graph;
use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::instances::Tree;
use crate::languages::Preambles;
use crate::resolve::{Class, Program};

/// Reports ports whose values cannot go to another federate, and connections that cannot copy them, as far as that is
/// known without the target language's own compiler; each declaration of a port once.
pub(super) fn check(
    graph: &Graph,
    program: &Program,
    classes: &[Class<'_>],
    tree: &Tree,
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
    for link in graph.links.iter().filter(|link| link.network || link.copies || link.is_delayed()) {
        let class = tree.instances[graph.instance[link.from]].class;
        let declared = &classes[class.0];
        let port = &declared.ports[graph.port_of(link.from)];
        let of_file = texts(&program.units[declared.id.unit].ast.preambles);
        let visible = [of_file, texts(&declared.ast.body.preambles)].concat();
        let preambles = Preambles { visible: &visible, all: &all };
        let (code, spans, what, why) = if link.network {
            let why = declared.language.unsendable(&port.ty, link.serializer.as_ref(), preambles);
            (Code::Unsendable, (port.ty_span, link.span), "it goes to another federate here", why)
        } else {
            let why = declared.language.uncopyable(&port.ty, preambles);
            (Code::Uncopyable, (link.span, port.ty_span), "the type of the source", why)
        };
        let Some(why) = why else { continue };
        if seen.insert((class, graph.port_of(link.from))) {
            diagnostics.push(Diagnostic::new(code, spans.0, why.message).also(spans.1, what).hint(why.hint));
        }
    }
}
