// SPDX-License-Identifier: Apache-2.0
//! What all parts of a federate's module are made from.

use super::bodies::Bodies;
use super::sending::serializer_type;
use super::symbols::Identifiers;
use crate::emit::{EmitError, Job};
use crate::plan::{Federate, Plan, Rti, Serializer};
use crate::tables::Tables;

/// The module in the making.
pub(in crate::emit) struct FederateModule<'p> {
    pub(super) job: &'p Job<'p>,
    pub(in crate::emit) plan: &'p Plan,
    pub(in crate::emit) federate: &'p Federate,
    pub(in crate::emit) tables: Tables<'p>,
    pub(super) bodies: &'p dyn Bodies,
    /// Where the RTI is, as deployed.
    pub(super) rti: Option<Rti>,
    /// Whether the RTI's clock is that of an image, which no program of this computer has.
    pub(super) rti_is_image: bool,
    pub(in crate::emit) symbols: Identifiers,
}

impl FederateModule<'_> {
    /// Returns how many threads run reactions.
    pub(in crate::emit) fn workers(&self) -> u16 {
        self.job.workers()
    }

    /// Returns the type of a cell for values of a type, which is empty where cells hold any.
    pub(super) fn cell_type(&self, name: &str, ty: &str, capacity: Option<usize>) -> String {
        let value = Some(ty.to_owned()).filter(|ty| !ty.is_empty());
        let arguments: Vec<String> = value.into_iter().chain(capacity.map(|capacity| capacity.to_string())).collect();
        let arguments = if arguments.is_empty() { String::new() } else { format!("<{}>", arguments.join(", ")) };
        format!("{}{arguments}", self.bodies.cell(name))
    }

    /// Returns how many bytes a value of a port takes at most, as an expression.
    pub(super) fn max_len(&self, port: lf_model::PortId, serializer: Option<&Serializer>) -> Result<String, EmitError> {
        let ty = self.port_type(port)?;
        Ok(self.bodies.max_len(&self.federate.ports[usize::from(port.0)], &ty, serializer))
    }

    /// Returns the type of the values of a port, as it can be named here.
    pub(super) fn port_type(&self, port: lf_model::PortId) -> Result<String, EmitError> {
        let port = &self.federate.ports[usize::from(port.0)];
        self.bodies.value_type(&port.path, &port.ty)
    }

    /// Returns what the names of methods that make bytes of values end with, where a serializer is given.
    pub(super) fn by(&self, serializer: Option<&Serializer>, port: lf_model::PortId) -> String {
        // A type that cannot be named has been refused when the tables were made.
        let ty = self.port_type(port).unwrap_or_default();
        serializer.map(|serializer| format!("_by::<{}>", serializer_type(serializer, &ty))).unwrap_or_default()
    }

    /// Returns the place expression of a port.
    pub(in crate::emit) fn port_place(&self, port: usize) -> String {
        let queued = if self.tables.ports[port].filled_by.is_some() { ".port" } else { "" };
        format!("self.{}{queued}", self.symbols.ports[port])
    }
}
