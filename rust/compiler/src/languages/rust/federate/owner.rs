// SPDX-License-Identifier: Apache-2.0
//! The struct that owns all state, ports and queues, and its constructor.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::module::FederateModule;
use crate::emit::EmitError;
use crate::languages::rust::layout::Layout;
use crate::languages::rust::reactor::child_method;
use crate::languages::rust::splice::Splices;
use crate::plan::{ClassIndex, Location, TriggerKind, Type};
use crate::tables::{Cell, TriggerRow};

/// Fields of the struct and what its constructor says.
#[derive(Default)]
struct Members {
    fields: TokenStream,
    values: TokenStream,
    locals: TokenStream,
}

/// What has been put together from names that are Rust, as tokens.
fn tokens(text: &str) -> TokenStream {
    text.parse().unwrap_or_default()
}

impl FederateModule<'_> {
    /// Statics through which other threads reach the physical actions.
    pub(super) fn inboxes(&self, splices: &mut Splices<'_>) -> Result<TokenStream, EmitError> {
        let mut statics = TokenStream::new();
        for (index, trigger) in self.federate.triggers.iter().enumerate() {
            if let (TriggerKind::Action { physical: true, ty, .. }, Some(at)) = (&trigger.kind, trigger.at) {
                let doc = splices.doc(&format!("Events of `{}` from other threads", trigger.path), at);
                let (name, ty) = (&self.symbols.inboxes[index], self.type_of(&trigger.path, ty)?);
                let ty = tokens(&self.cell_type("PhysicalInbox", &ty, Some(self.room(trigger.capacity))));
                let new = tokens(&self.cell_name("PhysicalInbox"));
                statics.extend(quote! {
                    #doc
                    static #name: #ty = #new::new();
                });
            }
        }
        Ok(statics)
    }

    /// The struct and its constructor.
    pub(super) fn owner(&self, name: &Ident, splices: &mut Splices<'_>) -> Result<TokenStream, EmitError> {
        let doc = splices.doc("All state, ports and queues", self.federate.at);
        let mut members = Members::default();
        self.instances(&mut members, splices)?;
        for (index, (row, port)) in self.tables.ports.iter().zip(&self.federate.ports).enumerate() {
            // A port with a queue lives in the field of the trigger that fills it.
            if row.filled_by.is_none() {
                let (ty, id) = (self.type_of(&port.path, &port.ty)?, Literal::usize_unsuffixed(index));
                let name = tokens(&self.cell_name("Port"));
                let value = quote!(#name::new(PortId(#id)));
                let (doc, ty) = ((format!("Port `{}`", port.path), port.at), self.cell_type("Port", &ty, None));
                members.field(splices, doc, &self.symbols.ports[index], &ty, &value);
            }
        }
        for (index, (row, trigger)) in self.tables.triggers.iter().zip(&self.federate.triggers).enumerate() {
            let Some(at) = trigger.at else { continue };
            let ty = match &trigger.kind {
                TriggerKind::Action { ty, .. } => Some(ty),
                _ => None,
            };
            if let Some((ty, value)) = self.cell(index, row, ty)? {
                members.field(splices, (format!("`{}`", trigger.path), at), &self.symbols.triggers[index], &ty, &value);
            }
        }
        let Members { fields, values, locals } = members;
        Ok(quote! {
            #doc
            pub struct #name { #fields }
            impl #name {
                /// Everything as it is before the start.
                pub fn new() -> Self {
                    #locals
                    Self { #values }
                }
            }
        })
    }

    /// Makes the instances, containers first, and keeps those that have reactions.
    fn instances(&self, members: &mut Members, splices: &mut Splices<'_>) -> Result<(), EmitError> {
        let (federate, main) = (self.federate, &self.symbols.main);
        let Some(layout) = self.layout() else {
            members.locals.extend(quote! { c::construct(); });
            return Ok(());
        };
        if self.plan.is_federated() {
            let value = self.new_main(layout)?;
            members.locals.extend(quote! { let #main = #value; });
        }
        for (index, instance) in federate.instances.iter().enumerate() {
            let field = &self.symbols.instances[index];
            let value = match self.plan.child(federate, instance) {
                None => self.new_main(layout)?,
                Some(child) => {
                    let container = instance.parent.map_or(main, |parent| &self.symbols.instances[parent.0]);
                    let method = child_method(child);
                    let member = instance.bank_index.map(Literal::usize_unsuffixed);
                    quote!(#container.#method(#member))
                }
            };
            let is_kept = !self.plan.class(instance).reactions.is_empty();
            let is_container = federate.instances.iter().any(|other| other.parent.is_some_and(|at| at.0 == index));
            members.locals.extend(if is_kept || is_container {
                quote! { let #field = #value; }
            } else {
                // Its initial values are still worked out; a variable would be one that nothing uses.
                quote! { let _ = #value; }
            });
            if is_kept {
                let doc = splices.doc(&format!("Instance `{}`", instance.path), instance.at);
                let path = tokens(&self.class(layout, instance.class));
                members.fields.extend(quote! { #doc #field: #path, });
                members.values.extend(quote! { #field, });
            }
        }
        Ok(())
    }

    /// The main reactor, all of whose parameters have their defaults.
    fn new_main(&self, layout: &Layout<'_>) -> Result<TokenStream, EmitError> {
        let ClassIndex(main) = self.plan.main;
        let class = &self.plan.classes[main];
        if let Some(parameter) = class.parameters.iter().find(|parameter| parameter.default.is_none()) {
            let message = format!("`{}` of the main reactor needs a default value", parameter.name);
            return Err(EmitError::new(self.plan, parameter.at, message));
        }
        let path = tokens(&self.class(layout, self.plan.main));
        let arguments = class.parameters.iter().map(|_| quote!(None));
        Ok(quote!(#path::new(#(#arguments),*)))
    }

    /// The type and the first value of a trigger's field; startup and shutdown have none.
    fn cell(
        &self,
        index: usize,
        row: &TriggerRow<'_>,
        ty: Option<&Type>,
    ) -> Result<Option<(String, TokenStream)>, EmitError> {
        let (capacity, id) = (row.capacity, Literal::usize_unsuffixed(index));
        let action = ty.map(|ty| self.type_of(row.name, ty)).transpose()?.unwrap_or_default();
        // In C, each cell knows where the program shows it to bodies.
        let of_c = self.layout().is_none();
        let (cell, ty, arguments) = match row.cell {
            Cell::None => return Ok(None),
            Cell::Timer if of_c => ("Timer", None, quote!(TriggerId(#id))),
            Cell::Timer => ("Timer", None, quote!()),
            Cell::Watchdog => ("Watchdog", None, quote!(TriggerId(#id))),
            Cell::Logical => ("LogicalActionQueue", Some(action), quote!(TriggerId(#id))),
            Cell::Physical => {
                let inbox = &self.symbols.inboxes[index];
                ("PhysicalActionQueue", Some(action), quote!(TriggerId(#id), &#inbox))
            }
            Cell::Queued(fills) | Cell::Tardy(fills) => {
                let cell = if row.cell == Cell::Queued(fills) { "QueuedPort" } else { "TardyInput" };
                let (ty, port) = (self.port_type(fills)?, Literal::u16_unsuffixed(fills.0));
                let trigger = of_c.then(|| quote!(, TriggerId(#id)));
                (cell, Some(ty), quote!(PortId(#port) #trigger))
            }
        };
        let is_action = matches!(row.cell, Cell::Logical | Cell::Physical);
        let capacity = ty.is_some().then(|| if is_action { self.room(capacity) } else { capacity });
        let name = tokens(&self.cell_name(cell));
        let encoder = (row.cell == Cell::Physical && !of_c).then(|| {
            let ty = tokens(ty.as_deref().unwrap_or_default());
            quote!(.encoded_by(::lf::model::encoder!(#ty)))
        });
        let new = quote!(#name::new(#arguments) #encoder);
        Ok(Some((self.cell_type(cell, &ty.unwrap_or_default(), capacity), new)))
    }
}

impl Members {
    fn field(
        &mut self,
        splices: &mut Splices<'_>,
        (text, at): (String, Location),
        name: &Ident,
        ty: &str,
        value: &TokenStream,
    ) {
        let (doc, ty) = (splices.doc(&text, at), tokens(ty));
        self.fields.extend(quote! { #doc #name: #ty, });
        self.values.extend(quote! { #name: #value, });
    }
}
