// SPDX-License-Identifier: Apache-2.0
//! The module of a federate as a whole: the struct that owns everything, the tables that describe it, and the
//! `Program` that the engine drives.

mod program;
mod symbols;
mod tables;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::crate_layout::Layout;
use super::deployment::{Deployment, RtiHome};
use super::names::pascal_case;
use super::reactor::{child_method, type_path, type_tokens};
use super::source_map::FileMap;
use super::splice::Splices;
use super::{EmitError, File};
use crate::plan::{
    ClassIndex, Federate, NetworkInput, Plan, Port, PortIndex, Rti, Trigger, TriggerIndex, TriggerKind, Type,
};
use symbols::Symbols;
pub(super) use tables::{clock_sync_trials, interval, log_level, optional_interval};

/// Emits the module of a federate.
pub(super) fn emit(
    plan: &Plan,
    federate: &Federate,
    layout: &Layout,
    deployment: &Deployment,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let (symbols, splices) = (Symbols::new(federate), Splices::new(plan));
    let rti = deployment.rti_of(plan);
    let rti_is_image = deployment.rti.home != RtiHome::Program;
    let mut module = Module { plan, federate, layout, rti, rti_is_image, symbols, splices };
    let tokens = module.tokens()?;
    module.splices.finish(path, tokens)
}

/// The name of the struct that owns everything.
pub(super) fn type_name(plan: &Plan, federate: &Federate) -> Ident {
    let kind = if plan.is_federated() { "Federate" } else { "Main" };
    format_ident!("{}{kind}", pascal_case(&federate.name))
}

struct Module<'p> {
    plan: &'p Plan,
    federate: &'p Federate,
    layout: &'p Layout,
    /// Where the RTI is, as deployed.
    rti: Option<Rti>,
    /// Whether the RTI's clock is that of an image, which no program of this computer has.
    rti_is_image: bool,
    symbols: Symbols,
    splices: Splices<'p>,
}

impl<'p> Module<'p> {
    fn tokens(&mut self) -> Result<TokenStream, EmitError> {
        let what = if self.plan.is_federated() { "Federate" } else { "Main reactor" };
        let about = format!(" {what} `{}` of {}.", self.federate.name, self.plan.name);
        let constants = self.constants();
        let tables = self.tables()?;
        let description = self.description()?;
        let inboxes = self.inboxes()?;
        let owner = self.owner()?;
        let program = self.program();
        Ok(quote! {
            #![doc = #about]
            use lf::model::*;
            #constants
            #tables
            #description
            #inboxes
            #owner
            #program
        })
    }

    /// Statics through which other threads reach the physical actions.
    fn inboxes(&mut self) -> Result<TokenStream, EmitError> {
        let mut statics = TokenStream::new();
        for (index, trigger) in self.triggers() {
            if let (TriggerKind::Action { physical: true, ty, .. }, Some(at)) = (&trigger.kind, trigger.at) {
                let doc = self.splices.doc(&format!("Events of `{}` from other threads", trigger.path), at);
                let (name, ty) = (self.symbols.inbox(index), self.type_of(&trigger.path, ty)?);
                let capacity = Literal::usize_unsuffixed(trigger.capacity);
                statics.extend(quote! {
                    #doc
                    static #name: PhysicalInbox<#ty, #capacity> = PhysicalInbox::new();
                });
            }
        }
        Ok(statics)
    }

    /// The struct that owns all state, ports and queues, and its constructor.
    fn owner(&mut self) -> Result<TokenStream, EmitError> {
        let name = type_name(self.plan, self.federate);
        let doc = self.splices.doc("All state, ports and queues", self.federate.at);
        let (mut fields, mut values, mut locals) = (TokenStream::new(), TokenStream::new(), TokenStream::new());
        self.instances(&mut fields, &mut values, &mut locals)?;
        for (index, port) in self.ports() {
            // A port with a queue lives in the field of the trigger that fills it.
            if self.symbols.filled_by(index).is_none() {
                let (doc, field) =
                    (self.splices.doc(&format!("Port `{}`", port.path), port.at), self.symbols.port(index));
                let (ty, id) = (self.port_type(index)?, self.symbols.port_id(index));
                fields.extend(quote! { #doc #field: Port<#ty>, });
                values.extend(quote! { #field: Port::new(#id), });
            }
        }
        for (index, trigger) in self.triggers() {
            let Some(at) = trigger.at else { continue };
            let Some((ty, value)) = self.trigger_field(index, trigger)? else { continue };
            let (doc, field) = (self.splices.doc(&format!("`{}`", trigger.path), at), self.symbols.trigger(index));
            fields.extend(quote! { #doc #field: #ty, });
            values.extend(quote! { #field: #value, });
        }
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
    fn instances(
        &mut self,
        fields: &mut TokenStream,
        values: &mut TokenStream,
        locals: &mut TokenStream,
    ) -> Result<(), EmitError> {
        let federate = self.federate;
        let main = self.symbols.main().clone();
        if self.plan.is_federated() {
            let value = self.new_main()?;
            locals.extend(quote! { let #main = #value; });
        }
        for (index, instance) in federate.instances.iter().enumerate() {
            let field = self.symbols.instance(index).clone();
            let value = match self.plan.child(federate, instance) {
                None => self.new_main()?,
                Some(child) => {
                    let container = instance.parent.map_or(&main, |parent| self.symbols.instance(parent.0));
                    let method = child_method(child);
                    quote!(#container.#method())
                }
            };
            let is_kept = !self.plan.class(instance).reactions.is_empty();
            let is_container = federate.instances.iter().any(|other| other.parent.is_some_and(|at| at.0 == index));
            locals.extend(if is_kept || is_container {
                quote! { let #field = #value; }
            } else {
                // Its initial values are still worked out; a variable would be one that nothing uses.
                quote! { let _ = #value; }
            });
            if is_kept {
                let doc = self.splices.doc(&format!("Instance `{}`", instance.path), instance.at);
                let path = self.layout.class_path(instance.class);
                fields.extend(quote! { #doc #field: #path, });
                values.extend(quote! { #field, });
            }
        }
        Ok(())
    }

    /// The main reactor, all of whose parameters have their defaults.
    fn new_main(&self) -> Result<TokenStream, EmitError> {
        let ClassIndex(main) = self.plan.main;
        let class = &self.plan.classes[main];
        if let Some(parameter) = class.parameters.iter().find(|parameter| parameter.default.is_none()) {
            let message = format!("`{}` of the main reactor needs a default value", parameter.name);
            return Err(EmitError::new(self.plan, parameter.at, message));
        }
        let path = self.layout.class_path(self.plan.main);
        let arguments = class.parameters.iter().map(|_| quote!(None));
        Ok(quote!(#path::new(#(#arguments),*)))
    }

    /// The type and the first value of a trigger's field; startup and shutdown have none.
    fn trigger_field(
        &self,
        index: TriggerIndex,
        trigger: &Trigger,
    ) -> Result<Option<(TokenStream, TokenStream)>, EmitError> {
        let capacity = Literal::usize_unsuffixed(trigger.capacity);
        let id = self.symbols.trigger_id(index);
        Ok(match &trigger.kind {
            TriggerKind::Startup | TriggerKind::Shutdown => None,
            TriggerKind::Timer { .. } => Some((quote!(Timer), quote!(Timer::new()))),
            TriggerKind::Action { physical: false, ty, .. } => {
                let ty = self.type_of(&trigger.path, ty)?;
                Some((quote!(LogicalActionQueue<#ty, #capacity>), quote!(LogicalActionQueue::new(#id))))
            }
            TriggerKind::Action { physical: true, ty, .. } => {
                let (ty, inbox) = (self.type_of(&trigger.path, ty)?, self.symbols.inbox(index));
                Some((quote!(PhysicalActionQueue<#ty, #capacity>), quote!(PhysicalActionQueue::new(#id, &#inbox))))
            }
            TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } => {
                let (ty, port) = (self.port_type(*fills)?, self.symbols.port_id(*fills));
                let can_be_tardy = match &trigger.kind {
                    TriggerKind::NetworkInput { input, .. } => self.can_be_tardy(&self.federate.inputs[input.0]),
                    _ => false,
                };
                let cell = if can_be_tardy { quote!(TardyInput) } else { quote!(QueuedPort) };
                Some((quote!(#cell<#ty, #capacity>), quote!(#cell::new(#port))))
            }
        })
    }

    /// Whether messages can come after their tag.
    fn can_be_tardy(&self, input: &NetworkInput) -> bool {
        self.plan.is_decentralized() && !input.physical
    }

    fn ports(&self) -> impl Iterator<Item = (PortIndex, &'p Port)> + use<'p> {
        self.federate.ports.iter().enumerate().map(|(index, port)| (PortIndex(index), port))
    }

    fn triggers(&self) -> impl Iterator<Item = (TriggerIndex, &'p Trigger)> + use<'p> {
        self.federate.triggers.iter().enumerate().map(|(index, trigger)| (TriggerIndex(index), trigger))
    }

    /// The type of the port, timer or action with this path, as it can be named here.
    ///
    /// What a preamble declares is known only to the module of the reactor, which has a name for the type.
    fn type_of(&self, path: &str, ty: &Type) -> Result<TokenStream, EmitError> {
        let declared = path.rsplit_once('.').and_then(|(owner, name)| {
            let instance = self.federate.instances.iter().find(|instance| instance.path == owner)?;
            Some((instance.class, name))
        });
        match declared {
            Some((class, name)) => type_path(self.plan, self.layout, class, name, ty),
            None => type_tokens(self.plan, ty),
        }
    }

    /// The same for a port.
    fn port_type(&self, index: PortIndex) -> Result<TokenStream, EmitError> {
        let port = &self.federate.ports[index.0];
        self.type_of(&port.path, &port.ty)
    }

    /// The place expression of a port.
    fn port_place(&self, port: PortIndex) -> TokenStream {
        if let Some(trigger) = self.symbols.filled_by(port) {
            let field = self.symbols.trigger(trigger);
            return quote!(self.#field.port);
        }
        let field = self.symbols.port(port);
        quote!(self.#field)
    }
}
