// SPDX-License-Identifier: Apache-2.0
//! `say!` and `text!`: sentences are packed while they are compiled.

mod pack;
mod pairs;
#[cfg(test)]
mod training;

use proc_macro2::{Ident, Literal, TokenStream, TokenTree};
use quote::{ToTokens as _, format_ident, quote};
use syn::{Error, LitStr};

use pack::{FIRST, VALUE, pack, pairs};

type Result<T> = core::result::Result<T, Error>;

/// What `text!("…")` is: a packed text without values.
pub(crate) fn text(input: TokenStream) -> Result<TokenStream> {
    let literal: LitStr = syn::parse2(input)?;
    packed(literal.value().as_bytes(), &literal)
}

/// What `say!(formatter, "…", values…)` is.
pub(crate) fn say(input: TokenStream) -> Result<TokenStream> {
    let whole = input.clone();
    let mut parts = split(input).into_iter();
    let (Some(formatter), Some(literal)) = (parts.next(), parts.next()) else {
        return Err(Error::new_spanned(whole, "a formatter and a sentence are needed"));
    };
    let literal: LitStr = syn::parse2(literal)?;
    let Sentence { bytes, values } = Sentence::read(&literal, &parts.collect::<Vec<_>>())?;
    let text = packed(&bytes, &literal)?;
    Ok(quote!(#text.write(#formatter, &[#(&#values),*])))
}

/// A table of what unpacks: one of its parts.
pub(crate) fn table(input: TokenStream) -> Result<TokenStream> {
    let part: Ident = syn::parse2(input)?;
    let pairs = pairs();
    let (first, second): (Vec<u8>, Vec<u8>) = pairs.iter().map(|[first, second]| (first, second)).unzip();
    match part.to_string().as_str() {
        "count" => Ok(pairs.len().into_token_stream()),
        "bytes" => Ok(quote!([#([#first, #second]),*])),
        "first" => Ok(FIRST.into_token_stream()),
        "value" => Ok(VALUE.into_token_stream()),
        _ => Err(Error::new_spanned(part, "there is no such part")),
    }
}

/// What is between the commas; the last may be followed by one.
fn split(input: TokenStream) -> Vec<TokenStream> {
    let mut parts = vec![TokenStream::new()];
    for token in input {
        match token {
            TokenTree::Punct(sign) if sign.as_char() == ',' => parts.push(TokenStream::new()),
            token => parts.last_mut().expect("there is one from the beginning").extend([token]),
        }
    }
    parts.pop_if(|part| part.is_empty());
    parts
}

/// A sentence as `write!` takes it, taken apart.
struct Sentence {
    /// Its characters, and [`VALUE`] where values stand.
    bytes: Vec<u8>,
    /// The values, in this order.
    values: Vec<TokenStream>,
}

impl Sentence {
    fn read(literal: &LitStr, given: &[TokenStream]) -> Result<Self> {
        let wrong = |what: &str| Error::new(literal.span(), what);
        let mut sentence = Self { bytes: Vec::new(), values: Vec::new() };
        let mut next = 0;
        let text = literal.value();
        let mut rest = text.as_str();
        while let Some(place) = rest.find(['{', '}']) {
            let (before, behind) = rest.split_at(place);
            sentence.bytes.extend(before.bytes());
            if let Some(double) = ["{{", "}}"].into_iter().find(|double| behind.starts_with(double)) {
                sentence.bytes.push(double.as_bytes()[0]);
                rest = &behind[2..];
                continue;
            }
            let inside = behind.strip_prefix('{').and_then(|behind| behind.split_once('}'));
            let (inside, behind) = inside.ok_or_else(|| wrong("a brace has no counterpart"))?;
            let (name, how) = inside.split_once(':').unwrap_or((inside, ""));
            let given = |index: usize| given.get(index).cloned().ok_or_else(|| wrong("a value is missing"));
            let value = if name.is_empty() {
                next += 1;
                given(next - 1)?
            } else if let Ok(index) = name.parse() {
                given(index)?
            } else {
                Ident::new(name, literal.span()).into_token_stream()
            };
            sentence.values.push(if how.is_empty() {
                quote!((#value))
            } else {
                let format = Literal::string(&format!("{{:{how}}}"));
                quote!(::core::format_args!(#format, #value))
            });
            sentence.bytes.push(VALUE);
            rest = behind;
        }
        sentence.bytes.extend(rest.bytes());
        if next < given.len() && !text.contains("{0") {
            Err(wrong("there are more values than places"))
        } else {
            Ok(sentence)
        }
    }
}

/// The packed text of these bytes.
fn packed(bytes: &[u8], literal: &LitStr) -> Result<TokenStream> {
    if bytes.iter().any(|byte| !(b' '..=b'~').contains(byte) && *byte != VALUE) {
        return Err(Error::new(literal.span(), "a sentence consists of ASCII characters"));
    }
    let packed = Literal::byte_string(&pack(bytes));
    let home = format_ident!("lf_texts", span = literal.span());
    Ok(quote!(::#home::Text::new(#packed)))
}
