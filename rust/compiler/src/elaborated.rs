// SPDX-License-Identifier: Apache-2.0
//! An instantiated and partitioned program, the input of analysis.

use crate::diagnostics::Diagnostics;
use crate::federates::{Participants, cut};
use crate::instances::{InstanceId, Tree, build};
use crate::resolve::{Class, ClassId};
use crate::syntax::ast::Expression;

/// The reactors of a program, the tree of their instances, and the federates into which the tree is cut.
#[derive(Debug)]
pub(crate) struct Elaborated<'p> {
    pub(crate) classes: &'p [Class<'p>],
    pub(crate) tree: Tree,
    pub(crate) parts: Participants,
}

impl<'p> Elaborated<'p> {
    /// Instantiates the main reactor and cuts the tree. Returns `None` if an instance is wrong.
    pub(crate) fn new(classes: &'p [Class<'p>], main: ClassId, diagnostics: &mut Diagnostics) -> Option<Self> {
        let mut tree = build(classes, main, diagnostics)?;
        let parts = cut(&mut tree, classes, diagnostics);
        Some(Self { classes, tree, parts })
    }

    /// Returns the reactor of an instance.
    pub(crate) fn class(&self, instance: InstanceId) -> &'p Class<'p> {
        &self.classes[self.tree.instances[instance].class.0]
    }

    /// Returns the main or federated reactor.
    pub(crate) fn main(&self) -> &'p Class<'p> {
        self.class(InstanceId::MAIN)
    }

    /// Returns the federate that an instance belongs to; none for the federated reactor.
    pub(crate) fn part(&self, instance: InstanceId) -> Option<usize> {
        self.parts.of[instance]
    }

    /// Returns the nanoseconds of a value in the scope of an instance; reports one that is not known at build time.
    pub(crate) fn time(&self, instance: InstanceId, value: &Expression, diagnostics: &mut Diagnostics) -> Option<i64> {
        self.tree.time(instance, value, self.class(instance), diagnostics)
    }
}
