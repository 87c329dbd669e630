// SPDX-License-Identifier: Apache-2.0
//! What all parts of a federate's module are made from.

use core::cell::RefCell;
use std::collections::BTreeSet;

use super::symbols::Identifiers;
use crate::emit::EmitError;
use crate::languages::c::Sizes;
use crate::languages::rust::layout::Layout;
use crate::languages::rust::reactor::{parsed_type, type_alias};
use crate::languages::rust::sending::max_len;
use crate::languages::rust::types::is_copy;
use crate::plan::{ClassIndex, Federate, Plan, Rti, Serializer, Type};
use crate::tables::Tables;

/// Where the bodies are that the module runs.
#[derive(Clone, Copy)]
pub(in crate::languages) enum Bodies<'p> {
    /// In modules of the same crate, which has types, state and methods for them.
    Rust(&'p Layout<'p>),
    /// In C, where ports and state are, too: the module has the queues, of references to values.
    C {
        /// How long payloads are.
        sizes: &'p Sizes<'p>,
        /// Whether it is a board's, where memory is scarce.
        is_image: bool,
    },
}

/// The module in the making.
pub(super) struct FederateModule<'p> {
    pub(super) plan: &'p Plan,
    pub(super) federate: &'p Federate,
    pub(super) tables: Tables<'p>,
    pub(super) bodies: Bodies<'p>,
    /// Where the RTI is, as deployed.
    pub(super) rti: Option<Rti>,
    /// Whether the RTI's clock is that of an image, which no program of this computer has.
    pub(super) rti_is_image: bool,
    pub(super) symbols: Identifiers,
    /// The classes that have been named, whose modules are imported.
    pub(super) named: RefCell<BTreeSet<ClassIndex>>,
}

impl<'p> FederateModule<'p> {
    /// The modules of the classes, where the bodies are Rust.
    pub(super) fn layout(&self) -> Option<&'p Layout<'p>> {
        match self.bodies {
            Bodies::Rust(layout) => Some(layout),
            Bodies::C { .. } => None,
        }
    }

    /// How many threads run reactions.
    pub(super) fn workers(&self) -> u16 {
        self.layout().map_or(1, Layout::workers)
    }

    /// The path of a class's module, as far as it is not imported.
    fn module(&self, layout: &Layout<'_>, class: ClassIndex) -> String {
        self.named.borrow_mut().insert(class);
        layout.imported(class)
    }

    /// The path of a class's struct.
    pub(super) fn class(&self, layout: &Layout<'_>, class: ClassIndex) -> String {
        format!("{}::{}", self.module(layout, class), layout.name(class))
    }

    /// The type of a cell: of values of a type in Rust, of any in C.
    pub(super) fn cell_type(&self, name: &str, ty: &str, capacity: Option<usize>) -> String {
        let value = self.layout().is_some() && !ty.is_empty();
        let value = value.then(|| ty.to_owned());
        let arguments: Vec<String> = value.into_iter().chain(capacity.map(|capacity| capacity.to_string())).collect();
        let arguments = if arguments.is_empty() { String::new() } else { format!("<{}>", arguments.join(", ")) };
        format!("{}{arguments}", self.cell_name(name))
    }

    /// The name of a cell's type.
    pub(super) fn cell_name(&self, name: &str) -> String {
        if self.layout().is_some() { name.to_owned() } else { format!("c::{}", name.trim_end_matches("Queue")) }
    }

    /// How many events an action holds. Programs in C count on queues that grow; on a computer, a long one is the same.
    pub(super) fn room(&self, capacity: usize) -> usize {
        const ROOM: usize = 256;
        if matches!(self.bodies, Bodies::C { is_image: false, .. }) { capacity.max(ROOM) } else { capacity }
    }

    /// How many bytes a value of a port takes at most, as an expression.
    pub(super) fn max_len(&self, port: lf_model::PortId, serializer: Option<&Serializer>) -> Result<String, EmitError> {
        match self.bodies {
            Bodies::Rust(_) => Ok(max_len(serializer, &self.port_type(port)?)),
            Bodies::C { sizes, .. } => Ok(sizes.max_len(&self.federate.ports[usize::from(port.0)], serializer)),
        }
    }

    /// The type of the port, timer or action with this path, as it can be named here.
    ///
    /// What a preamble declares is known only to the module of the reactor, which has a name for the type.
    pub(super) fn type_of(&self, path: &str, ty: &Type) -> Result<String, EmitError> {
        let Some(layout) = self.layout() else { return Ok(String::new()) };
        let declared = path.rsplit_once('.').and_then(|(owner, name)| {
            let instance = self.federate.instances.iter().find(|instance| instance.path == owner)?;
            // A channel has the type of its multiport.
            Some((instance.class, name.split('[').next().unwrap_or(name)))
        });
        match declared {
            Some((class, name)) if !is_copy(&ty.text) => {
                Ok(format!("{}::{}", self.module(layout, class), type_alias(name)))
            }
            _ => parsed_type(self.plan, ty).map(|_| ty.text.clone()),
        }
    }

    /// The same for a port.
    pub(super) fn port_type(&self, port: lf_model::PortId) -> Result<String, EmitError> {
        let port = &self.federate.ports[usize::from(port.0)];
        self.type_of(&port.path, &port.ty)
    }

    /// The place expression of a port.
    pub(super) fn port_place(&self, port: usize) -> String {
        let queued = if self.tables.ports[port].filled_by.is_some() { ".port" } else { "" };
        format!("self.{}{queued}", self.symbols.ports[port])
    }
}
