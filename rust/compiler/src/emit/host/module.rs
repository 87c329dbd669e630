// SPDX-License-Identifier: Apache-2.0
//! The common data of all parts of a federate's module.

use super::bodies::Bodies;
use super::symbols::Owner;
use crate::emit::EmitError;
use crate::plan::{Rti, Serializer};

/// The module under construction.
pub(super) struct FederateModule<'p> {
    pub(super) owner: Owner<'p>,
    pub(super) bodies: &'p dyn Bodies,
    /// The address of the RTI, as deployed.
    pub(super) rti: Option<Rti>,
    /// Whether the RTI's clock is that of an image, which no program of this computer has.
    pub(super) rti_is_image: bool,
}

impl FederateModule<'_> {
    /// Returns the type of a cell for values of a type, which is empty if cells hold any.
    pub(super) fn cell_type(&self, name: &str, ty: &str, capacity: Option<usize>) -> String {
        let value = Some(ty.to_owned()).filter(|ty| !ty.is_empty());
        let arguments: Vec<String> = value.into_iter().chain(capacity.map(|capacity| capacity.to_string())).collect();
        let arguments = if arguments.is_empty() { String::new() } else { format!("<{}>", arguments.join(", ")) };
        format!("{}{arguments}", self.bodies.cell(name))
    }

    /// Returns the maximum number of bytes of a port's value, as an expression.
    pub(super) fn max_len(&self, port: lf_model::PortId, serializer: Option<&Serializer>) -> Result<String, EmitError> {
        let ty = self.port_type(port)?;
        Ok(self.bodies.max_len(&self.owner.federate.ports[usize::from(port.0)], &ty, serializer))
    }

    /// Returns the type of a port's values, as it can be named in this module.
    pub(super) fn port_type(&self, port: lf_model::PortId) -> Result<String, EmitError> {
        let port = &self.owner.federate.ports[usize::from(port.0)];
        self.bodies.value_type(&port.path, &port.ty)
    }

    /// Returns the expression of a port: its place, or a reference to it.
    pub(super) fn port(&self, port: usize) -> String {
        if self.bodies.cells_refer() {
            format!("{}::new(PortId({port}))", self.bodies.cell("Port"))
        } else {
            self.owner.port_place(port)
        }
    }

    /// Returns the suffix of the methods that convert values to bytes, if a serializer is given.
    pub(super) fn by(&self, serializer: Option<&Serializer>, port: lf_model::PortId) -> String {
        // The tables have refused a type that cannot be named.
        let ty = self.port_type(port).unwrap_or_default();
        let by = serializer.and_then(|serializer| self.bodies.serializer(serializer, &ty));
        by.map(|by| format!("_by::<{by}>")).unwrap_or_default()
    }
}
