// SPDX-License-Identifier: Apache-2.0
//! The instances in the struct that owns everything.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::bodies::RustBodies;
use super::reactor::child_method;
use crate::emit::EmitError;
use crate::emit::host::{Member, Members, Owner, Splices, tokens};

impl RustBodies<'_> {
    /// Adds the construction of the instances, containers first, and fields for those with reactions.
    pub(super) fn add_instances(
        &self,
        owner: &Owner<'_>,
        members: &mut Members,
        splices: &mut Splices<'_>,
    ) -> Result<(), EmitError> {
        let (plan, federate, symbols) = (owner.plan, owner.federate, &owner.symbols);
        let main = &symbols.main;
        if plan.is_federated() {
            let value = self.new_main()?;
            members.locals.extend(quote! { let #main = #value; });
        }
        let mut kept = Vec::new();
        for (index, instance) in federate.instances.iter().enumerate() {
            let local = &symbols.locals[index];
            let value = match plan.child(federate, instance) {
                None => self.new_main()?,
                Some(child) => {
                    let container = instance.parent.map_or(main, |parent| &symbols.locals[parent.0]);
                    let method = child_method(child);
                    let member = instance.bank_index.map(Literal::usize_unsuffixed);
                    quote!(#container.#method(#member))
                }
            };
            let is_kept = !plan.class(instance).reactions.is_empty();
            let is_container = federate.instances.iter().any(|other| other.parent.is_some_and(|at| at.0 == index));
            members.locals.extend(if is_kept || is_container {
                quote! { let #local = #value; }
            } else {
                // The initial values are still evaluated; a variable would be unused.
                quote! { let _ = #value; }
            });
            let (path, at) = (&instance.path, instance.at);
            let member =
                || Member { word: "Instance ", path, at, ty: self.class(instance.class), value: quote!(#local) };
            kept.push(is_kept.then(member));
        }
        members.add(splices, (&symbols.instances, &symbols.arrays.instances), &kept);
        Ok(())
    }

    /// Returns the construction of the main reactor, all of whose parameters have their defaults.
    fn new_main(&self) -> Result<TokenStream, EmitError> {
        let (view, plan) = (self.job.view, self.job.plan());
        let class = view.class(plan.main);
        if let Some(parameter) = class.parameters.iter().find(|parameter| parameter.default.is_none()) {
            let message = format!("`{}` of the main reactor needs a default value", parameter.name);
            return Err(EmitError::new(plan, parameter.at, message));
        }
        let path = tokens(&self.class(plan.main));
        let arguments = class.parameters.iter().map(|_| quote!(None));
        Ok(quote!(#path::new(#(#arguments),*)))
    }
}
