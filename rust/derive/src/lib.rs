// SPDX-License-Identifier: Apache-2.0
//! Macros that run at compile time: `#[derive(Payload)]`, by which a struct or an enum can be sent to another federate,
//! `say!`, by which sentences take half of their bytes, and `#[outlined]`, by which functions are called where that is
//! shorter.
//!
//! The bytes of a payload are those of the C type, which `lf_model::layout` computes; the macro only lists the fields.
//! The generated code names each field's type in one way only, so that rustc reports once that a type cannot be sent,
//! and reports it at the field.
#![forbid(unsafe_code)]

mod texts;

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned as _;
use syn::{Attribute, Data, DataEnum, DeriveInput, Error, Fields, GenericParam, Path, parse_macro_input, parse_quote};

/// Keeps a function out of line on processors of 32 bits, where flash is short.
///
/// LLVM inlines a function that is called once, and one that looks smaller than its call. Both make an image larger
/// where the copy needs registers that its surroundings need too, as numbers of 64 bits do, which take two each. Use it
/// only where images become smaller by it: what the present uses save is in `docs/internals/flash.md`. On a computer
/// the function is inlined as usual, which is faster.
#[proc_macro_attribute]
pub fn outlined(_: proc_macro::TokenStream, function: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let function = TokenStream::from(function);
    quote! {
        #[cfg_attr(target_pointer_width = "32", inline(never))]
        #function
    }
    .into()
}

/// Implements `FixedPayload`, and with it `Payload`, for a struct or an enum whose fields can be sent.
///
/// `#[repr(u8)]` and the like number an enum's variants in the bytes, as they do in memory. Generated programs call the
/// crate `::lf::model`; `#[payload(crate = path)]` names another one.
#[proc_macro_derive(Payload, attributes(payload))]
pub fn payload(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let mut input = parse_macro_input!(input as DeriveInput);
    let mut errors = Vec::new();
    let home = home(&input.attrs).unwrap_or_else(|error| {
        errors.push(error);
        parse_quote!(::lf::model)
    });
    bound(&mut input, &home, &mut errors);
    let parts = parts(&input, &home).unwrap_or_else(|error| {
        errors.push(error);
        Parts::none(&home)
    });
    let errors = errors.iter().map(Error::to_compile_error);
    let Parts { tags, layout, write, read } = parts;
    let name = &input.ident;
    let (parameters, arguments, conditions) = input.generics.split_for_impl();
    quote! {
        #(#errors)*
        const _: () = {
            #tags
            #[automatically_derived]
            #[allow(unused_mut, unused_variables, unreachable_code, unreachable_patterns)]
            #[allow(clippy::all, clippy::pedantic)]
            impl #parameters #home::FixedPayload for #name #arguments #conditions {
                const SIZE: usize = (#layout).size();
                const ALIGN: usize = (#layout).align();
                fn write(&self, bytes: &mut [u8]) {
                    bytes.fill(0);
                    let mut fields = #home::layout::Fields::new(bytes);
                    #write
                }
                fn read(bytes: &[u8]) -> ::core::result::Result<Self, #home::PayloadError> {
                    let mut fields = #home::layout::Fields::new(bytes);
                    #read
                }
            }
        };
    }
    .into()
}

/// Writes a sentence to a `core::fmt::Formatter`, like `write!`: `say!(f, "{tag} is too late by {} ns", by)`.
///
/// The sentence is packed at compile time, and consists of ASCII characters. The crate has to depend on `lf-texts`.
#[proc_macro]
pub fn say(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    texts::say(input.into()).unwrap_or_else(Error::into_compile_error).into()
}

/// Makes a packed text without values, which can be displayed: an `lf_texts::Text`.
#[proc_macro]
pub fn text(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    texts::text(input.into()).unwrap_or_else(Error::into_compile_error).into()
}

/// Makes the tables of the unpacker, for `lf-texts`.
#[doc(hidden)]
#[proc_macro]
pub fn pairs(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    texts::table(input.into()).unwrap_or_else(Error::into_compile_error).into()
}

/// The parts that differ from type to type.
struct Parts {
    /// The numbers of an enum's variants, as constants.
    tags: TokenStream,
    layout: TokenStream,
    write: TokenStream,
    read: TokenStream,
}

impl Parts {
    /// Returns the parts of a type with errors: it counts as one that can be sent.
    fn none(home: &Path) -> Self {
        let (layout, read) = (quote!(#home::layout::Layout::EMPTY), quote!(::core::unreachable!()));
        Self { tags: TokenStream::new(), layout, write: TokenStream::new(), read }
    }
}

fn parts(input: &DeriveInput, home: &Path) -> Result<Parts, Error> {
    let repr = repr(&input.attrs)?;
    match &input.data {
        Data::Struct(data) => {
            if let Some(repr) = repr {
                return Err(Error::new(repr.span(), "the layout of a struct is that of C: remove this"));
            }
            let Member { pattern, layout, write, read } = Member::of(&data.fields, home);
            let (write, read) =
                (quote!(let Self #pattern = self; #write), quote!(::core::result::Result::Ok(Self #read)));
            Ok(Parts { tags: TokenStream::new(), layout, write, read })
        }
        Data::Enum(data) if data.variants.is_empty() => {
            Err(Error::new(input.ident.span(), "an enum without variants has no values that could be sent"))
        }
        Data::Enum(data) => Ok(variants(data, &repr.unwrap_or_else(|| parse_quote!(i32)), home)),
        Data::Union(data) => {
            let message = "what a union holds is not known when it is sent: write an enum, whose bytes are a C struct \
                           of a number and a union";
            Err(Error::new(data.union_token.span, message))
        }
    }
}

/// Returns the parts of a number, and a union of structs: one for the fields of each variant.
fn variants(data: &DataEnum, number: &Ident, home: &Path) -> Parts {
    let (mut tags, tag_member) = (TokenStream::new(), quote!(#home::layout::member::<#number>()));
    let (mut union, mut write, mut read) =
        (quote!(#home::layout::Layout::EMPTY), TokenStream::new(), TokenStream::new());
    let members: Vec<_> = data.variants.iter().map(|variant| Member::of(&variant.fields, home)).collect();
    for Member { layout, .. } in &members {
        union = quote!(#union.or(#layout));
    }
    let mut last: Option<Ident> = None;
    for (index, (variant, member)) in data.variants.iter().zip(members).enumerate() {
        let tag = format_ident!("__LF_TAG_{index}");
        let value = match (&variant.discriminant, &last) {
            (Some((_, value)), _) => quote!((#value) as #number),
            (None, Some(last)) => quote!(#last + 1),
            (None, None) => quote!(0),
        };
        tags.extend(quote!(const #tag: #number = #value;));
        let (name, Member { pattern, write: put, read: take, .. }) = (&variant.ident, member);
        write.extend(quote! {
            Self::#name #pattern => {
                fields.put(#tag_member, &#tag);
                fields.align_to(#union);
                #put
            }
        });
        read.extend(quote! {
            #tag => {
                fields.align_to(#union);
                ::core::result::Result::Ok(Self::#name #take)
            }
        });
        last = Some(tag);
    }
    let layout = quote!(#home::layout::Layout::EMPTY.with(#tag_member.layout).with(#union));
    let write = quote!(match self { #write });
    let read = quote! {
        match fields.take(#tag_member)? {
            #read
            other => ::core::result::Result::Err(#home::PayloadError::NotVariant(other as i64)),
        }
    };
    Parts { tags, layout, write, read }
}

/// The fields of a struct or of a variant.
struct Member {
    /// The pattern that binds them to variables.
    pattern: TokenStream,
    layout: TokenStream,
    write: TokenStream,
    /// The expression for the value: its fields in braces.
    read: TokenStream,
}

impl Member {
    fn of(fields: &Fields, home: &Path) -> Self {
        let (mut pattern, mut layout) = (TokenStream::new(), quote!(#home::layout::Layout::EMPTY));
        let (mut write, mut read) = (TokenStream::new(), TokenStream::new());
        for (index, (field, name)) in fields.iter().zip(fields.members()).enumerate() {
            let (ty, variable) = (&field.ty, format_ident!("field_{index}"));
            let member = quote_spanned!(ty.span()=> #home::layout::member::<#ty>());
            pattern.extend(quote!(#name: #variable,));
            layout = quote!(#layout.with(#member.layout));
            write.extend(quote!(fields.put(#member, #variable);));
            read.extend(quote!(#name: fields.take(#member)?,));
        }
        Self { pattern: quote!({ #pattern }), layout, write, read: quote!({ #read }) }
    }
}

/// Requires of each type parameter that its values can be fields of a struct.
fn bound(input: &mut DeriveInput, home: &Path, errors: &mut Vec<Error>) {
    for parameter in &mut input.generics.params {
        match parameter {
            GenericParam::Type(ty) => ty.bounds.push(parse_quote!(#home::layout::Field)),
            GenericParam::Lifetime(lifetime) => {
                let message = "what borrows cannot be received: write fields that own their values, such as \
                               `heapless::String<N>`";
                errors.push(Error::new(lifetime.span(), message));
            }
            GenericParam::Const(_) => {}
        }
    }
}

/// Returns the path of the crate with the traits.
fn home(attributes: &[Attribute]) -> Result<Path, Error> {
    let mut home = parse_quote!(::lf::model);
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("payload")) {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident("crate") {
                return Err(meta.error("all that can be said here is `crate = path`"));
            }
            home = meta.value()?.parse()?;
            Ok(())
        })?;
    }
    Ok(home)
}

/// Returns the type in `#[repr(…)]` that numbers variants. `C` and `transparent` change nothing: the layout is C's
/// anyway.
fn repr(attributes: &[Attribute]) -> Result<Option<Ident>, Error> {
    const NUMBERS: [&str; 8] = ["u8", "u16", "u32", "u64", "i8", "i16", "i32", "i64"];
    let mut number = None;
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("repr")) {
        attribute.parse_nested_meta(|meta| {
            let word = meta.path.require_ident()?;
            if NUMBERS.iter().any(|known| word == known) {
                number = Some(Ident::new(&word.to_string(), Span::call_site()));
            } else if !(word == "C" || word == "transparent") {
                let instead = if word == "usize" || word == "isize" {
                    "it has another size on a board than on a computer: write `u32` or another fixed size"
                } else {
                    "the bytes are those of C's own layout: remove it"
                };
                return Err(meta.error(format!("`{word}` says nothing about bytes between federates; {instead}")));
            }
            Ok(())
        })?;
    }
    Ok(number)
}
