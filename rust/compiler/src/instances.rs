// SPDX-License-Identifier: Apache-2.0
//! The tree of instances: each member of a bank, with the values of parameters that are times or numbers, and the
//! widths of ports.
//!
//! Other parameters stay as they are written: the target language evaluates them when the program starts.

use core::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use crate::arena::{Arena, ArenaId as _, arena_ids};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::plan::{BANK_INDEX, Fixed};
use crate::resolve::{Class, ClassId};
use crate::syntax::ast::{Expression, ExpressionKind, Instantiation, Literal, Width, WidthTerm};
use crate::syntax::literal_ns;

/// The maximum number of instances in a program.
const INSTANCES_MAX: usize = 10_000;

/// The maximum number of channels of a port, and of members of a bank: the tables number them in 16 bits.
const WIDTH_MAX: i64 = u16::MAX as i64;

arena_ids! {
    /// A position in [`Tree::instances`].
    pub(crate) InstanceId;
    /// A position in [`Tree::modes`].
    pub(crate) ModeInstanceId;
}

impl InstanceId {
    /// The main or federated reactor.
    pub(crate) const MAIN: Self = Self(0);
}

/// An instance of a reactor.
#[derive(Clone, Debug)]
pub(crate) struct ReactorInstance {
    /// The names from below the main reactor, joined by `.`; the main reactor's own name for the first instance. A
    /// member of a bank has its number behind its name: `sensors[2]`.
    pub(crate) path: String,
    pub(crate) class: ClassId,
    pub(crate) parent: Option<InstanceId>,
    /// The index of its child declaration in the class of the parent.
    pub(crate) child: Option<usize>,
    /// The index of the member of a bank.
    pub(crate) bank_index: Option<usize>,
    /// Per child of the class: the position of the instance, or those of a bank's members.
    pub(crate) children: Vec<Vec<InstanceId>>,
    /// Per port of the class: the number of channels; `None` if it is no multiport.
    pub(crate) widths: Vec<Option<usize>>,
    /// The innermost mode that it is in.
    pub(crate) mode: Option<ModeInstanceId>,
    /// The first of its own modes.
    first_mode: ModeInstanceId,
    /// The known parameters, in the order of the class; times in nanoseconds.
    numbers: Vec<Option<i64>>,
    /// The parameters of the main reactor from which each of these was computed.
    origins: Vec<Origins>,
    pub(crate) span: Span,
}

/// Parameters of the main reactor, by their positions.
type Origins = BTreeSet<usize>;

/// A mode of an instance.
#[derive(Debug)]
pub(crate) struct ModeInstance {
    pub(crate) instance: InstanceId,
    /// Its position in the class.
    pub(crate) declared: usize,
    pub(crate) initial: bool,
}

/// All instances, containers before their contents, in order of declaration. The first is the main reactor; the
/// [shares](Self::add_share) of federates follow all others.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) instances: Arena<InstanceId, ReactorInstance>,
    /// The modes of all instances, in their order.
    pub(crate) modes: Arena<ModeInstanceId, ModeInstance>,
    /// The requested parameters of the main reactor on which widths or times depend.
    fixed: RefCell<BTreeMap<usize, Fixed>>,
}

impl Tree {
    /// Returns the kind of values that are fixed at compile time and follow from a parameter of the main reactor.
    pub(crate) fn fixed(&self, parameter: usize) -> Option<Fixed> {
        self.fixed.borrow().get(&parameter).copied()
    }

    fn fix(&self, origins: &Origins, by: Fixed) {
        let mut fixed = self.fixed.borrow_mut();
        for origin in origins {
            fixed.entry(*origin).or_insert(by);
        }
    }

    /// Adds a federate's share of the federated reactor, for the reactions of that: its state, its timers and actions,
    /// and of its contained reactors only the federate's own instance.
    pub(crate) fn add_share(&mut self, top: InstanceId) {
        let mut share = self.instances[InstanceId::MAIN].clone();
        // No instance can have this name.
        share.path = format!("{}.federated", self.instances[top].path);
        share.children.iter_mut().for_each(|members| members.retain(|member| *member == top));
        self.instances.push(share);
    }

    /// Returns whether an instance is the share of a federate.
    pub(crate) fn is_share(&self, instance: InstanceId) -> bool {
        instance != InstanceId::MAIN && self.instances[instance].parent.is_none()
    }
}

/// An instance to add to the tree.
struct Next {
    parent: Option<InstanceId>,
    child: Option<usize>,
    bank_index: Option<usize>,
    class: ClassId,
}

/// Builds the tree below the main reactor. The classes must not contain each other in a cycle.
pub(crate) fn build(classes: &[Class<'_>], main: ClassId, diagnostics: &mut Diagnostics) -> Option<Tree> {
    let mut work = TreeBuilder { classes, diagnostics, tree: Tree::default() };
    // The next one is the last.
    let mut open = vec![Next { parent: None, child: None, bank_index: None, class: main }];
    while let Some(next) = open.pop() {
        if work.tree.instances.len() >= INSTANCES_MAX {
            let message = format!("this program has more than {INSTANCES_MAX} instances of reactors");
            work.diagnostics.push(Diagnostic::new(Code::TooLarge, classes[main.0].ast.span(), message));
            return None;
        }
        let class = next.class;
        let instance = work.instance(&next);
        let position = work.tree.instances.push(instance);
        let modes = classes[class.0].ast.body.modes.iter().enumerate();
        let modes = modes.map(|(declared, mode)| ModeInstance { instance: position, declared, initial: mode.initial });
        work.tree.modes.extend(modes);
        if let (Some(parent), Some(child)) = (next.parent, next.child) {
            work.tree.instances[parent].children[child].push(position);
        }
        let mut contained = Vec::new();
        for (index, child) in classes[class.0].children.iter().enumerate() {
            let Some(class) = child.class else { continue };
            let count = child.ast.width.as_ref().map(|width| work.width(position, width).unwrap_or_default());
            let members = count.map_or(vec![None], |count| (0..count).map(Some).collect());
            contained.extend(members.into_iter().map(|bank_index| Next {
                parent: Some(position),
                child: Some(index),
                bank_index,
                class,
            }));
            if open.len() + contained.len() > INSTANCES_MAX {
                break;
            }
        }
        open.extend(contained.into_iter().rev());
    }
    let tree = work.tree;
    (!diagnostics.has_errors()).then_some(tree)
}

struct TreeBuilder<'a> {
    classes: &'a [Class<'a>],
    diagnostics: &'a mut Diagnostics,
    tree: Tree,
}

impl TreeBuilder<'_> {
    fn instance(&mut self, next: &Next) -> ReactorInstance {
        let declared = &self.classes[next.class.0];
        let container = next.parent.map(|parent| &self.tree.instances[parent]);
        let child =
            container.zip(next.child).map(|(container, child)| &self.classes[container.class.0].children[child]);
        let named = |instantiation: &Instantiation| match next.bank_index {
            Some(index) => format!("{}[{index}]", instantiation.name.text),
            None => instantiation.name.text.clone(),
        };
        let (path, span) = match (container, child) {
            (Some(container), Some(child)) if container.parent.is_some() => {
                (format!("{}.{}", container.path, named(child.ast)), child.ast.name.span)
            }
            (_, Some(child)) => (named(child.ast), child.ast.name.span),
            _ => (declared.name.clone(), declared.ast.span()),
        };
        let (mut numbers, mut origins) = (Vec::<Option<i64>>::new(), Vec::<Origins>::new());
        for (index, parameter) in declared.parameters.iter().enumerate() {
            let given = child.and_then(|child| child.arguments.get(index).copied().flatten());
            let member = next.bank_index.filter(|_| parameter.name.text == BANK_INDEX).map(as_number);
            let (number, mut used) = match (given, member, parameter.default, container) {
                (Some(value), _, _, Some(container)) => {
                    let scope = Scope::new(&self.classes[container.class.0], &container.numbers, &container.origins);
                    (scope.number(value, next.bank_index), scope.used.into_inner())
                }
                (None, Some(member), _, _) => (Some(member), Origins::new()),
                (None, None, Some(value), _) => {
                    let scope = Scope::new(declared, &numbers, &origins);
                    (scope.number(value, None), scope.used.into_inner())
                }
                _ => (None, Origins::new()),
            };
            numbers.push(number);
            if container.is_none() {
                used.insert(index);
            }
            origins.push(used);
        }
        let mut instance = ReactorInstance {
            path,
            class: next.class,
            parent: next.parent,
            child: next.child,
            bank_index: next.bank_index,
            children: vec![Vec::new(); declared.children.len()],
            widths: Vec::new(),
            mode: next.parent.and_then(|parent| self.tree.mode_of(parent, child.and_then(|child| child.ast.mode))),
            first_mode: self.tree.modes.next_id(),
            numbers,
            origins,
            span,
        };
        for port in &declared.ports {
            let width = port.width.map(|width| self.sum(&instance, width).unwrap_or_default());
            instance.widths.push(width);
        }
        instance
    }

    /// Returns the width of a bank in an instance.
    fn width(&mut self, instance: InstanceId, width: &Width) -> Option<usize> {
        // The instances return to the tree below.
        let instances = std::mem::take(&mut self.tree.instances);
        let sum = self.sum(&instances[instance], width);
        self.tree.instances = instances;
        sum
    }

    /// Returns a width in the scope of an instance; reports one that is unknown or too large.
    fn sum(&mut self, instance: &ReactorInstance, width: &Width) -> Option<usize> {
        let class = &self.classes[instance.class.0];
        let scope = Scope::new(class, &instance.numbers, &instance.origins);
        let mut sum = 0_i64;
        for term in &width.terms {
            let (known, span) = match term {
                WidthTerm::Value(value) => (scope.number(value, None), value.span),
                WidthTerm::WidthOf(port) => {
                    let own = class.ports.iter().position(|own| own.name.text == port.name.text);
                    let own = own.filter(|_| port.container.is_none());
                    let known = own.and_then(|own| instance.widths.get(own).copied());
                    (known.map(|width| as_number(width.unwrap_or(1))), port.span)
                }
            };
            let Some(known) = known else {
                let message = format!("this width is not known when the program is compiled (in `{}`)", instance.path);
                let hint = "a width is a number, a parameter with one, arithmetic of them as code, or `widthof` of a \
                            port of this reactor that is declared before it";
                self.diagnostics.push(Diagnostic::new(Code::BadWidth, span, message).hint(hint));
                return None;
            };
            sum = sum.saturating_add(known);
        }
        self.tree.fix(&scope.used.into_inner(), Fixed::Width);
        if !(0..=WIDTH_MAX).contains(&sum) {
            let message = format!("this width is {sum} in `{}`, and has to be one of 0 to {WIDTH_MAX}", instance.path);
            self.diagnostics.push(Diagnostic::new(Code::BadWidth, width.span, message));
        }
        usize::try_from(sum).ok().filter(|_| sum <= WIDTH_MAX)
    }
}

fn as_number(index: usize) -> i64 {
    i64::try_from(index).unwrap_or(i64::MAX)
}

impl Tree {
    /// Returns the innermost mode of an element in an instance, which is declared in one of its modes or in none.
    pub(crate) fn mode_of(&self, instance: InstanceId, declared: Option<usize>) -> Option<ModeInstanceId> {
        let instance = &self.instances[instance];
        declared.map_or(instance.mode, |mode| Some(ModeInstanceId::at(instance.first_mode.position() + mode)))
    }

    /// Returns a mode and those that contain it, from the inside.
    pub(crate) fn modes_around(&self, mode: Option<ModeInstanceId>) -> impl Iterator<Item = ModeInstanceId> {
        core::iter::successors(mode, |mode| self.instances[self.modes[*mode].instance].mode)
    }

    /// Returns whether elements of the two modes are never active at the same time.
    pub(crate) fn exclude(&self, one: Option<ModeInstanceId>, other: Option<ModeInstanceId>) -> bool {
        let apart = |one: ModeInstanceId, other: ModeInstanceId| {
            one != other && self.modes[one].instance == self.modes[other].instance
        };
        self.modes_around(one).any(|one| self.modes_around(other).any(|other| apart(one, other)))
    }

    /// Returns the nanoseconds of a parameter of an instance, if they are known.
    pub(crate) fn parameter(&self, instance: InstanceId, parameter: usize) -> Option<i64> {
        let instance = &self.instances[instance];
        instance.origins.get(parameter).inspect(|origins| self.fix(origins, Fixed::Time));
        instance.numbers.get(parameter).copied().flatten()
    }

    /// Returns the nanoseconds of a value in the scope of an instance; reports a value that is unknown at compile time.
    pub(crate) fn time(
        &self,
        instance: InstanceId,
        value: &Expression,
        class: &Class<'_>,
        diagnostics: &mut Diagnostics,
    ) -> Option<i64> {
        let instance = &self.instances[instance];
        let scope = Scope::new(class, &instance.numbers, &instance.origins);
        let time = scope.time(value);
        self.fix(&scope.used.into_inner(), Fixed::Time);
        if time.is_none() {
            let message = format!("this time is not known when the program is compiled (in `{}`)", instance.path);
            let hint = "its parameter is given as code somewhere; write a time there, like `10 ms`";
            diagnostics.push(Diagnostic::new(Code::NotATime, value.span, message).hint(hint));
        }
        time
    }
}

/// The parameters that a value can name, as far as they are known.
struct Scope<'a> {
    class: &'a Class<'a>,
    numbers: &'a [Option<i64>],
    origins: &'a [Origins],
    /// The origins of the requested parameters.
    used: RefCell<Origins>,
}

impl<'a> Scope<'a> {
    fn new(class: &'a Class<'a>, numbers: &'a [Option<i64>], origins: &'a [Origins]) -> Self {
        Self { class, numbers, origins, used: RefCell::default() }
    }

    fn parameter(&self, name: &str) -> Option<i64> {
        let position = self.class.parameters.iter().position(|parameter| parameter.name.text == name)?;
        self.used.borrow_mut().extend(self.origins.get(position).into_iter().flatten());
        self.numbers.get(position).copied().flatten()
    }

    fn time(&self, value: &Expression) -> Option<i64> {
        match &value.kind {
            ExpressionKind::Name(name) => self.parameter(name),
            _ => literal_ns(value),
        }
    }

    /// Returns a time or an integer. In an argument of a bank's member, `bank_index` is the number of the member,
    /// unless the container has such a parameter.
    fn number(&self, value: &Expression, bank_index: Option<usize>) -> Option<i64> {
        let named = |name: &str| {
            let own = self.class.parameters.iter().any(|parameter| parameter.name.text == name);
            let member = bank_index.filter(|_| name == BANK_INDEX && !own);
            member.map(as_number).or_else(|| self.parameter(name))
        };
        match &value.kind {
            ExpressionKind::Name(name) => named(name),
            ExpressionKind::Literal(Literal::Int(digits)) => digits.parse().ok(),
            ExpressionKind::Code(code) => (self.class.language.facts().integer)(&code.text, &named),
            _ => literal_ns(value),
        }
    }
}
