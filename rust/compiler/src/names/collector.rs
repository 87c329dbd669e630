// SPDX-License-Identifier: Apache-2.0
//! Walks the trees of a program: first all declarations, then all references to them.

use std::collections::{BTreeMap, BTreeSet};

use super::bodies::{CodeWords, WordUse};
use super::declaration::{Declaration, NameKind};
use crate::diagnostics::{SourceTexts, Span};
use crate::lexical::Language;
use crate::resolve::{Program, ReactorId};
use crate::syntax::ast::{
    ActionKind, CodeBlock, Direction, Expression, ExpressionKind, Instantiation, Name, ReactionKeyword, ReactionSyntax,
    Reactor, Reference, TypeKind, TypeSyntax, Width, WidthTerm,
};
use crate::syntax::comment_before;

/// The declarations of a reactor by their names. A parameter, a state variable and a port may share one.
type ByName<'p> = BTreeMap<&'p str, Vec<usize>>;

/// The kinds of elements that a place can name.
type Kinds = &'static [NameKind];

/// The elements that bodies find behind `self`.
const FIELDS: Kinds = &[NameKind::State, NameKind::Parameter, NameKind::Method];

/// The elements that values can name.
const VALUES: Kinds = &[NameKind::Parameter];

/// The elements that types can name.
const TYPES: Kinds = &[NameKind::TypeParameter];

/// The elements that reactions and connections can name.
const ELEMENTS: Kinds = &[
    NameKind::Input,
    NameKind::Output,
    NameKind::Timer,
    NameKind::LogicalAction,
    NameKind::PhysicalAction,
    NameKind::Watchdog,
    NameKind::Instance,
    NameKind::Mode,
];

/// Collects declarations and the places that name them.
pub(super) struct Collector<'p> {
    program: &'p Program,
    texts: &'p SourceTexts,
    declarations: Vec<Declaration>,
    places: BTreeMap<Span, usize>,
    reactors: BTreeMap<ReactorId, usize>,
    members: BTreeMap<ReactorId, ByName<'p>>,
    /// The reactors of instances, by the declarations of the instances.
    classes: BTreeMap<usize, ReactorId>,
}

impl<'p> Collector<'p> {
    pub(super) fn new(program: &'p Program, texts: &'p SourceTexts) -> Self {
        Self {
            program,
            texts,
            declarations: Vec::new(),
            places: BTreeMap::new(),
            reactors: BTreeMap::new(),
            members: BTreeMap::new(),
            classes: BTreeMap::new(),
        }
    }

    /// Returns the declarations, and the places that name them.
    pub(super) fn collected(mut self) -> (Vec<Declaration>, BTreeMap<Span, usize>) {
        let reactors: Vec<_> = reactors(self.program).collect();
        for (id, reactor) in &reactors {
            self.declare_reactor(*id, reactor);
        }
        for (unit, file) in self.program.units.iter().enumerate() {
            for imported in file.ast.imports.iter().flat_map(|import| &import.reactors) {
                let local = imported.alias.as_ref().unwrap_or(&imported.name);
                for name in [Some(&imported.name), imported.alias.as_ref()].into_iter().flatten() {
                    self.reactor(unit, &local.text, name.span);
                }
            }
        }
        for (id, reactor) in reactors {
            self.uses(id, reactor);
        }
        (self.declarations, self.places)
    }

    fn declare(&mut self, unit: usize, name: &Name, kind: NameKind, ty: Option<String>) -> usize {
        let unit = &self.program.units[unit];
        let text = self.texts.get(name.span.file).map_or("", |file| file.text());
        // A parameter on the line of its reactor's name has no comment of its own.
        let is_beside =
            kind == NameKind::Parameter && !text[..name.span.start].trim_end_matches([' ', '\t']).ends_with('\n');
        let docs = comment_before(text, &unit.ast.comments, name.span.start).filter(|_| !is_beside);
        let declaration = self.declarations.len();
        self.declarations.push(Declaration { span: name.span, kind, ty, docs });
        self.places.insert(name.span, declaration);
        declaration
    }

    fn declare_reactor(&mut self, id: ReactorId, reactor: &'p Reactor) {
        if let Some(name) = &reactor.name {
            let declaration = self.declare(id.unit, name, NameKind::Reactor, None);
            self.reactors.insert(id, declaration);
        }
        let facts = self.program.language(id.unit).facts();
        let spelled = |ty: &TypeSyntax| if ty.is_time() { "time".to_owned() } else { (facts.type_text)(ty) };
        let text = |ty: &Option<TypeSyntax>| ty.as_ref().map(spelled);
        let body = &reactor.body;
        let mut all: Vec<(&'p Name, NameKind, Option<String>)> = Vec::new();
        all.extend(reactor.type_parameters.iter().map(|it| (&it.name, NameKind::TypeParameter, None)));
        all.extend(reactor.parameters.iter().map(|it| (&it.name, NameKind::Parameter, text(&it.ty))));
        all.extend(body.states.iter().map(|it| (&it.name, NameKind::State, text(&it.ty))));
        all.extend(body.methods.iter().map(|it| (&it.name, NameKind::Method, text(&it.ty))));
        all.extend(body.ports.iter().map(|it| {
            let kind = if it.direction == Direction::Input { NameKind::Input } else { NameKind::Output };
            (&it.name, kind, text(&it.ty))
        }));
        all.extend(body.timers.iter().map(|it| (&it.name, NameKind::Timer, None)));
        all.extend(body.actions.iter().map(|it| {
            let kind = match it.kind {
                ActionKind::Logical => NameKind::LogicalAction,
                ActionKind::Physical => NameKind::PhysicalAction,
                ActionKind::Watchdog => NameKind::Watchdog,
            };
            (&it.name, kind, text(&it.ty))
        }));
        all.extend(body.instances.iter().map(|it| {
            let types: Vec<String> = it.type_arguments.iter().map(spelled).collect();
            let types = if types.is_empty() { String::new() } else { format!("<{}>", types.join(", ")) };
            (&it.name, NameKind::Instance, Some(it.class.text.clone() + &types))
        }));
        all.extend(body.modes.iter().filter_map(|it| Some((it.name.as_ref()?, NameKind::Mode, None))));
        let named = body.reactions.iter().filter(|reaction| reaction.kind != ReactionKeyword::Watchdog);
        all.extend(named.filter_map(|it| Some((it.name.as_ref()?, NameKind::Reaction, None))));
        let mut members = ByName::new();
        for (name, kind, ty) in all {
            let declaration = self.declare(id.unit, name, kind, ty);
            members.entry(name.text.as_str()).or_default().push(declaration);
        }
        for instance in &body.instances {
            let class = self.program.units[id.unit].scope.get(&instance.class.text);
            if let (Some(class), Some(declaration)) = (class, self.places.get(&instance.name.span)) {
                self.classes.insert(*declaration, *class);
            }
        }
        self.members.insert(id, members);
    }

    /// Notes that a place names a reactor of a file's scope.
    fn reactor(&mut self, unit: usize, name: &str, place: Span) {
        let id = self.program.units[unit].scope.get(name);
        if let Some(declaration) = id.and_then(|id| self.reactors.get(id)) {
            self.places.insert(place, *declaration);
        }
    }

    /// Returns a declaration of a reactor, or of one from which it inherits; the first one of a kind counts.
    fn member(&self, id: ReactorId, name: &str, kinds: Kinds) -> Option<usize> {
        let (mut open, mut seen) = (vec![id], BTreeSet::new());
        while let Some(id) = open.pop() {
            let of_name = self.members.get(&id)?.get(name).map_or(&[][..], Vec::as_slice);
            let of_kind = |kind: &NameKind| of_name.iter().find(|one| self.declarations[**one].kind == *kind);
            if let Some(found) = kinds.iter().find_map(of_kind) {
                return Some(*found);
            }
            if seen.insert(id) {
                let unit = &self.program.units[id.unit];
                let bases = unit.ast.reactors[id.reactor].extends.iter().rev();
                open.extend(bases.filter_map(|base| unit.scope.get(&base.text)));
            }
        }
        None
    }

    /// Notes that a place names an element of a reactor, and returns that element.
    fn name(&mut self, id: ReactorId, name: &str, kinds: Kinds, place: Span) -> Option<usize> {
        let found = self.member(id, name, kinds)?;
        self.places.insert(place, found);
        Some(found)
    }

    fn uses(&mut self, id: ReactorId, reactor: &'p Reactor) {
        for base in &reactor.extends {
            self.reactor(id.unit, &base.text, base.span);
        }
        for parameter in &reactor.parameters {
            self.ty(id, parameter.ty.as_ref());
            self.values(id, parameter.init.iter().map(|init| &init.value));
        }
        let body = &reactor.body;
        for state in &body.states {
            self.ty(id, state.ty.as_ref());
            self.values(id, state.init.iter().map(|init| &init.value));
        }
        for method in &body.methods {
            self.ty(id, method.ty.as_ref());
            method.arguments.iter().for_each(|(_, ty)| self.ty(id, ty.as_ref()));
            self.code(id, &method.code, &[]);
        }
        for port in &body.ports {
            self.ty(id, port.ty.as_ref());
            self.width(id, port.width.as_ref());
        }
        for timer in &body.timers {
            self.values(id, timer.offset.iter().chain(&timer.period));
        }
        for action in &body.actions {
            self.ty(id, action.ty.as_ref());
            self.values(id, action.min_delay.iter().chain(&action.min_spacing));
        }
        for instance in &body.instances {
            self.instance(id, instance);
        }
        for connection in &body.connections {
            connection.left.iter().chain(&connection.right).for_each(|reference| self.reference(id, reference));
            self.values(id, &connection.after);
        }
        for reaction in &body.reactions {
            let references = reaction.triggers.iter().chain(&reaction.uses).chain(&reaction.effects);
            references.for_each(|reference| self.reference(id, reference));
            self.values(id, reaction.deadline.iter().map(|deadline| &deadline.value));
            self.values(id, reaction.tardy.iter().filter_map(|tardy| tardy.absent_after.as_ref()));
            let handlers = [
                reaction.code.as_ref(),
                reaction.tardy.as_ref().and_then(|tardy| tardy.code.as_ref()),
                reaction.deadline.as_ref().map(|deadline| &deadline.code),
            ];
            let signature = signature(reaction);
            handlers.into_iter().flatten().for_each(|code| self.code(id, code, &signature));
        }
    }

    /// Notes the words of code that name elements: those of the reaction's signature, and what stands behind `self`.
    fn code(&mut self, id: ReactorId, code: &CodeBlock, signature: &[&Reference]) {
        let language = self.program.language(id.unit);
        for word in CodeWords::of(language, &code.text) {
            let start = code.span.start + word.start;
            let place = |from: usize, text: &str| Span::new(code.span.file, start + from, start + from + text.len());
            match word.kind {
                WordUse::Field => drop(self.name(id, word.text, FIELDS, place(0, word.text))),
                WordUse::Of(container) if language == Language::C => {
                    let ports = signature.iter().filter(|it| it.name.text == word.text);
                    let mut ports = ports.filter_map(|it| it.container.as_ref());
                    if let Some(container) = ports.find(|it| it.text == container) {
                        self.port(id, &container.text, word.text, place(0, word.text));
                    }
                }
                WordUse::Variable => {
                    for reference in signature {
                        let name = reference.name.text.as_str();
                        match &reference.container {
                            None if name == word.text => drop(self.name(id, name, ELEMENTS, place(0, name))),
                            Some(container) if language == Language::C && container.text == word.text => {
                                self.name(id, word.text, ELEMENTS, place(0, word.text));
                            }
                            Some(container) => {
                                let rest = word.text.strip_prefix(container.text.as_str());
                                if rest.and_then(|rest| rest.strip_prefix("__")) == Some(name) {
                                    self.name(id, &container.text, ELEMENTS, place(0, &container.text));
                                    self.port(id, &container.text, name, place(container.text.len() + 2, name));
                                }
                            }
                            None => {}
                        }
                    }
                }
                WordUse::Of(_) => {}
                WordUse::Call => drop(self.name(id, word.text, &[NameKind::Method], place(0, word.text))),
            }
        }
    }

    /// Notes that a place names a port of a contained reactor.
    fn port(&mut self, id: ReactorId, container: &str, port: &str, place: Span) {
        let instance = self.member(id, container, &[NameKind::Instance]);
        if let Some(class) = instance.and_then(|instance| self.classes.get(&instance).copied()) {
            self.name(class, port, ELEMENTS, place);
        }
    }

    fn instance(&mut self, id: ReactorId, instance: &Instantiation) {
        self.reactor(id.unit, &instance.class.text, instance.class.span);
        self.width(id, instance.width.as_ref());
        instance.type_arguments.iter().for_each(|ty| self.ty(id, Some(ty)));
        let class = self.program.units[id.unit].scope.get(&instance.class.text).copied();
        for argument in &instance.arguments {
            if let Some(class) = class {
                self.name(class, &argument.name.text, VALUES, argument.name.span);
            }
            self.values(id, [&argument.init.value]);
        }
    }

    fn reference(&mut self, id: ReactorId, reference: &Reference) {
        let Reference { container, name, .. } = reference;
        let class = match container {
            Some(container) => {
                let instance = self.name(id, &container.text, ELEMENTS, container.span);
                instance.and_then(|instance| self.classes.get(&instance).copied())
            }
            None => Some(id),
        };
        if let Some(class) = class {
            self.name(class, &name.text, ELEMENTS, name.span);
        }
    }

    fn width(&mut self, id: ReactorId, width: Option<&Width>) {
        for term in width.iter().flat_map(|width| &width.terms) {
            match term {
                WidthTerm::Value(value) => self.values(id, [value]),
                WidthTerm::WidthOf(reference) => self.reference(id, reference),
            }
        }
    }

    fn values<'v>(&mut self, id: ReactorId, values: impl IntoIterator<Item = &'v Expression>) {
        for value in values {
            match &value.kind {
                ExpressionKind::Name(name) => drop(self.name(id, name, VALUES, value.span)),
                ExpressionKind::List(list) => self.values(id, list),
                ExpressionKind::Literal(_) | ExpressionKind::Time(_) | ExpressionKind::Code(_) => {}
            }
        }
    }

    /// Notes type parameters.
    fn ty(&mut self, id: ReactorId, ty: Option<&TypeSyntax>) {
        let Some(TypeSyntax { kind: TypeKind::Path { segments, arguments, c_suffix }, span }) = ty else { return };
        if let ([name], [], None) = (&segments[..], &arguments[..], c_suffix) {
            self.name(id, name, TYPES, *span);
        }
        for argument in arguments {
            self.ty(id, Some(argument));
        }
    }
}

/// Returns the names in a reaction's signature.
fn signature(reaction: &ReactionSyntax) -> Vec<&Reference> {
    reaction.triggers.iter().chain(&reaction.uses).chain(&reaction.effects).collect()
}

/// Returns all reactors of a program with their numbers.
fn reactors(program: &Program) -> impl Iterator<Item = (ReactorId, &Reactor)> {
    program.units.iter().enumerate().flat_map(|(unit, file)| {
        file.ast.reactors.iter().enumerate().map(move |(reactor, ast)| (ReactorId { unit, reactor }, ast))
    })
}
