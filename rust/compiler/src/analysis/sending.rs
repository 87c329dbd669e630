// SPDX-License-Identifier: Apache-2.0
//! Checks that values can go from federate to federate, or be copied on the way, and that states can be handed over.

use std::collections::BTreeSet;

use super::graph::{Graph, Link, Node};
use super::serializer::of_state;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::languages::{Preambles, Unsendable};
use crate::plan::{Serializer, Shape};
use crate::resolve::{CheckedPort, Class, ClassId, Program};
use crate::syntax::ast::{CodeBlock, Preamble};

/// The serializer that both languages have: a value is sent as it lies in memory.
const NATIVE: &str = "native";

/// The label of a connection between federates.
const GOES: &str = "it goes to another federate here";

/// Reports ports whose values cannot go to another federate, and connections that cannot copy them, as far as that is
/// known without the target languages' own compilers; each declaration of a port once. Connections between federates in
/// different languages get the layouts of values at both ends.
pub(super) fn check(graph: &mut Graph<'_>, program: &Program, diagnostics: &mut Diagnostics) {
    let all = program.units.iter().flat_map(|unit| {
        let inner = unit.ast.reactors.iter().flat_map(|reactor| texts(&reactor.body.preambles));
        texts(&unit.ast.preambles).into_iter().chain(inner)
    });
    let mut ends = Ends { program, all: all.collect(), seen: BTreeSet::new(), told: BTreeSet::new(), diagnostics };
    ends.check_states(graph);
    let mut shapes = Vec::new();
    for link in graph.links.values() {
        let mut between = None;
        if link.network {
            ends.check(graph, link.from, link);
            let is_other = ends.end(graph, link.from).language_differs(&ends.end(graph, link.to));
            if is_other {
                ends.check(graph, link.to, link);
                between = ends.shapes(graph, link);
            }
        } else if link.copies || link.is_delayed() {
            ends.check_copies(graph, link);
        }
        shapes.push(between);
    }
    for (link, shapes) in graph.links.values_mut().zip(shapes) {
        link.shapes = shapes;
    }
}

fn texts(preambles: &[Preamble]) -> Vec<String> {
    preambles.iter().map(|preamble| preamble.code.text.clone()).collect()
}

/// A port at the end of a connection, and the declarations that its type can name.
struct TypedEnd<'a> {
    id: (ClassId, usize),
    class: &'a Class<'a>,
    port: &'a CheckedPort<'a>,
    visible: Vec<&'a CodeBlock>,
    visible_texts: Vec<String>,
    all: &'a [String],
}

impl TypedEnd<'_> {
    fn of(&self) -> Preambles<'_> {
        Preambles { visible: &self.visible_texts, all: self.all }
    }

    /// Returns the place of an unsendable type: the port, or the declaration of a part of the type.
    fn span_of(&self, why: &Unsendable) -> Span {
        let declared =
            why.place.as_ref().and_then(|place| Some((self.visible.get(place.preamble)?.span, &place.range)));
        declared.map_or(self.port.ty_span, |(code, range)| {
            Span::new(code.file, code.start + range.start, code.start + range.end)
        })
    }

    fn language_differs(&self, other: &Self) -> bool {
        self.class.language != other.class.language
    }
}

struct Ends<'a> {
    program: &'a Program,
    /// All preambles.
    all: Vec<String>,
    /// The checked ports of classes, with their serializers.
    seen: BTreeSet<(ClassId, usize, Option<Serializer>)>,
    /// The reports about preambles: several ports can have a type.
    told: BTreeSet<(Span, String)>,
    diagnostics: &'a mut Diagnostics,
}

impl<'a> Ends<'a> {
    /// Returns the preambles whose declarations the types of a class can name.
    fn visible<'c>(&self, class: &'c Class<'_>) -> Vec<&'c CodeBlock>
    where
        'a: 'c,
    {
        let of_file = &self.program.units[class.id.unit].ast.preambles;
        of_file.iter().chain(&class.ast.body.preambles).map(|it| &it.code).collect()
    }

    /// Reports states that are handed over and whose values cannot be sent.
    fn check_states(&mut self, graph: &Graph<'_>) {
        let classes: BTreeSet<_> = graph.program.tree.instances.values().map(|instance| instance.class).collect();
        for class in classes.into_iter().map(|id| &graph.program.classes[id.0]) {
            let visible: Vec<_> = self.visible(class).into_iter().map(|code| code.text.clone()).collect();
            for state in &class.states {
                let Some(sending) = &state.handed_over else { continue };
                let preambles = Preambles { visible: &visible, all: &self.all };
                let found = (class.language.facts().not_handed_over)(&state.ty, of_state(sending).as_ref(), preambles);
                for why in found {
                    let diagnostic = Diagnostic::new(Code::Unsendable, state.ty_span, why.message).hint(why.hint);
                    self.diagnostics.push(diagnostic.also(state.name.span, "it is handed over"));
                }
            }
        }
    }

    fn end<'e>(&'e self, graph: &'e Graph<'_>, node: Node) -> TypedEnd<'e> {
        let instance = graph.instance[node];
        let (id, class) = (graph.program.tree.instances[instance].class, graph.program.class(instance));
        let visible = self.visible(class);
        TypedEnd {
            id: (id, graph.port_of(node)),
            class,
            port: graph.port(node),
            visible_texts: visible.iter().map(|code| code.text.clone()).collect(),
            visible,
            all: &self.all,
        }
    }

    /// Reports a port whose values cannot go over a connection to another federate.
    fn check(&mut self, graph: &Graph<'_>, node: Node, link: &Link) {
        let end = self.end(graph, node);
        let id = (end.id.0, end.id.1, link.serializer.clone());
        if self.seen.contains(&id) {
            return;
        }
        let port = end.port.ty_span;
        let found = (end.class.language.facts().unsendable)(&end.port.ty, link.serializer.as_ref(), end.of());
        let found: Vec<_> = found.into_iter().map(|why| (end.span_of(&why), why)).collect();
        self.seen.insert(id);
        for (span, why) in found {
            let diagnostic = Diagnostic::new(Code::Unsendable, span, why.message.as_str()).hint(why.hint);
            if span == port {
                self.diagnostics.push(diagnostic.also(link.span, GOES));
            } else if self.told.insert((span, why.message)) {
                self.diagnostics.push(diagnostic.also(port, "a port has such values").also(link.span, GOES));
            }
        }
    }

    /// Reports a connection that cannot copy its values.
    fn check_copies(&mut self, graph: &Graph<'_>, link: &Link) {
        let end = self.end(graph, link.from);
        let span = end.port.ty_span;
        let Some(why) = (end.class.language.facts().uncopyable)(&end.port.ty, end.of()) else { return };
        if self.told.insert((span, why.message.clone())) {
            let diagnostic = Diagnostic::new(Code::Uncopyable, link.span, why.message).hint(why.hint);
            self.diagnostics.push(diagnostic.also(span, "the type of the source"));
        }
    }

    /// Returns the layouts of values at both ends of a connection between two languages; reports layouts that do not
    /// match, and returns `None`.
    fn shapes(&mut self, graph: &Graph<'_>, link: &Link) -> Option<(Shape, Shape)> {
        let (from, to) = (self.end(graph, link.from), self.end(graph, link.to));
        let mut found = Vec::new();
        let mut shape = |end: &TypedEnd<'_>| {
            let shape = (end.class.language.facts().shape)(&end.port.ty, end.of());
            let refused = |why: Unsendable| {
                Diagnostic::new(Code::Unsendable, end.port.ty_span, why.message)
                    .also(link.span, "it goes to a federate in another language here")
                    .hint(why.hint)
            };
            shape.map_err(|all| found.extend(all.into_iter().map(refused))).ok()
        };
        let shapes = shape(&from).zip(shape(&to));
        if let Some((one, other)) = shapes.as_ref().filter(|(one, other)| !one.fits(other)) {
            let ports = [&from, &to].map(|end| format!("{}.{}", end.class.name, end.port.name.text));
            let message = format!(
                "`{}` has type `{}`, {one}, but `{}` has type `{}`, {other}",
                ports[0], from.port.ty, ports[1], to.port.ty
            );
            let diagnostic = Diagnostic::new(Code::TypeMismatch, link.span, message)
                .also(from.port.ty_span, "the type of the source")
                .also(to.port.ty_span, "the type of the destination");
            found.push(diagnostic.hint("a value has the same bytes at both ends, whatever it is called there"));
        }
        let name = link.serializer.as_ref().and_then(Serializer::name_beside_memory);
        if let Some(name) = name {
            let message = format!("only one of the two languages of this connection has the serializer \"{name}\"");
            let hint = "remove it: values go as they lie in memory";
            found.push(Diagnostic::new(Code::BadAttribute, link.span, message).hint(hint));
        }
        let fits = found.is_empty();
        self.diagnostics.extend(found);
        shapes.filter(|_| fits)
    }
}

impl Serializer {
    /// Returns the name, unless it stands for the layout in memory.
    fn name_beside_memory(&self) -> Option<&str> {
        self.name.as_deref().filter(|name| *name != NATIVE)
    }
}
