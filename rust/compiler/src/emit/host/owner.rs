// SPDX-License-Identifier: Apache-2.0
//! The struct that owns all state, ports and queues, and its constructor.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::bodies::{Member, Members, tokens};
use super::module::FederateModule;
use super::splice::Splices;
use crate::emit::EmitError;
use crate::plan::{Port, TriggerKind, Type};
use crate::tables::{Cell, TriggerRow};

impl FederateModule<'_> {
    /// Emits statics through which other threads reach the physical actions.
    pub(super) fn inboxes(&self, splices: &mut Splices<'_>) -> Result<TokenStream, EmitError> {
        let mut statics = TokenStream::new();
        for (index, trigger) in self.owner.federate.triggers.iter().enumerate() {
            if let (TriggerKind::Action { physical: true, ty, .. }, Some(at)) = (&trigger.kind, trigger.at) {
                let doc = splices.doc(&format!("Events of `{}` from other threads", trigger.path), at);
                let (name, ty) = (&self.owner.symbols.inboxes[index], self.bodies.value_type(&trigger.path, ty)?);
                let ty = tokens(&self.cell_type("PhysicalInbox", &ty, Some(self.bodies.room(trigger.capacity))));
                let new = tokens(&self.bodies.cell("PhysicalInbox"));
                statics.extend(quote! {
                    #doc
                    static #name: #ty = #new::new();
                });
            }
        }
        Ok(statics)
    }

    /// Emits the struct and its constructor.
    pub(super) fn owner_struct(&self, name: &Ident, splices: &mut Splices<'_>) -> Result<TokenStream, EmitError> {
        let doc = splices.doc("All state, ports and queues", self.owner.federate.at);
        let mut members = Members::default();
        self.bodies.instances(&self.owner, &mut members, splices)?;
        let (federate, tables, symbols) = (self.owner.federate, &self.owner.tables, &self.owner.symbols);
        let mut all = Vec::new();
        for (index, (row, port)) in tables.ports.iter().zip(&federate.ports).enumerate() {
            // A port with a queue lives in the field of the trigger that fills it.
            let is_own = row.filled_by.is_none() && !self.bodies.cells_refer();
            all.push(if is_own { Some(self.port_member(index, port)?) } else { None });
        }
        members.add(splices, (&symbols.ports, &symbols.arrays.ports), &all);
        let mut all = Vec::new();
        for (index, (row, trigger)) in tables.triggers.iter().zip(&federate.triggers).enumerate() {
            let ty = match &trigger.kind {
                TriggerKind::Action { ty, .. } => Some(ty),
                _ => None,
            };
            let cell = if trigger.at.is_some() { self.cell(index, row, ty)? } else { None };
            let path = &trigger.path;
            let member = cell.zip(trigger.at).map(|((ty, value), at)| Member { word: "", path, at, ty, value });
            all.push(member);
        }
        members.add(splices, (&symbols.triggers, &symbols.arrays.triggers), &all);
        let Members { fields, values, locals } = members;
        Ok(quote! {
            #doc
            pub struct #name { #fields }
            impl #name {
                /// Returns the state before the start.
                pub fn new() -> Self {
                    #locals
                    Self { #values }
                }
            }
        })
    }

    fn port_member<'p>(&self, index: usize, port: &'p Port) -> Result<Member<'p>, EmitError> {
        let (ty, id) = (self.bodies.value_type(&port.path, &port.ty)?, Literal::usize_unsuffixed(index));
        let (ty, cell) = (self.cell_type("Port", &ty, None), tokens(&self.bodies.cell("Port")));
        Ok(Member { word: "Port ", path: &port.path, at: port.at, ty, value: quote!(#cell::new(PortId(#id))) })
    }

    /// Returns the type and the first value of a trigger's field; startup and shutdown have none.
    fn cell(
        &self,
        index: usize,
        row: &TriggerRow<'_>,
        ty: Option<&Type>,
    ) -> Result<Option<(String, TokenStream)>, EmitError> {
        let (capacity, id) = (row.capacity, Literal::usize_unsuffixed(index));
        let action = ty.map(|ty| self.bodies.value_type(row.name, ty)).transpose()?.unwrap_or_default();
        let refer = self.bodies.cells_refer();
        let (cell, ty, arguments) = match row.cell {
            Cell::None => return Ok(None),
            Cell::Timer if refer => ("Timer", None, quote!(TriggerId(#id))),
            Cell::Timer => ("Timer", None, quote!()),
            Cell::Watchdog => ("Watchdog", None, quote!(TriggerId(#id))),
            Cell::Logical => ("LogicalActionQueue", Some(action), quote!(TriggerId(#id))),
            Cell::Physical => {
                let inbox = &self.owner.symbols.inboxes[index];
                ("PhysicalActionQueue", Some(action), quote!(TriggerId(#id), &#inbox))
            }
            Cell::Queued(fills) | Cell::Tardy(fills) => {
                let cell = if row.cell == Cell::Queued(fills) { "QueuedPort" } else { "TardyInput" };
                let (ty, port) = (self.port_type(fills)?, Literal::u16_unsuffixed(fills.0));
                let trigger = refer.then(|| quote!(, TriggerId(#id)));
                (cell, Some(ty), quote!(PortId(#port) #trigger))
            }
        };
        let is_action = matches!(row.cell, Cell::Logical | Cell::Physical);
        let capacity = ty.is_some().then(|| if is_action { self.bodies.room(capacity) } else { capacity });
        let name = tokens(&self.bodies.cell(cell));
        let encoder = (row.cell == Cell::Physical && !refer).then(|| {
            let ty = tokens(ty.as_deref().unwrap_or_default());
            quote!(.encoded_by(::lf::model::encoder!(#ty)))
        });
        let new = quote!(#name::new(#arguments) #encoder);
        Ok(Some((self.cell_type(cell, &ty.unwrap_or_default(), capacity), new)))
    }
}
