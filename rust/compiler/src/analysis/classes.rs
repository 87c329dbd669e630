// SPDX-License-Identifier: Apache-2.0
//! The reactors in the plan.

use std::collections::BTreeMap;

use super::serializer::of_state;
use crate::diagnostics::{SourceTexts, Span};
use crate::elaborated::Elaborated;
use crate::lexical::Language;
use crate::plan::{self, ClassIndex, Location, Type, Value};
use crate::resolve::{CheckedMethod, Class, ClassId, PortRef, Variable, signature};
use crate::syntax::{ast, literal_ns};

/// Converts spans to locations.
#[derive(Debug)]
pub(super) struct Places<'s> {
    sources: &'s SourceTexts,
}

impl<'s> Places<'s> {
    pub(super) fn new(sources: &'s SourceTexts) -> Self {
        Self { sources }
    }

    pub(super) fn at(&self, span: Span) -> Location {
        let file = self.sources.iter().position(|(id, _)| id == span.file).unwrap_or_default();
        let position = self.sources.get(span.file).map(|file| file.position(span.start));
        let (line, column) = position.map_or((1, 1), |position| (position.line, position.column));
        Location { file: plan::FileIndex(file), line, column }
    }

    pub(super) fn code(&self, code: &ast::CodeBlock) -> plan::SourceCode {
        plan::SourceCode { text: code.text.clone(), at: self.at(code.span) }
    }

    pub(super) fn ty(&self, text: &str, span: Span) -> Type {
        Type { text: text.to_owned(), at: self.at(span) }
    }

    fn value(&self, value: &ast::Expression, ty: &str, is_time: bool, language: Language) -> Value {
        if let Some(ns) = literal_ns(value).filter(|_| is_time) {
            return Value::Time { ns };
        }
        match &value.kind {
            ast::ExpressionKind::Code(code) => Value::Code(self.code(code)),
            _ => Value::Code(plan::SourceCode {
                text: (language.facts().value_text)(value, ty),
                at: self.at(value.span),
            }),
        }
    }
}

/// The instantiated reactors, including those of empty banks.
#[derive(Debug)]
pub(super) struct Described {
    pub(super) classes: Vec<plan::ReactorClass>,
    /// Their positions in the plan.
    pub(super) index: BTreeMap<ClassId, ClassIndex>,
}

/// Describes the instantiated reactors in the order of their first instances, and those of banks without members.
pub(super) fn describe(program: &Elaborated<'_>, decentralized: bool, places: &Places<'_>) -> Described {
    let classes = program.classes;
    let mut order: Vec<ClassId> = Vec::new();
    let mut index = BTreeMap::new();
    let mut add = |class: ClassId, order: &mut Vec<ClassId>| {
        index.entry(class).or_insert_with(|| {
            order.push(class);
            ClassIndex(order.len() - 1)
        });
    };
    for instance in program.tree.instances.values() {
        add(instance.class, &mut order);
    }
    // A bank without members has a class, too, whose ports reactions name.
    let mut next = 0;
    while let Some(class) = order.get(next).copied() {
        for child in classes[class.0].children.iter().filter_map(|child| child.class) {
            add(child, &mut order);
        }
        next += 1;
    }
    let mut described: Vec<_> = order.iter().map(|id| class(&classes[id.0], classes, &index, places)).collect();
    if !decentralized {
        // No message is tardy in that case, and images need not contain handlers that never run.
        described.iter_mut().flat_map(|class| &mut class.reactions).for_each(|reaction| reaction.tardy = None);
    }
    Described { classes: described, index }
}

fn class(
    class: &Class<'_>,
    classes: &[Class<'_>],
    index: &BTreeMap<ClassId, ClassIndex>,
    places: &Places<'_>,
) -> plan::ReactorClass {
    let parameters = class.parameters.iter().map(|parameter| plan::Parameter {
        name: parameter.name.text.clone(),
        ty: places.ty(&parameter.ty, parameter.ty_span),
        default: parameter.default.map(|value| places.value(value, &parameter.ty, parameter.is_time, class.language)),
        fixed: None,
        at: places.at(parameter.name.span),
    });
    let state = class.states.iter().map(|state| plan::StateVariable {
        name: state.name.text.clone(),
        ty: places.ty(&state.ty, state.ty_span),
        init: state.init.map(|value| places.value(value, &state.ty, state.is_time, class.language)),
        resets: state.resets,
        handed_over: state.handed_over.as_ref().map(|sending| plan::Handover { serializer: of_state(sending) }),
        mode: state.mode,
        at: places.at(state.name.span),
    });
    let ports = class.ports.iter().map(|port| plan::PortDeclaration {
        name: port.name.text.clone(),
        direction: match port.direction {
            ast::Direction::Input => plan::PortDirection::Input,
            ast::Direction::Output => plan::PortDirection::Output,
        },
        mutable: port.mutable,
        ty: places.ty(&port.ty, port.ty_span),
        is_wide: port.width.is_some(),
        at: places.at(port.name.span),
    });
    let (watchdogs, actions): (Vec<_>, Vec<_>) =
        class.actions.iter().partition(|action| action.ast.kind == ast::ActionKind::Watchdog);
    let actions = actions.into_iter().map(|action| plan::ActionDeclaration {
        name: action.ast.name.text.clone(),
        physical: action.ast.kind == ast::ActionKind::Physical,
        ty: places.ty(&action.ty, action.ty_span),
        at: places.at(action.ast.name.span),
    });
    let timer = |name: &ast::Name| plan::TimerDeclaration { name: name.text.clone(), at: places.at(name.span) };
    let timers = class.timers.iter().map(|declared| timer(&declared.name));
    let watchdogs = watchdogs.into_iter().map(|declared| timer(&declared.ast.name));
    let body = &class.ast.body;
    plan::ReactorClass {
        name: class.name.clone(),
        at: places.at(class.ast.span()),
        docs: class.ast.docs.clone(),
        types: class.types.iter().map(|it| (it.name.clone(), places.ty(&it.ty, it.span))).collect(),
        files: class.files.iter().map(|file| plan::FileIndex(*file)).collect(),
        users: class.users.iter().filter_map(|user| index.get(user).copied()).collect(),
        preambles: body.preambles.iter().map(|preamble| places.code(&preamble.code)).collect(),
        parameters: parameters.collect(),
        state: state.collect(),
        ports: ports.collect(),
        actions: actions.collect(),
        timers: timers.collect(),
        watchdogs: watchdogs.collect(),
        children: children(class, classes, index, places),
        methods: class.methods.iter().map(|method| self::method(method, places)).collect(),
        reactions: reactions(class, classes, places),
    }
}

fn method(method: &CheckedMethod<'_>, places: &Places<'_>) -> plan::Method {
    plan::Method {
        name: method.ast.name.text.clone(),
        constant: method.ast.constant,
        arguments: method.arguments.iter().map(|(name, ty, span)| (name.clone(), places.ty(ty, *span))).collect(),
        ty: method.ty.as_ref().map(|(ty, span)| places.ty(ty, *span)),
        body: places.code(&method.ast.code),
        at: places.at(method.ast.name.span),
    }
}

fn children(
    class: &Class<'_>,
    classes: &[Class<'_>],
    index: &BTreeMap<ClassId, ClassIndex>,
    places: &Places<'_>,
) -> Vec<plan::Child> {
    let mut children = Vec::new();
    for child in &class.children {
        let Some((id, class_index)) = child.class.and_then(|id| index.get(&id).map(|index| (id, *index))) else {
            continue;
        };
        let arguments = child.arguments.iter().zip(&classes[id.0].parameters).map(|(given, parameter)| {
            given.map(|value| places.value(value, &parameter.ty, parameter.is_time, classes[id.0].language))
        });
        children.push(plan::Child {
            name: child.ast.name.text.clone(),
            class: class_index,
            arguments: arguments.collect(),
            is_bank: child.ast.width.is_some(),
            at: places.at(child.ast.name.span),
        });
    }
    children
}

fn reactions(class: &Class<'_>, classes: &[Class<'_>], places: &Places<'_>) -> Vec<plan::Reaction> {
    let mut reactions = Vec::new();
    for (position, reaction) in class.reactions.iter().enumerate() {
        let parameters = reaction.parameters.iter().filter_map(|parameter| {
            Some(plan::ReactionParameter {
                name: parameter.name.clone(),
                child: child_port(parameter.variable, class, classes),
                kind: variable_kind(parameter.variable, class, classes, places)?,
                triggers: parameter.triggers,
                uses: parameter.uses,
                effect: parameter.effect,
                at: places.at(parameter.span),
            })
        });
        let declared = reaction.ast;
        let is_external = declared.code.is_none() && class.language.facts().external_bodies;
        let empty = || plan::SourceCode { text: String::new(), at: places.at(declared.keyword) };
        reactions.push(plan::Reaction {
            number: position + 1,
            name: declared.name.as_ref().map(|name| name.text.clone()),
            signature: signature(declared),
            parameters: parameters.collect(),
            body: declared.code.as_ref().map_or_else(empty, |code| places.code(code)),
            external: is_external && declared.name.is_some(),
            deadline: declared.deadline.as_ref().map(|deadline| places.code(&deadline.code)),
            tardy: declared.tardy.as_ref().map(|tardy| match &tardy.code {
                Some(code) => plan::Tardy::Handler(places.code(code)),
                None => plan::Tardy::Body,
            }),
            at: places.at(declared.keyword),
        });
    }
    reactions
}

/// Returns the port of a contained reactor behind a variable.
fn child_port(variable: Variable, class: &Class<'_>, classes: &[Class<'_>]) -> Option<plan::ChildPort> {
    let Variable::Port(port @ PortRef::Child(child, _)) = variable else { return None };
    let declared = class.port(port, classes)?;
    Some(plan::ChildPort {
        child: class.children[child].ast.name.text.clone(),
        is_bank: class.is_of_bank(port),
        port: declared.name.text.clone(),
        is_wide: declared.width.is_some(),
    })
}

/// Returns the kind of a variable; `None` for startup and shutdown, which bodies do not see.
fn variable_kind(
    variable: Variable,
    class: &Class<'_>,
    classes: &[Class<'_>],
    places: &Places<'_>,
) -> Option<plan::VariableKind> {
    Some(match variable {
        Variable::Startup | Variable::Shutdown | Variable::Reset => return None,
        Variable::Mode(_, transition) => plan::VariableKind::Mode { history: transition == ast::Transition::History },
        Variable::Timer(_) => plan::VariableKind::Timer,
        Variable::Action(action) => {
            let action = &class.actions[action];
            let ty = places.ty(&action.ty, action.ty_span);
            match action.ast.kind {
                ast::ActionKind::Logical => plan::VariableKind::LogicalAction { ty },
                ast::ActionKind::Physical => plan::VariableKind::PhysicalAction { ty },
                ast::ActionKind::Watchdog => plan::VariableKind::Watchdog,
            }
        }
        Variable::Port(port) => {
            let is_wide = class.is_wide(port, classes);
            let port = class.port(port, classes)?;
            let ty = places.ty(&port.ty, port.ty_span);
            if is_wide { plan::VariableKind::Multiport { ty } } else { plan::VariableKind::Port { ty } }
        }
    })
}
