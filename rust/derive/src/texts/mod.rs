// SPDX-License-Identifier: Apache-2.0
//! `say!` and `text!`: sentences are packed while they are compiled.

mod pack;
mod pairs;
#[cfg(test)]
mod training;

use proc_macro2::{Ident, Literal, TokenStream, TokenTree};
use quote::{ToTokens as _, format_ident, quote};
use syn::{Error, LitStr};

use pack::{END, FIRST, VALUE, pack, pairs};

type Result<T> = core::result::Result<T, Error>;

/// Expands `text!("…")` to a packed text without values.
pub(crate) fn text(input: TokenStream) -> Result<TokenStream> {
    let literal: LitStr = syn::parse2(input)?;
    packed(literal.value().as_bytes(), &literal)
}

/// Expands `say!(formatter, "…", values…)`.
pub(crate) fn say(input: TokenStream) -> Result<TokenStream> {
    let whole = input.clone();
    let mut parts = split(input).into_iter();
    let (Some(formatter), Some(literal)) = (parts.next(), parts.next()) else {
        return Err(Error::new_spanned(whole, "a formatter and a sentence are needed"));
    };
    let literal: LitStr = syn::parse2(literal)?;
    let Sentence { bytes, values } = Sentence::read(&literal)?;
    let text = packed(&bytes, &literal)?;
    if values.is_empty() {
        return Ok(quote!(#text.show(#formatter)));
    }
    let values = LitStr::new(&values, literal.span());
    Ok(quote!(#text.write(#formatter, ::core::format_args!(#values, #(#parts),*))))
}

/// Expands one of the tables of the unpacker.
pub(crate) fn table(input: TokenStream) -> Result<TokenStream> {
    let part: Ident = syn::parse2(input)?;
    let pairs = pairs();
    let (first, second): (Vec<u8>, Vec<u8>) = pairs.iter().map(|[first, second]| (first, second)).unzip();
    match part.to_string().as_str() {
        "count" => Ok(pairs.len().into_token_stream()),
        "bytes" => Ok(quote!([#([#first, #second]),*])),
        "first" => Ok(FIRST.into_token_stream()),
        "value" => Ok(VALUE.into_token_stream()),
        "end" => Ok(END.into_token_stream()),
        _ => Err(Error::new_spanned(part, "there is no such part")),
    }
}

/// Splits at commas; the last part may end with one.
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

/// A parsed sentence in the syntax of `write!`.
struct Sentence {
    /// Its characters, with [`VALUE`] for each value.
    bytes: Vec<u8>,
    /// The values in the syntax of the sentence, with [`END`] behind each.
    values: String,
}

impl Sentence {
    fn read(literal: &LitStr) -> Result<Self> {
        let mut sentence = Self { bytes: Vec::new(), values: String::new() };
        let text = literal.value();
        let mut rest = text.as_str();
        while let Some(place) = rest.find(['{', '}']) {
            let (before, behind) = rest.split_at(place);
            sentence.bytes.extend(before.bytes());
            if behind.starts_with("{{") || behind.starts_with("}}") {
                sentence.bytes.push(behind.as_bytes()[0]);
                rest = &behind[2..];
                continue;
            }
            let end = behind.find('}').filter(|end| *end > 0);
            let (value, behind) = behind.split_at(end.ok_or_else(|| Error::new(literal.span(), "a lone brace"))? + 1);
            sentence.values += value;
            sentence.values += END;
            sentence.bytes.push(VALUE);
            rest = behind;
        }
        sentence.bytes.extend(rest.bytes());
        Ok(sentence)
    }
}

/// Returns the packed text of these bytes.
fn packed(bytes: &[u8], literal: &LitStr) -> Result<TokenStream> {
    if bytes.iter().any(|byte| !(b' '..=b'~').contains(byte) && *byte != VALUE) {
        return Err(Error::new(literal.span(), "a sentence consists of ASCII characters"));
    }
    let packed = Literal::byte_string(&pack(bytes));
    let home = format_ident!("lf_texts", span = literal.span());
    Ok(quote!(::#home::Text::new(#packed)))
}
