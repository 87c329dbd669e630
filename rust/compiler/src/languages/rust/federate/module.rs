// SPDX-License-Identifier: Apache-2.0
//! What all parts of a federate's module are made from.

use core::cell::RefCell;
use std::collections::BTreeSet;

use super::symbols::Symbols;
use crate::emit::EmitError;
use crate::languages::rust::layout::Layout;
use crate::languages::rust::reactor::{parsed_type, type_alias};
use crate::languages::rust::types::is_copy;
use crate::plan::{ClassIndex, Federate, Plan, Rti, Type};
use crate::tables::Tables;

/// The module in the making.
pub(super) struct Module<'p> {
    pub(super) plan: &'p Plan,
    pub(super) federate: &'p Federate,
    pub(super) tables: Tables<'p>,
    pub(super) layout: &'p Layout<'p>,
    /// Where the RTI is, as deployed.
    pub(super) rti: Option<Rti>,
    /// Whether the RTI's clock is that of an image, which no program of this computer has.
    pub(super) rti_is_image: bool,
    pub(super) symbols: Symbols,
    /// The classes that have been named, whose modules are imported.
    pub(super) named: RefCell<BTreeSet<ClassIndex>>,
}

impl Module<'_> {
    /// The path of a class's module, as far as it is not imported.
    fn module(&self, class: ClassIndex) -> String {
        self.named.borrow_mut().insert(class);
        self.layout.imported(class)
    }

    /// The path of a class's struct.
    pub(super) fn class(&self, class: ClassIndex) -> String {
        format!("{}::{}", self.module(class), self.layout.name(class))
    }

    /// The type of the port, timer or action with this path, as it can be named here.
    ///
    /// What a preamble declares is known only to the module of the reactor, which has a name for the type.
    pub(super) fn type_of(&self, path: &str, ty: &Type) -> Result<String, EmitError> {
        let declared = path.rsplit_once('.').and_then(|(owner, name)| {
            let instance = self.federate.instances.iter().find(|instance| instance.path == owner)?;
            // A channel has the type of its multiport.
            Some((instance.class, name.split('[').next().unwrap_or(name)))
        });
        match declared {
            Some((class, name)) if !is_copy(&ty.text) => Ok(format!("{}::{}", self.module(class), type_alias(name))),
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
