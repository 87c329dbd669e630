// SPDX-License-Identifier: Apache-2.0
//! Expands reactors for instantiation: with all inherited declarations, and with types instead of type parameters.
//!
//! Later stages see neither `extends` nor type parameters: a reactor with type parameters becomes one reactor for each
//! list of types with which it is instantiated.

use std::collections::{BTreeMap, BTreeSet};

use super::load::{Program, ReactorId};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span, did_you_mean};
use crate::languages::c::TYPE_OF;
use crate::lexical::{Language, is_micro};
use crate::plan::BANK_INDEX;
use crate::syntax::ast::{
    ActionSyntax, ConnectionSyntax, Direction, ExpressionKind, Instantiation, Name, ParameterSyntax, ReactionSyntax,
    Reactor, ReactorBody, Reference, StateSyntax, TimeValue, Timer, TypeKind, TypeSyntax,
};
use crate::syntax::literal_ns;

/// The maximum number of reactors in a program, including those with other types.
const REACTORS_MAX: usize = 10_000;

/// The maximum length of a type argument, so that a reactor which contains itself with a larger type is detected soon.
const TYPE_MAX: usize = 1000;

/// The maximum number of reactors from which one inherits, directly or indirectly.
const BASES_MAX: usize = 500;

/// An expanded reactor.
#[derive(Debug)]
pub(crate) struct Expanded {
    pub(crate) id: ReactorId,
    /// Its declarations, including the inherited ones.
    pub(crate) ast: Reactor,
    /// The types that stand for its type parameters.
    pub(crate) types: Vec<TypeArgument>,
    /// Further files in which names of its code may be declared.
    pub(crate) files: Vec<usize>,
    /// The reactors that instantiate it with these types, whose declarations the types may name.
    pub(crate) users: Vec<usize>,
    /// The reactors of its instances, by position; `None` for one that does not exist.
    pub(crate) children: Vec<Option<usize>>,
}

/// A type that stands for a type parameter.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TypeArgument {
    pub(crate) name: String,
    /// The type in the target language's spelling.
    pub(crate) ty: String,
    /// The place of the type.
    pub(crate) span: Span,
}

/// Expands the reactors of the main file and all that they contain; those of the main file come first.
pub(crate) fn expand(program: &Program, diagnostics: &mut Diagnostics) -> Vec<Expanded> {
    let mut work = Expander { program, diagnostics, list: Vec::new(), known: BTreeMap::new() };
    let own = program.units.first().map_or(&[][..], |unit| &unit.ast.reactors);
    let ids = (0..own.len()).map(|reactor| ReactorId { unit: 0, reactor });
    let (plain, generic): (Vec<_>, Vec<_>) = ids.partition(|id| own[id.reactor].type_parameters.is_empty());
    for id in plain {
        work.add(id, &[], None);
    }
    work.follow(0);
    // The author of a reactor that no other one contains wants to know its errors, too.
    for id in generic {
        if !work.known.keys().any(|(known, _)| *known == id) {
            let next = work.list.len();
            work.add(id, &[], None);
            work.follow(next);
        }
    }
    work.list
}

struct Expander<'a> {
    program: &'a Program,
    diagnostics: &'a mut Diagnostics,
    list: Vec<Expanded>,
    /// The expanded reactors by reactor and type arguments.
    known: BTreeMap<(ReactorId, Vec<String>), usize>,
}

impl<'a> Expander<'a> {
    fn declared(&self, id: ReactorId) -> &'a Reactor {
        &self.program.units[id.unit].ast.reactors[id.reactor]
    }

    /// Returns the position of a reactor with these types; expands it if it is new.
    fn add(&mut self, id: ReactorId, arguments: &[TypeSyntax], user: Option<usize>) -> usize {
        let language = self.program.language(id.unit);
        let texts: Vec<String> = arguments.iter().map(|ty| (language.facts().type_text)(ty)).collect();
        if let Some(known) = self.known.get(&(id, texts.clone())).copied() {
            let users = &mut self.list[known].users;
            users.extend(user.filter(|user| !users.contains(user)));
            return known;
        }
        let declared = self.declared(id);
        let mut files = Vec::new();
        let mut ast = declared.clone();
        ast.body = ReactorBody::default();
        ast.parameters = Vec::new();
        self.inherit(id, &mut ast, &mut files, &mut Vec::new());
        let named = declared.type_parameters.iter().zip(arguments);
        let types: Vec<(&str, &TypeSyntax)> = named.map(|(parameter, ty)| (parameter.name.text.as_str(), ty)).collect();
        if is_micro(self.program.target_name(id.unit)) {
            from_micro(&mut ast);
        }
        for ty in types_of(&mut ast) {
            substitute(ty, &types, language);
        }
        files.extend(arguments.iter().map(|ty| self.unit_of(ty.span)));
        files.sort_unstable();
        files.dedup();
        files.retain(|file| *file != id.unit);
        let types = types.iter().zip(&texts).map(|((name, ty), text)| TypeArgument {
            name: (*name).to_owned(),
            ty: text.clone(),
            span: ty.span,
        });
        let types = types.collect();
        self.known.insert((id, texts), self.list.len());
        self.list.push(Expanded { id, ast, types, files, users: user.into_iter().collect(), children: Vec::new() });
        self.list.len() - 1
    }

    /// Finds the reactors of all instances from this position on.
    fn follow(&mut self, mut next: usize) {
        while next < self.list.len() {
            let instances = std::mem::take(&mut self.list[next].ast.body.instances);
            let children = instances.iter().map(|instance| self.child(instance, next)).collect();
            self.list[next].ast.body.instances = instances;
            self.list[next].children = children;
            next += 1;
            if self.list.len() > REACTORS_MAX {
                let message = format!("this program has more than {REACTORS_MAX} reactors with different types");
                let span = self.list[next - 1].ast.span();
                self.diagnostics.push(Diagnostic::new(Code::TooLarge, span, message));
                return;
            }
        }
    }

    fn child(&mut self, instance: &Instantiation, container: usize) -> Option<usize> {
        let id = self.find(&instance.class, "declare it, or import it")?;
        let declared = self.declared(id);
        let language = self.program.language(id.unit);
        let (given, needed) = (instance.type_arguments.len(), declared.type_parameters.len());
        let name = &instance.class.text;
        let mut arguments = &instance.type_arguments[..];
        if given > 0 && needed == 0 && language.facts().superfluous_types {
            let message = format!("`{name}` has no type parameters, so these types have no effect");
            let diagnostic = Diagnostic::new(Code::NoEffect, instance.class.span, message);
            self.diagnostics.push(diagnostic.hint(format!("write `new {name}(…)`")));
            arguments = &[];
        } else if given != needed {
            let message = format!("`{name}` has {needed} type parameters, and here are {given} types");
            let hint = if needed == 0 {
                format!("write `new {name}(…)`")
            } else {
                let names = declared.type_parameters.iter().map(|it| it.name.text.as_str());
                format!("write a type for each: `new {name}<{}>(…)`", names.collect::<Vec<_>>().join(", "))
            };
            let diagnostic = Diagnostic::new(Code::TypeArguments, instance.class.span, message).hint(hint);
            self.diagnostics.push(diagnostic.also(declared.span(), "its declaration"));
            return None;
        }
        if arguments.iter().any(|ty| (language.facts().type_text)(ty).len() > TYPE_MAX) {
            let message = format!("the name of a type is longer than {TYPE_MAX} bytes here");
            let hint = "a reactor cannot contain itself with another type";
            self.diagnostics.push(Diagnostic::new(Code::TooLarge, instance.class.span, message).hint(hint));
            return None;
        }
        // Types that are no names of the containing reactor need no search in it.
        let user = (needed > 0).then_some(container);
        Some(self.add(id, arguments, user))
    }

    /// Returns the reactor of a name in the file of that name.
    fn find(&mut self, name: &Name, otherwise: &str) -> Option<ReactorId> {
        let scope = &self.program.units[self.unit_of(name.span)].scope;
        if let Some(id) = scope.get(&name.text) {
            return Some(*id);
        }
        let hint = did_you_mean(&name.text, scope.keys().map(String::as_str))
            .unwrap_or_else(|| format!("{otherwise}: `import {0} from \"{0}.lf\"`", name.text));
        let message = format!("there is no reactor `{}` in this file", name.text);
        self.diagnostics.push(Diagnostic::new(Code::UnknownReactor, name.span, message).hint(hint));
        None
    }

    /// Returns the file of a place: texts have the order of files.
    fn unit_of(&self, span: Span) -> usize {
        span.file.index().min(self.program.units.len() - 1)
    }

    /// Adds the inherited declarations of a reactor, and then its own. A reactor from which several others inherit
    /// counts once.
    fn inherit(&mut self, id: ReactorId, to: &mut Reactor, files: &mut Vec<usize>, done: &mut Vec<ReactorId>) {
        done.push(id);
        let declared = self.declared(id);
        let others = to.parameters.len();
        for name in &declared.extends {
            let Some(base) = self.find(name, "declare it, or import it") else { continue };
            if base == id || self.inherits(base, id, &mut BTreeSet::new()) {
                let message = format!("`{}` inherits from itself", name.text);
                let hint = "a reactor cannot extend itself, neither directly nor through others";
                self.diagnostics.push(Diagnostic::new(Code::CyclicInstantiation, name.span, message).hint(hint));
            } else if self.program.language(base.unit) != self.program.language(id.unit) {
                let language = self.program.language(base.unit);
                let message = format!("`{}` has bodies in {language}, so nothing else can inherit from it", name.text);
                let hint = "only federates of one federation can be in different languages";
                self.diagnostics.push(Diagnostic::new(Code::WrongTarget, name.span, message).hint(hint));
            } else if !done.contains(&base) {
                files.push(base.unit);
                self.inherit(base, to, files, done);
            }
        }
        let inherited = others..to.parameters.len();
        for parameter in &declared.parameters {
            let same = |inherited: &&mut ParameterSyntax| inherited.name.text == parameter.name.text;
            match to.parameters[inherited.clone()].iter_mut().find(same) {
                // Its own default replaces the inherited one.
                Some(inherited) => inherited.clone_from(parameter),
                None => to.parameters.push(parameter.clone()),
            }
        }
        append(&mut to.body, &declared.body);
    }

    /// Returns whether a reactor inherits from another one, directly or indirectly.
    fn inherits(&self, id: ReactorId, from: ReactorId, seen: &mut BTreeSet<ReactorId>) -> bool {
        let scope = &self.program.units[id.unit].scope;
        let bases = self.declared(id).extends.iter().filter_map(|name| scope.get(&name.text));
        let bases: Vec<ReactorId> = bases.copied().collect();
        seen.len() > BASES_MAX
            || bases.into_iter().any(|base| base == from || (seen.insert(base) && self.inherits(base, from, seen)))
    }
}

/// Writes what micro LF writes otherwise: the index of a bank's member has another name, a policy also decides about
/// events at one time if the minimum spacing is 0, each input has an array of its own, and pointers are values like any
/// other.
fn from_micro(reactor: &mut Reactor) {
    const MICRO: &str = "bank_idx";
    for action in reactor.body.actions.iter_mut().filter(|action| action.policy.is_some()) {
        if let Some(spacing) = action.min_spacing.as_mut().filter(|spacing| literal_ns(spacing) == Some(0)) {
            let unit = Name { text: "ns".to_owned(), span: spacing.span };
            spacing.kind = ExpressionKind::Time(TimeValue::Interval { negative: false, digits: "1".to_owned(), unit });
        }
    }
    for port in &mut reactor.body.ports {
        let suffix = port.ty.as_ref().and_then(|ty| match &ty.kind {
            TypeKind::Path { c_suffix, .. } => c_suffix.as_ref(),
            _ => None,
        });
        port.mutable |= port.direction == Direction::Input && suffix.is_some_and(|suffix| suffix.text.starts_with('['));
    }
    let ports = reactor.body.ports.iter_mut().map(|port| &mut port.ty);
    for ty in ports.chain(reactor.body.actions.iter_mut().map(|action| &mut action.ty)).flatten() {
        if matches!(&ty.kind, TypeKind::Path { c_suffix: Some(suffix), .. } if suffix.text.ends_with('*')) {
            ty.kind = TypeKind::Code(format!("{TYPE_OF}({})", (Language::C.facts().type_text)(ty)));
        }
    }
    let rename = |name: &mut String| {
        if name == MICRO {
            BANK_INDEX.clone_into(name);
        }
    };
    reactor.parameters.iter_mut().for_each(|parameter| rename(&mut parameter.name.text));
    for argument in reactor.body.instances.iter_mut().flat_map(|instance| &mut instance.arguments) {
        rename(&mut argument.name.text);
        if let ExpressionKind::Name(name) = &mut argument.init.value.kind {
            rename(name);
        }
    }
}

/// Replaces type parameters by types.
fn substitute(ty: &mut TypeSyntax, types: &[(&str, &TypeSyntax)], language: Language) {
    match &mut ty.kind {
        TypeKind::Time => {}
        TypeKind::Code(text) => {
            for (name, by) in types {
                *text = replace_word(text, name, &(language.facts().type_text)(by));
            }
        }
        TypeKind::Path { segments, arguments, c_suffix } => {
            if let ([one], []) = (&segments[..], &arguments[..])
                && let Some((_, by)) = types.iter().find(|(name, _)| name == one)
            {
                ty.kind = match c_suffix {
                    Some(suffix) => TypeKind::Code((language.facts().type_text)(by) + &suffix.text),
                    None => by.kind.clone(),
                };
                return;
            }
            for argument in arguments {
                substitute(argument, types, language);
            }
        }
    }
}

/// Appends all declarations of a reactor.
fn append(to: &mut ReactorBody, from: &ReactorBody) {
    let ReactorBody { preambles, states, methods, ports, timers, actions, instances, connections, reactions, modes } =
        from.clone();
    // A mode is identified by its position.
    let first = to.modes.len();
    let moved = |mode: Option<usize>| mode.map(|mode| first + mode);
    to.preambles.extend(preambles);
    to.states.extend(states.into_iter().map(|it| StateSyntax { mode: moved(it.mode), ..it }));
    to.methods.extend(methods);
    to.ports.extend(ports);
    to.timers.extend(timers.into_iter().map(|it| Timer { mode: moved(it.mode), ..it }));
    to.actions.extend(actions.into_iter().map(|it| ActionSyntax { mode: moved(it.mode), ..it }));
    // A connection that repeats an inherited one is the same one.
    let connections =
        connections.into_iter().filter(|own| !to.connections.iter().any(|inherited| repeats(own, inherited)));
    let connections: Vec<_> = connections.collect();
    // Both reactions run when an inherited one has the same name, but only one has it.
    for inherited in to.reactions.iter_mut().filter(|inherited| inherited.code.is_some()) {
        let has_name = |own: &ReactionSyntax| {
            own.name.as_ref().zip(inherited.name.as_ref()).is_some_and(|(a, b)| a.text == b.text)
        };
        if reactions.iter().any(has_name) {
            inherited.name = None;
        }
    }
    to.instances.extend(instances.into_iter().map(|it| Instantiation { mode: moved(it.mode), ..it }));
    to.connections.extend(connections.into_iter().map(|it| ConnectionSyntax { mode: moved(it.mode), ..it }));
    to.reactions.extend(reactions.into_iter().map(|it| ReactionSyntax { mode: moved(it.mode), ..it }));
    to.modes.extend(modes);
}

/// Returns whether a connection without a delay connects the same ports as another one.
fn repeats(one: &ConnectionSyntax, other: &ConnectionSyntax) -> bool {
    let texts = |side: &[Reference]| side.iter().map(Reference::text).collect::<Vec<_>>();
    let is_plain = |it: &ConnectionSyntax| it.mode.is_none() && it.after.is_none() && !it.iterated;
    is_plain(one)
        && is_plain(other)
        && one.physical.is_some() == other.physical.is_some()
        && texts(&one.left) == texts(&other.left)
        && texts(&one.right) == texts(&other.right)
}

/// Returns all types in a reactor.
fn types_of(reactor: &mut Reactor) -> Vec<&mut TypeSyntax> {
    let ReactorBody { states, methods, ports, actions, instances, .. } = &mut reactor.body;
    let parameters = reactor.parameters.iter_mut().filter_map(|it| it.ty.as_mut());
    let mut types: Vec<&mut TypeSyntax> = parameters.collect();
    types.extend(states.iter_mut().filter_map(|it| it.ty.as_mut()));
    types.extend(ports.iter_mut().filter_map(|it| it.ty.as_mut()));
    types.extend(actions.iter_mut().filter_map(|it| it.ty.as_mut()));
    for method in methods {
        types.extend(method.arguments.iter_mut().filter_map(|(_, ty)| ty.as_mut()));
        types.extend(method.ty.as_mut());
    }
    types.extend(instances.iter_mut().flat_map(|it| &mut it.type_arguments));
    types
}

/// Replaces a name in code, if it stands as a word of its own.
fn replace_word(text: &str, word: &str, by: &str) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let (mut replaced, mut rest) = (String::new(), text);
    while let Some(start) = rest.find(word) {
        let (before, found) = rest.split_at(start);
        let behind = &found[word.len()..];
        let alone = !before.ends_with(is_part) && !behind.starts_with(is_part);
        replaced = replaced + before + if alone { by } else { word };
        rest = behind;
    }
    replaced + rest
}

#[cfg(test)]
mod tests {
    use super::replace_word;

    #[test]
    fn only_whole_words_are_type_parameters() {
        assert_eq!(replace_word("Option<T>", "T", "u32"), "Option<u32>");
        assert_eq!(replace_word("Vec<(T, MyT, T_)>", "T", "u8"), "Vec<(u8, MyT, T_)>");
        assert_eq!(replace_word("U", "T", "u8"), "U");
    }
}
