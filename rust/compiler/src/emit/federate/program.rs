// SPDX-License-Identifier: Apache-2.0
//! The implementation of `Program`: from numbers to fields and methods.

use proc_macro2::TokenStream;
use quote::quote;

use super::{Module, type_name};
use crate::emit::reactor::{deadline_method, reaction_method};
use crate::plan::{
    Argument, InputIndex, OutputIndex, ReactionIndex, ReactionKind, ScheduledReaction, TriggerKind, VariableKind,
};

impl Module<'_> {
    /// `impl Program for …`.
    pub(super) fn program(&self) -> TokenStream {
        let name = type_name(self.plan, self.federate);
        let react = self.reactions(false);
        let miss_deadline = self.reactions(true);
        let (ports, triggers) = (self.port_arms(), self.trigger_arms());
        let (captures, encodes, delivers) = (self.capture_arms(), self.encode_arms(), self.deliver_arms());
        quote! {
            #[allow(unused_variables)]
            impl Program for #name {
                fn tables(&self) -> &'static Tables {
                    &TABLES
                }
                fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
                    match reaction {
                        #react
                        _ => {}
                    }
                }
                fn miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
                    match reaction {
                        #miss_deadline
                        _ => {}
                    }
                }
                fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
                    match port {
                        #ports
                        _ => None,
                    }
                }
                fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
                    match trigger {
                        #triggers
                        _ => None,
                    }
                }
                fn capture(&mut self, trigger: TriggerId, tag: Tag) -> Result<(), Full> {
                    match trigger {
                        #captures
                        _ => Ok(()),
                    }
                }
                fn encode(&self, output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
                    match output {
                        #encodes
                        _ => Err(PayloadError::Absent),
                    }
                }
                fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
                    match input {
                        #delivers
                        _ => Err(Undelivered::NoSuchPort),
                    }
                }
            }
        }
    }

    /// One arm per reaction with a body, or per reaction with a deadline.
    fn reactions(&self, late: bool) -> TokenStream {
        let arm = |(index, reaction): (usize, &ScheduledReaction)| {
            let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
            let instance_plan = &self.federate.instances[instance.0];
            let declared = &self.plan.class(instance_plan).reactions[number - 1];
            if late && declared.deadline.is_none() {
                return None;
            }
            let id = self.symbols.reaction_id(ReactionIndex(index));
            let field = self.symbols.instance(instance.0);
            let method = if late { deadline_method(*number) } else { reaction_method(*number) };
            let arguments = declared.parameters.iter().zip(arguments).map(|(parameter, argument)| {
                let mutable = (parameter.effect && parameter.kind != VariableKind::Timer).then(|| quote!(mut));
                let place = match argument {
                    Argument::Port(port) => self.port_place(*port),
                    Argument::Trigger(trigger) => {
                        let field = self.symbols.trigger(*trigger);
                        quote!(self.#field)
                    }
                };
                quote!(& #mutable #place)
            });
            Some(quote! { #id => self.#field.#method(ctx, #(#arguments),*), })
        };
        self.federate.reactions.iter().enumerate().filter_map(arm).collect()
    }

    fn port_arms(&self) -> TokenStream {
        let arm = |(index, _)| {
            let (id, place) = (self.symbols.port_id(index), self.port_place(index));
            quote! { #id => Some(&mut #place), }
        };
        self.ports().map(arm).collect()
    }

    fn trigger_arms(&self) -> TokenStream {
        let arm = |(index, trigger): (_, &crate::plan::Trigger)| {
            let (id, field) = (self.symbols.trigger_id(index), self.symbols.trigger(index));
            let has_cell = !matches!(trigger.kind, TriggerKind::Startup | TriggerKind::Shutdown);
            has_cell.then(|| quote! { #id => Some(&mut self.#field), })
        };
        self.triggers().filter_map(arm).collect()
    }

    fn capture_arms(&self) -> TokenStream {
        let arm = |(index, trigger): (_, &crate::plan::Trigger)| match trigger.kind {
            // A port that would feed itself has no other source, and so never a value.
            TriggerKind::Delay { source, fills, .. } if source != fills => {
                let (id, field) = (self.symbols.trigger_id(index), self.symbols.trigger(index));
                let source = self.port_place(source);
                Some(quote! { #id => self.#field.capture(tag, &#source), })
            }
            _ => None,
        };
        self.triggers().filter_map(arm).collect()
    }

    fn encode_arms(&self) -> TokenStream {
        let arm = |(index, output): (usize, &crate::plan::NetworkOutput)| {
            let (id, place) = (self.symbols.output_id(OutputIndex(index)), self.port_place(output.source));
            quote! { #id => #place.encode(bytes), }
        };
        self.federate.outputs.iter().enumerate().map(arm).collect()
    }

    fn deliver_arms(&self) -> TokenStream {
        let arm = |(index, input): (usize, &crate::plan::NetworkInput)| {
            let (id, field) = (self.symbols.input_id(InputIndex(index)), self.symbols.trigger(input.trigger));
            quote! { #id => self.#field.deliver(tag, bytes), }
        };
        self.federate.inputs.iter().enumerate().map(arm).collect()
    }
}
