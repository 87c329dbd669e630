// SPDX-License-Identifier: Apache-2.0
//! The tree of instances, with the time parameters worked out.
//!
//! Other parameters stay as they are written: the target language evaluates them when the program starts.

use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::resolve::{Class, ClassId};
use crate::syntax::ast::{Expression, ExpressionKind};
use crate::syntax::literal_ns;

/// How many instances a program may have.
const INSTANCES_MAX: usize = 10_000;

/// An instance of a reactor.
#[derive(Debug)]
pub(crate) struct Instance {
    /// Names from below the main reactor, joined by `.`; the main reactor's own name for the first.
    pub(crate) path: String,
    pub(crate) class: ClassId,
    pub(crate) parent: Option<usize>,
    /// Which of the children of the parent's class it is.
    pub(crate) child: Option<usize>,
    /// The positions of the contained instances, in the order of the class.
    pub(crate) children: Vec<usize>,
    /// The time parameters that are known, in nanoseconds, in the order of the class.
    times: Vec<Option<i64>>,
    pub(crate) span: Span,
}

/// All instances, containers before what they contain, in order of declaration. The first is the main reactor.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) instances: Vec<Instance>,
}

/// Builds the tree below the main reactor. The classes must not contain each other in a cycle.
pub(crate) fn build(classes: &[Class<'_>], main: ClassId, diagnostics: &mut Diagnostics) -> Option<Tree> {
    let mut tree = Tree { instances: Vec::new() };
    // What is to be added next stands last: parent, and which child it is.
    let mut open: Vec<(Option<usize>, Option<usize>, ClassId)> = vec![(None, None, main)];
    while let Some((parent, child, class)) = open.pop() {
        if tree.instances.len() == INSTANCES_MAX {
            let message = format!("this program has more than {INSTANCES_MAX} instances of reactors");
            diagnostics.push(Diagnostic::new(Code::TooLarge, classes[main.0].ast.span(), message));
            return None;
        }
        let position = tree.instances.len();
        let instance = tree.instance(parent, child, class, classes);
        tree.instances.push(instance);
        if let Some(parent) = parent {
            tree.instances[parent].children.push(position);
        }
        for (index, contained) in classes[class.0].children.iter().enumerate().rev() {
            if let Some(class) = contained.class {
                open.push((Some(position), Some(index), class));
            }
        }
    }
    Some(tree)
}

impl Tree {
    fn instance(&self, parent: Option<usize>, child: Option<usize>, class: ClassId, classes: &[Class<'_>]) -> Instance {
        let declared = &classes[class.0];
        let container = parent.map(|parent| &self.instances[parent]);
        let instantiation = container.zip(child).map(|(container, child)| &classes[container.class.0].children[child]);
        let (path, span) = match (container, instantiation) {
            (Some(container), Some(child)) if container.parent.is_some() => {
                (format!("{}.{}", container.path, child.ast.name.text), child.ast.name.span)
            }
            (_, Some(child)) => (child.ast.name.text.clone(), child.ast.name.span),
            _ => (declared.name.clone(), declared.ast.span()),
        };
        let mut times: Vec<Option<i64>> = Vec::new();
        for (index, parameter) in declared.parameters.iter().enumerate() {
            let given = instantiation.and_then(|child| child.arguments.get(index).copied().flatten());
            let time = match (parameter.is_time, given, parameter.default, container) {
                (true, Some(value), _, Some(container)) => {
                    evaluate(value, &classes[container.class.0], &container.times)
                }
                (true, None, Some(value), _) => evaluate(value, declared, &times),
                _ => None,
            };
            times.push(time);
        }
        Instance { path, class, parent, child, children: Vec::new(), times, span }
    }

    /// The nanoseconds of a parameter of an instance, if they are known.
    pub(crate) fn parameter(&self, instance: usize, parameter: usize) -> Option<i64> {
        self.instances[instance].times.get(parameter).copied().flatten()
    }

    /// The nanoseconds of a value in the scope of an instance; reports a value that is not known at build time.
    pub(crate) fn time(
        &self,
        instance: usize,
        value: &Expression,
        classes: &[Class<'_>],
        diagnostics: &mut Diagnostics,
    ) -> Option<i64> {
        let instance = &self.instances[instance];
        let time = evaluate(value, &classes[instance.class.0], &instance.times);
        if time.is_none() {
            let message = format!("this time is not known when the program is compiled (in `{}`)", instance.path);
            let hint = "its parameter is given as code somewhere; write a time there, like `10 ms`";
            diagnostics.push(Diagnostic::new(Code::NotATime, value.span, message).hint(hint));
        }
        time
    }
}

/// The nanoseconds of a value, given those of the parameters in its scope.
fn evaluate(value: &Expression, class: &Class<'_>, times: &[Option<i64>]) -> Option<i64> {
    match &value.kind {
        ExpressionKind::Name(name) => {
            let position = class.parameters.iter().position(|parameter| parameter.name.text == *name)?;
            times.get(position).copied().flatten()
        }
        _ => literal_ns(value),
    }
}
