// SPDX-License-Identifier: Apache-2.0
//! The implementation of `Program`: from numbers to fields and methods.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::{Module, type_name};
use crate::emit::reactor::{deadline_method, reaction_method, tardy_method};
use crate::plan::{
    Argument, InputIndex, OutputIndex, Reaction, ReactionIndex, ReactionKind, ScheduledReaction, Tardy, TriggerKind,
    VariableKind,
};

impl Module<'_> {
    /// `impl Program for …`.
    pub(super) fn program(&self) -> TokenStream {
        let name = type_name(self.plan, self.federate);
        let react = self.reactions(|number, _| Some(reaction_method(number)));
        let miss_deadline =
            self.reactions(|number, declared| declared.deadline.as_ref().map(|_| deadline_method(number)));
        let tardy = self.tardy();
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
                #tardy
            }
        }
    }

    /// What only programs have whose inputs can be tardy; for others the trait has defaults.
    fn tardy(&self) -> TokenStream {
        let inputs = self.federate.inputs.iter().enumerate().filter(|(_, input)| self.can_be_tardy(input));
        let delivers: TokenStream = inputs
            .map(|(index, input)| {
                let (id, field) = (self.symbols.input_id(InputIndex(index)), self.symbols.trigger(input.trigger));
                quote! { #id => self.#field.deliver_tardy(tag, intended, bytes), }
            })
            .collect();
        if delivers.is_empty() {
            return TokenStream::new();
        }
        let handles = self.reactions(|number, declared| {
            declared.tardy.as_ref().map(|tardy| match tardy {
                Tardy::Handler(_) => tardy_method(number),
                Tardy::Body => reaction_method(number),
            })
        });
        quote! {
            fn handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
                match reaction {
                    #handles
                    _ => {}
                }
            }
            fn deliver_tardy(
                &mut self,
                input: InputId,
                tag: Tag,
                intended: Tag,
                bytes: &[u8],
            ) -> Result<Placed, Undelivered> {
                match input {
                    #delivers
                    _ => Err(Undelivered::NoSuchPort),
                }
            }
        }
    }

    /// One arm per reaction with a body for which there is a method.
    fn reactions(&self, method: impl Fn(usize, &Reaction) -> Option<Ident>) -> TokenStream {
        let arm = |(index, reaction): (usize, &ScheduledReaction)| {
            let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
            let instance_plan = &self.federate.instances[instance.0];
            let declared = &self.plan.class(instance_plan).reactions[number - 1];
            let method = method(*number, declared)?;
            let id = self.symbols.reaction_id(ReactionIndex(index));
            let field = self.symbols.instance(instance.0);
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
