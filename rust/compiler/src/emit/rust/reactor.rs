// SPDX-License-Identifier: Apache-2.0
//! One module per reactor class: its preambles, its state as a struct, and its reactions as methods.

use std::collections::BTreeSet;

use lf_model::time::Interval;
use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::layout::Layout;
use super::scope::ModuleNames;
use crate::emit::host::{GivenValue, ReactionPart, SentPort, Splices, ident, interval, serializer_type};
use crate::emit::view::View;
use crate::emit::{EmitError, File, FileMap};
use crate::languages::rust::{DURATION, is_copy};
use crate::plan::{
    Child, ClassIndex, Handover, Location, Method, Plan, Reaction, ReactorClass, SourceCode, StateVariable, Type,
    Value, VariableKind,
};

/// Emits the module of a class.
pub(super) fn emit(
    view: &View<'_>,
    layout: &Layout<'_>,
    class: ClassIndex,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let (is_whole, splices, scope) =
        (layout.has(class), Splices::new(view.plan), ModuleNames::new(view, layout, class));
    let class_of = view.class(class);
    let mut module =
        ReactorModule { view, plan: view.plan, layout, index: class, class: class_of, is_whole, scope, splices };
    let tokens = module.tokens()?;
    module.splices.finish(path, tokens)
}

/// Returns the method that runs a part of a reaction.
pub(super) fn reaction_method(reaction: usize, part: ReactionPart) -> Ident {
    format_ident!("reaction_{reaction}{}", part.suffix())
}

/// Returns the name of the method that resets the state in a mode, or the state outside of modes.
pub(super) fn reset_method(mode: Option<usize>) -> Ident {
    match mode {
        Some(mode) => format_ident!("reset_state_of_mode_{mode}"),
        None => format_ident!("reset_state"),
    }
}

/// Returns the methods that write the value of a state for the next instance of the federate, and that set it.
pub(super) fn handover_methods(state: &str) -> [Ident; 2] {
    let name = ident(state);
    [format_ident!("hand_over_{name}"), format_ident!("take_over_{name}")]
}

/// Returns the name of the constant with the maximum number of bytes of a state that is handed over.
pub(super) fn bytes_constant(state: &str) -> Ident {
    format_ident!("BYTES_OF_{}", ident(state))
}

/// Returns the name of the method that constructs a contained instance.
pub(super) fn child_method(child: &Child) -> Ident {
    format_ident!("new_{}", ident(&child.name))
}

/// Returns the name of the type of a port or an action, if the type needs the scope of its reactor.
pub(super) fn type_alias(name: &str) -> Ident {
    format_ident!("TypeOf_{}", ident(name))
}

/// Returns the type of a port or an action, from anywhere in the crate.
pub(super) fn type_path(
    plan: &Plan,
    layout: &Layout<'_>,
    class: ClassIndex,
    name: &str,
    ty: &Type,
) -> Result<String, EmitError> {
    if is_copy(&ty.text) {
        return parsed_type(plan, ty).map(|_| ty.text.clone());
    }
    Ok(format!("{}::{}", layout.module_path(class), type_alias(name)))
}

/// Returns a type, if it is Rust.
pub(super) fn parsed_type(plan: &Plan, ty: &Type) -> Result<syn::Type, EmitError> {
    syn::parse_str(&ty.text)
        .map_err(|error| EmitError::new(plan, ty.at, format!("`{}` is not a Rust type: {error}", ty.text)))
}

/// Returns a duration as an expression.
fn duration(ns: i64) -> TokenStream {
    // LF's times are not negative; the front end has reported others.
    let text = interval(Interval::from_nanos(ns.max(0)));
    let text = match text.strip_prefix("Interval::") {
        Some("FOREVER") => format!("{DURATION}::from_nanos({})", i64::MAX),
        Some(rest) => format!("{DURATION}::{rest}"),
        None => text,
    };
    format!("::{text}").parse().unwrap_or_default()
}

struct ReactorModule<'p> {
    view: &'p View<'p>,
    plan: &'p Plan,
    layout: &'p Layout<'p>,
    index: ClassIndex,
    class: &'p ReactorClass,
    /// Whether it is emitted with its reactions and its state, and not only with its types.
    is_whole: bool,
    scope: ModuleNames,
    splices: Splices<'p>,
}

impl<'p> ReactorModule<'p> {
    fn tokens(&mut self) -> Result<TokenStream, EmitError> {
        let class = self.class;
        let name = ident(&self.layout.name(self.index));
        let about = format!(" Reactor `{}`.", class.name);
        let mut preambles = Vec::new();
        for preamble in &class.preambles {
            preambles.push(self.splices.items(preamble)?);
        }
        let comment = class.docs.iter().flat_map(|docs| docs.lines().chain([""])).map(|line| match line {
            "" => String::new(),
            text => format!(" {text}"),
        });
        let (types, scope) = (self.types()?, self.scope()?);
        if !self.is_whole {
            return Ok(quote! {
                #![doc = #about]
                use super::*;
                #scope
                #(#preambles)*
                #types
            });
        }
        let state_doc = self.splices.doc(&format!("An instance of `{}`", class.name), class.at);
        let (fields, movable) = (self.fields()?, self.movable());
        let new = self.new_method()?;
        let mut methods = Vec::new();
        for (index, child) in class.children.iter().enumerate() {
            if self.layout.makes(self.index, index) {
                methods.push(self.child_method(child)?);
            }
        }
        for method in &class.methods {
            methods.push(self.own_method(method)?);
        }
        for reaction in &class.reactions {
            if self.layout.reacts(self.index, reaction.number) {
                methods.push(self.reaction(reaction)?);
            }
        }
        let modes: BTreeSet<_> = class.state.iter().filter(|state| state.resets).map(|state| state.mode).collect();
        for mode in modes {
            methods.push(self.reset(mode)?);
        }
        for state in &class.state {
            if let Some(handover) = &state.handed_over {
                methods.push(self.handover(state, handover)?);
            }
        }
        Ok(quote! {
            #![doc = #about]
            use super::*;
            #scope
            #(#preambles)*
            #types
            #movable
            #(#[doc = #comment])*
            #state_doc
            pub struct #name { #fields }
            impl #name {
                #new
                #(#methods)*
            }
        })
    }

    /// Emits the types that stand for type parameters, and the imports for their names and those of inherited code.
    fn scope(&mut self) -> Result<TokenStream, EmitError> {
        let mut scope = self.scope.imports().clone();
        for (name, ty) in &self.class.types {
            let doc = self.splices.doc(&format!("Type parameter `{name}`"), ty.at);
            let (name, ty) = (ident(name), self.type_tokens(ty)?);
            scope.extend(quote! { #doc #[allow(dead_code)] type #name = #ty; });
        }
        Ok(scope)
    }

    /// Returns a type as tokens.
    fn type_tokens(&self, ty: &Type) -> Result<TokenStream, EmitError> {
        parsed_type(self.plan, ty).map(|parsed| self.scope.qualified(ty, &parsed))
    }

    /// Emits names for the types of ports and actions that only this module can spell.
    fn types(&mut self) -> Result<TokenStream, EmitError> {
        let ports = self.class.ports.iter().map(|port| (&port.name, &port.ty, port.at));
        let actions = self.class.actions.iter().map(|action| (&action.name, &action.ty, action.at));
        let mut types = TokenStream::new();
        for (name, ty, at) in ports.chain(actions).filter(|(_, ty, _)| !is_copy(&ty.text)) {
            let doc = self.splices.doc(&format!("The type of `{name}`"), at);
            let (alias, ty) = (type_alias(name), self.type_tokens(ty)?);
            types.extend(quote! { #doc pub type #alias = #ty; });
        }
        for port in self.class.ports.iter().filter(|port| !is_copy(&port.ty.text)) {
            if self.layout.workers() > 1 {
                types.extend(self.asserted(&quote!(seen_by_threads), &port.ty, None));
            }
            if let Some(SentPort { ty: source, serializer, .. }) = self.layout.sent_of(self.index, &port.name) {
                // rustc reports a type that cannot be sent at this place: at the source of the connection, so that both
                // ends report the same.
                let at = if port.ty.text == source.text { source.at } else { port.ty.at };
                let sent = Type { at, ..port.ty.clone() };
                let by = serializer.map(|by| serializer_type(by, &type_alias(&port.name).to_string()));
                let by = by.map(|by| by.parse().unwrap_or_default());
                let check = if by.is_some() { quote!(sendable_by) } else { quote!(sendable) };
                types.extend(self.asserted(&check, &sent, by.as_ref()));
            }
            if self.layout.is_copied(self.index, &port.name) {
                types.extend(self.asserted(&quote!(copied_by_connection), &port.ty, None));
            }
        }
        types.extend(self.lengths()?);
        Ok(types)
    }

    /// Emits the lengths of states that are handed over, and lets rustc check that they can be.
    fn lengths(&mut self) -> Result<TokenStream, EmitError> {
        let mut lengths = TokenStream::new();
        for state in &self.class.state {
            let Some(handover) = &state.handed_over else { continue };
            let (name, ty, by) =
                (bytes_constant(&state.name), self.type_tokens(&state.ty)?, self.handed_by(state, handover)?);
            lengths.extend(self.asserted(&quote!(sendable_by), &state.ty, Some(&by)));
            let doc = self.splices.doc(&format!("The maximum number of bytes of `{}`", state.name), state.at);
            lengths.extend(quote! { #doc pub const #name: usize = <#by as ::lf::model::Serializer<#ty>>::MAX_LEN; });
        }
        Ok(lengths)
    }

    /// Returns the type of the serializer by which a state is handed over.
    fn handed_by(&self, state: &StateVariable, handover: &Handover) -> Result<TokenStream, EmitError> {
        let Some(serializer) = &handover.serializer else { return Ok(quote!(::lf::model::Native)) };
        let ty = self.type_tokens(&state.ty)?.to_string();
        Ok(serializer_type(serializer, &ty).parse().unwrap_or_default())
    }

    /// Emits the methods that hand over a state and take it over.
    fn handover(&mut self, state: &StateVariable, handover: &Handover) -> Result<TokenStream, EmitError> {
        let (field, [write, set]) = (ident(&state.name), handover_methods(&state.name));
        let (ty, by) = (self.type_tokens(&state.ty)?, self.handed_by(state, handover)?);
        let doc = self.splices.doc(&format!("Writes `{}` for the next instance", state.name), state.at);
        Ok(quote! {
            #doc
            pub fn #write(&self, bytes: &mut [u8]) -> ::core::result::Result<usize, ::lf::model::PayloadError> {
                <#by as ::lf::model::Serializer<#ty>>::encode(&self.#field, bytes)
            }
            pub fn #set(&mut self, bytes: &[u8]) -> ::core::result::Result<(), ::lf::model::PayloadError> {
                self.#field = <#by as ::lf::model::Serializer<#ty>>::decode(bytes)?;
                ::core::result::Result::Ok(())
            }
        })
    }

    /// Emits a constant that lets rustc check a type, at its place in the program.
    fn asserted(&mut self, check: &TokenStream, ty: &Type, more: Option<&TokenStream>) -> TokenStream {
        let (uses, more) = (self.scope.uses(ty.at, &[]), more.into_iter());
        let ty = self.splices.ty(ty);
        let checked = quote!(::lf::model::#check::<#ty #(, #more)*>());
        if uses.is_some() { quote!(const _: () = { #uses #checked };) } else { quote!(const _: () = #checked;) }
    }

    fn fields(&mut self) -> Result<TokenStream, EmitError> {
        let class = self.class;
        let parameters = class.parameters.iter().map(|parameter| {
            ("Parameter", &parameter.name, self.parameter_field(&parameter.name), &parameter.ty, parameter.at)
        });
        let state = class.state.iter().map(|state| ("State", &state.name, ident(&state.name), &state.ty, state.at));
        let all: Vec<_> = parameters.chain(state).collect();
        let mut fields = TokenStream::new();
        for (kind, name, field, ty, at) in all {
            let doc = self.splices.doc(&format!("{kind} `{name}`"), at);
            let ty = self.type_tokens(ty)?;
            fields.extend(quote! { #doc #field: #ty, });
        }
        Ok(fields)
    }

    /// Emits a check for programs in which several threads run reactions: rustc reports the part of the state that is
    /// not `Send`.
    fn movable(&mut self) -> TokenStream {
        let class = self.class;
        let types = class.state.iter().map(|state| &state.ty).chain(class.parameters.iter().map(|given| &given.ty));
        let types: Vec<_> = types.filter(|ty| self.layout.workers() > 1 && !is_copy(&ty.text)).collect();
        types.into_iter().map(|ty| self.asserted(&quote!(moves_between_threads), ty, None)).collect()
    }

    /// Returns the field of a parameter. State of the same name hides it from bodies, as in LF's Rust target.
    fn parameter_field(&self, name: &str) -> Ident {
        if self.class.has_state(name) { format_ident!("parameter_{}", ident(name)) } else { ident(name) }
    }

    fn new_method(&mut self) -> Result<TokenStream, EmitError> {
        let class = self.class;
        let doc = self.splices.doc("A new instance; `None` stands for a parameter's default", class.at);
        let (mut arguments, mut steps, mut fields) = (TokenStream::new(), TokenStream::new(), TokenStream::new());
        for parameter in &class.parameters {
            let (name, ty) = (ident(&parameter.name), self.type_tokens(&parameter.ty)?);
            if let Some(default) = &parameter.default {
                let default = self.value(default)?;
                arguments.extend(quote! { #name: ::core::option::Option<#ty>, });
                steps.extend(quote! { let #name: #ty = #name.unwrap_or_else(|| #default); });
            } else {
                arguments.extend(quote! { #name: #ty, });
            }
            let field = self.parameter_field(&parameter.name);
            fields.extend(if field == name {
                quote! { #name, }
            } else {
                quote! { #field: #name, }
            });
        }
        for state in &class.state {
            let (name, ty) = (ident(&state.name), self.type_tokens(&state.ty)?);
            let init = state.init.as_ref().map(|init| self.initial_value(init)).transpose()?;
            let value = init.unwrap_or_else(|| quote!(::core::default::Default::default()));
            // Initial values name parameters, so a separate variable keeps the parameter of the same name visible.
            let hides = class.parameters.iter().any(|parameter| parameter.name == state.name);
            let variable = if hides { format_ident!("state_{}", name) } else { name.clone() };
            steps.extend(quote! { let #variable: #ty = #value; });
            fields.extend(if hides {
                quote! { #name: #variable, }
            } else {
                quote! { #name, }
            });
        }
        Ok(quote! {
            #doc
            pub fn new(#arguments) -> Self {
                #steps
                Self { #fields }
            }
        })
    }

    /// Returns an initial value; it uses copies of the parameters that it names, because they remain fields.
    fn initial_value(&mut self, init: &'p Value) -> Result<TokenStream, EmitError> {
        let value = self.value(init)?;
        let named: Vec<Ident> = self
            .class
            .parameters
            .iter()
            .filter(|parameter| self.view.mentions(init, &parameter.name) && !is_copy(&parameter.ty.text))
            .map(|parameter| ident(&parameter.name))
            .collect();
        if named.is_empty() {
            return Ok(value);
        }
        Ok(quote! {{ #(let #named = #named.clone();)* #value }})
    }

    /// Emits the method that resets the state in a mode, or the state outside of modes.
    fn reset(&mut self, mode: Option<usize>) -> Result<TokenStream, EmitError> {
        let class = self.class;
        let (name, doc) = (reset_method(mode), self.splices.doc("Resets the state", class.at));
        let states: Vec<_> = class.state.iter().filter(|state| state.resets && state.mode == mode).collect();
        let inits = || states.iter().filter_map(|state| state.init.as_ref());
        let named =
            class.parameters.iter().filter(|parameter| inits().any(|init| self.view.mentions(init, &parameter.name)));
        let copies: Vec<_> = named.map(|parameter| self.parameter_copy(&parameter.name, &parameter.ty)).collect();
        let mut steps = TokenStream::new();
        for state in &states {
            let Some(init) = &state.init else { continue };
            let (name, value) = (ident(&state.name), self.initial_value(init)?);
            steps.extend(quote! { self.#name = #value; });
        }
        Ok(quote! {
            #doc
            pub fn #name(&mut self) {
                #(#copies)*
                #steps
            }
        })
    }

    /// Returns a variable with the value of a parameter.
    fn parameter_copy(&self, name: &str, ty: &Type) -> TokenStream {
        let (name, field) = (ident(name), self.parameter_field(name));
        if is_copy(&ty.text) { quote!(let #name = self.#field;) } else { quote!(let #name = self.#field.clone();) }
    }

    fn child_method(&mut self, child: &'p Child) -> Result<TokenStream, EmitError> {
        let (view, class) = (self.view, self.class);
        let target = view.class(child.class);
        let doc = self.splices.doc(&format!("`{} = new {}(…)`", child.name, target.name), child.at);
        let method = child_method(child);
        let path: TokenStream = self.layout.class_path(self.index, child.class).parse().unwrap_or_default();
        let mut values = Vec::new();
        for (parameter, given) in view.given(child)? {
            let value = match given {
                GivenValue::Value(value) => self.value(value)?,
                GivenValue::Member if parameter.ty.text == "usize" => quote!(member),
                GivenValue::Member => quote!(member as _),
                GivenValue::Default => {
                    values.push(quote!(::core::option::Option::None));
                    continue;
                }
            };
            let is_optional = parameter.default.is_some();
            values.push(if is_optional { quote!(::core::option::Option::Some(#value)) } else { value });
        }
        let in_scope = class.parameters.iter().filter(|parameter| {
            child.arguments.iter().flatten().any(|argument| view.mentions(argument, &parameter.name))
        });
        let copies = in_scope.map(|parameter| self.parameter_copy(&parameter.name, &parameter.ty));
        // In the arguments of a member, `bank_index` is its number, unless the container has such a parameter.
        let member = child.is_bank.then(|| quote!(member: usize));
        let bank_index = view.counts_members(class, child).then(|| quote!(let bank_index = member;));
        Ok(quote! {
            #doc
            pub fn #method(&self, #member) -> #path {
                #bank_index
                #(#copies)*
                #path::new(#(#values),*)
            }
        })
    }

    fn own_method(&mut self, method: &'p Method) -> Result<TokenStream, EmitError> {
        let doc = self.splices.doc(&format!("Method `{}`", method.name), method.at);
        let name = ident(&method.name);
        let this = if method.constant { quote!(&self) } else { quote!(&mut self) };
        let (mut arguments, returned) = (
            Vec::new(),
            match &method.ty {
                Some(ty) => {
                    let ty = self.type_tokens(ty)?;
                    Some(quote!(-> #ty))
                }
                None => None,
            },
        );
        for (name, ty) in &method.arguments {
            let (name, ty) = (ident(name), self.type_tokens(ty)?);
            arguments.push(quote!(#name: #ty));
        }
        let variables: Vec<Ident> = method.arguments.iter().map(|(name, _)| ident(name)).collect();
        let uses = self.scope.uses(method.body.at, &variables);
        let body = self.splices.lines(&method.body)?;
        Ok(quote! {
            #doc
            pub fn #name(#this, #(#arguments),*) #returned {
                #uses
                #body
            }
        })
    }

    fn reaction(&mut self, reaction: &'p Reaction) -> Result<TokenStream, EmitError> {
        let named = reaction.name.as_ref().map(|name| format!("`{name}`: ")).unwrap_or_default();
        let signature = format!("{named}`{}`", reaction.signature);
        let mut methods = TokenStream::new();
        for part in ReactionPart::ALL {
            let Some(code) = part.code(reaction) else { continue };
            let (doc, at) = match part {
                ReactionPart::Body => (signature.clone(), reaction.at),
                ReactionPart::MissedDeadline => {
                    (format!("Runs instead of {signature} when its deadline is missed"), code.at)
                }
                ReactionPart::Tardy => (format!("Runs instead of {signature} when an input is tardy"), code.at),
            };
            methods.extend(self.method(&reaction_method(reaction.number, part), &doc, reaction, code, at)?);
        }
        Ok(methods)
    }

    fn method(
        &mut self,
        name: &Ident,
        doc: &str,
        reaction: &'p Reaction,
        body: &'p SourceCode,
        at: Location,
    ) -> Result<TokenStream, EmitError> {
        let doc = self.splices.doc(doc, at);
        let (mut variables, mut types) = (Vec::new(), Vec::new());
        for parameter in &reaction.parameters {
            variables.push(ident(&parameter.name));
            types.push(self.variable_type(&parameter.kind, parameter.effect)?);
        }
        let uses = self.scope.uses(body.at, &variables);
        let body = self.splices.lines(body)?;
        // Not every body uses all its arguments; rustc still warns of unused declarations of the body itself.
        Ok(quote! {
            #doc
            pub fn #name(&mut self, ctx: &mut ::lf::model::ReactionContext<'_>, #(#variables: #types),*) {
                #uses
                let _ = (&self, &ctx, #(&#variables),*);
                #body
            }
        })
    }

    fn variable_type(&self, kind: &VariableKind, effect: bool) -> Result<TokenStream, EmitError> {
        let mutable = effect.then(|| quote!(mut));
        Ok(match kind {
            VariableKind::Port { ty } => {
                let ty = self.type_tokens(ty)?;
                quote!(& #mutable ::lf::model::Port<#ty>)
            }
            VariableKind::Multiport { ty } => {
                let ty = self.type_tokens(ty)?;
                if effect {
                    quote!(&mut ::lf::model::MultiportMut<'_, '_, #ty>)
                } else {
                    quote!(&::lf::model::Multiport<'_, #ty>)
                }
            }
            VariableKind::LogicalAction { ty } => {
                let ty = self.type_tokens(ty)?;
                quote!(& #mutable ::lf::model::LogicalAction<#ty>)
            }
            VariableKind::PhysicalAction { ty } => {
                let ty = self.type_tokens(ty)?;
                quote!(& #mutable ::lf::model::PhysicalAction<#ty>)
            }
            VariableKind::Timer => quote!(&::lf::model::Timer),
            VariableKind::Watchdog => quote!(& #mutable ::lf::model::Watchdog),
            VariableKind::Mode { .. } => quote!(::lf::model::Transition),
        })
    }

    fn value(&mut self, value: &'p Value) -> Result<TokenStream, EmitError> {
        match value {
            Value::Time { ns } => Ok(duration(*ns)),
            Value::Code(code) => {
                let parameters: Vec<Ident> =
                    self.class.parameters.iter().map(|parameter| ident(&parameter.name)).collect();
                let uses = self.scope.uses(code.at, &parameters);
                let value = self.splices.inline(code)?;
                Ok(if uses.is_some() { quote!({ #uses #value }) } else { value })
            }
        }
    }
}
