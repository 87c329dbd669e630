// SPDX-License-Identifier: Apache-2.0
//! Formatted scaffolding with verbatim pieces of the program in it.
//!
//! The scaffolding is made with `quote` and formatted by `prettyplease`, which would reformat the users' code. So
//! placeholders stand for this code; after formatting they are replaced, line by line, while the source map is
//! recorded. Two kinds of doc comments name a place of the program in the same way.

use std::borrow::Cow;

use proc_macro2::{LineColumn, Literal, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::{Item, Visibility};

use crate::emit::{Anchor, EmitError, File, FileMap, Origin, Piece};
use crate::plan::{Location, Plan, SourceCode, Type};

const TEXT: &str = "lfz_text!(";
const LINES: &str = "lfz_lines!(";
const INLINE: &str = "lfz_inline!(";
const ANCHOR: &str = "lfz-anchor-";

/// The visibility that the items of a preamble get, so that the module of the federate can name them.
const VISIBILITY: &str = "pub(crate) ";

/// The positions of [`VISIBILITY`]: lines of a piece of code, from 0, and columns in characters, from 0; in order.
type Insertions = Vec<(usize, usize)>;

/// A verbatim piece.
struct Spliced<'p> {
    code: Cow<'p, SourceCode>,
    insertions: Insertions,
    /// The number of leading blanks to remove from its lines, except for the first one.
    dedent: usize,
}

/// The verbatim pieces of one generated file.
pub(in crate::emit) struct Splices<'p> {
    plan: &'p Plan,
    codes: Vec<Spliced<'p>>,
    texts: Vec<String>,
    anchors: Vec<Location>,
}

impl<'p> Splices<'p> {
    pub(in crate::emit) fn new(plan: &'p Plan) -> Self {
        Self { plan, codes: Vec::new(), texts: Vec::new(), anchors: Vec::new() }
    }

    /// Adds the items of a preamble, on lines of their own. Private ones become visible in the whole crate, because the
    /// federate's module has to name the types of ports and actions.
    ///
    /// # Errors
    /// As for [`Splices::lines`].
    pub(in crate::emit) fn items(&mut self, code: &'p SourceCode) -> Result<TokenStream, EmitError> {
        let number = self.add(code, private_items(&code.text), indentation(&code.text))?;
        Ok(quote! { lfz_lines!(#number); })
    }

    /// Adds code that stands on lines of its own: statements of a body.
    ///
    /// # Errors
    /// If its brackets are not balanced or it has an unterminated literal, so that it would swallow the following code.
    pub(in crate::emit) fn lines(&mut self, code: &'p SourceCode) -> Result<TokenStream, EmitError> {
        let number = self.add(code, Insertions::new(), 0)?;
        Ok(quote! { lfz_lines!(#number); })
    }

    /// Adds code within a line: an expression.
    ///
    /// # Errors
    /// As for [`Splices::lines`].
    pub(in crate::emit) fn inline(&mut self, code: &'p SourceCode) -> Result<TokenStream, EmitError> {
        let number = self.add(code, Insertions::new(), 0)?;
        Ok(quote! { lfz_inline!(#number) })
    }

    /// Adds a type within a line, at its place in the program. It has been parsed.
    pub(in crate::emit) fn ty(&mut self, ty: &Type) -> TokenStream {
        let code = Cow::Owned(SourceCode { text: ty.text.clone(), at: ty.at });
        self.codes.push(Spliced { code, insertions: Insertions::new(), dedent: 0 });
        let number = Literal::usize_unsuffixed(self.codes.len() - 1);
        quote! { lfz_inline!(#number) }
    }

    fn add(&mut self, code: &'p SourceCode, insertions: Insertions, dedent: usize) -> Result<Literal, EmitError> {
        if let Err(error) = code.text.parse::<TokenStream>() {
            let message = format!("this code ends before its brackets or literals do: {error}");
            return Err(EmitError::new(self.plan, code.at, message));
        }
        self.codes.push(Spliced { code: Cow::Borrowed(code), insertions, dedent });
        Ok(Literal::usize_unsuffixed(self.codes.len() - 1))
    }

    /// Adds items that are formatted already.
    pub(in crate::emit) fn text(&mut self, text: String) -> TokenStream {
        self.texts.push(text);
        let number = Literal::usize_unsuffixed(self.texts.len() - 1);
        quote! { lfz_text!(#number); }
    }

    /// Adds a doc comment that ends with the place of a declaration, to which all following lines are mapped.
    pub(in crate::emit) fn doc(&mut self, text: &str, at: Location) -> TokenStream {
        self.anchors.push(at);
        let text = format!(" {text}, {ANCHOR}{}.", self.anchors.len() - 1);
        quote! { #[doc = #text] }
    }

    /// Formats the scaffolding and inserts the pieces.
    ///
    /// # Errors
    /// If the scaffolding is not Rust, which would be a defect of this module's callers.
    pub(in crate::emit) fn finish(self, path: String, tokens: TokenStream) -> Result<(File, FileMap), EmitError> {
        let syntax = syn::parse2(tokens).map_err(|error| {
            let message = format!("this is a mistake of the compiler: what it generated is not Rust: {error}");
            EmitError { path: path.clone(), line: 1, column: 1, message }
        })?;
        let mut writer = Writer { splices: &self, text: header(self.plan), line: 1, map: FileMap::default() };
        writer.line = writer.text.lines().count() + 1;
        let mut spacing = Spacing::default();
        for line in prettyplease::unparse(&syntax).lines() {
            if spacing.blank_before(line) {
                writer.push("");
            }
            writer.line(line);
        }
        Ok((File { path, text: writer.text }, writer.map))
    }
}

fn header(plan: &Plan) -> String {
    format!("// Generated by lfz from {}; do not edit.\n", file_name(plan, 0))
}

fn file_name(plan: &Plan, file: usize) -> &str {
    let path = plan.files.get(file).map_or("", |file| file.path.as_str());
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Writes lines and counts them.
struct Writer<'a, 'p> {
    splices: &'a Splices<'p>,
    text: String,
    /// The number of the next line.
    line: usize,
    map: FileMap,
}

impl Writer<'_, '_> {
    fn push(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.line += 1;
    }

    fn line(&mut self, line: &str) {
        if line == "}" {
            self.push(line);
            self.map.anchors.push(Anchor { line: self.line, to: None });
        } else if let Some((_, number, _)) = placeholder(line, TEXT, ")") {
            self.splices.texts[number].lines().for_each(|line| self.push(line));
        } else if let Some((before, number, _)) = placeholder(line, LINES, ")") {
            self.verbatim_lines(before, number);
        } else {
            self.inline(line);
        }
    }

    /// Replaces a placeholder on a line of its own by all lines of its code.
    fn verbatim_lines(&mut self, indent: &str, number: usize) {
        let Some(Spliced { code, insertions, dedent }) = self.splices.codes.get(number) else { return };
        for (index, line) in code.text.trim_end().split('\n').enumerate() {
            let is_first = index == 0;
            if is_first && line.trim().is_empty() {
                continue;
            }
            // The first line begins behind `{=`, the others are whole lines of the program.
            let shown = if is_first { line.trim_start() } else { line.get(*dedent..).unwrap_or_default() };
            let skipped = line.chars().count() - shown.chars().count();
            let column = skipped + if is_first { code.at.column } else { 1 };
            let indent = if is_first { indent } else { "" };
            let cuts = insertions.iter().filter(|(line, _)| *line == index).map(|(_, column)| column - skipped);
            let to = Origin { file: code.at.file.0, line: code.at.line + index, column };
            let text = self.cut_line(indent, shown, cuts, to);
            self.push(&text);
        }
    }

    /// Writes a line of code with [`VISIBILITY`] at the cuts, and a piece of the map for each part between them.
    fn cut_line(&mut self, indent: &str, shown: &str, cuts: impl Iterator<Item = usize>, to: Origin) -> String {
        let characters: Vec<char> = shown.chars().collect();
        let mut text = indent.to_owned();
        let mut from = 0;
        for until in cuts.map(Some).chain([None]) {
            let end = until.unwrap_or(characters.len()).min(characters.len());
            let piece: String = characters[from.min(end)..end].iter().collect();
            let column = text.chars().count() + 1;
            let to = Origin { column: to.column + from, ..to };
            // No code stands before a cut at the beginning, so nothing maps there.
            if !piece.is_empty() || until.is_none() {
                self.map.pieces.push(Piece { line: self.line, column, len: end - from.min(end), to });
            }
            text.push_str(&piece);
            if until.is_some() {
                text.push_str(VISIBILITY);
            }
            from = end;
        }
        text
    }

    /// Writes a line with placeholders inside it.
    fn inline(&mut self, line: &str) {
        let mut rest = line;
        let mut shown = String::new();
        while let Some((before, number, after)) = placeholder(rest, INLINE, ")") {
            shown.push_str(before);
            shown = self.verbatim_inline(shown, number);
            rest = after;
        }
        while let Some((before, number, after)) = placeholder(rest, ANCHOR, ".") {
            shown.push_str(before);
            if let Some(at) = self.splices.anchors.get(number) {
                let to = Origin { file: at.file.0, line: at.line, column: at.column };
                self.map.anchors.push(Anchor { line: self.line, to: Some(to) });
                shown.push_str(file_name(self.splices.plan, at.file.0));
                shown = shown + ":" + &at.line.to_string();
            }
            shown.push('.');
            rest = after;
        }
        shown.push_str(rest);
        self.push(&shown);
    }

    /// Appends code to the unfinished line; returns the beginning of its last line.
    fn verbatim_inline(&mut self, mut begun: String, number: usize) -> String {
        let Some(Spliced { code, .. }) = self.splices.codes.get(number) else { return begun };
        let text = code.text.trim();
        let skipped = &code.text[..code.text.len() - code.text.trim_start().len()];
        let newlines = skipped.matches('\n').count();
        let mut column = match skipped.rsplit('\n').next() {
            Some(last) if newlines > 0 => last.chars().count() + 1,
            _ => code.at.column + skipped.chars().count(),
        };
        for (index, part) in text.split('\n').enumerate() {
            if index > 0 {
                self.push(&begun);
                begun = String::new();
                column = 1;
            }
            let to = Origin { file: code.at.file.0, line: code.at.line + newlines + index, column };
            let (line, len) = (self.line, part.chars().count());
            self.map.pieces.push(Piece { line, column: begun.chars().count() + 1, len, to });
            begun.push_str(part);
        }
        // A comment at the end must not swallow the following code.
        if format!("({text})").parse::<TokenStream>().is_err() {
            self.push(&begun);
            begun = String::new();
        }
        begun
    }
}

/// Returns the number of blanks with which all lines but the first begin; zero if a literal spans lines, because its
/// value would change.
fn indentation(text: &str) -> usize {
    fn spans_lines(tokens: TokenStream) -> bool {
        tokens.into_iter().any(|token| match token {
            TokenTree::Literal(literal) => literal.span().start().line != literal.span().end().line,
            TokenTree::Group(group) => spans_lines(group.stream()),
            TokenTree::Ident(_) | TokenTree::Punct(_) => false,
        })
    }
    if text.parse().is_ok_and(spans_lines) {
        return 0;
    }
    let lines = text.trim_end().lines().skip(1).filter(|line| !line.trim().is_empty());
    lines.map(|line| line.len() - line.trim_start_matches(' ').len()).min().unwrap_or(0)
}

/// Returns the beginnings of a preamble's private items, behind their attributes. Returns none for code that is not
/// Rust: rustc reports the reason.
fn private_items(text: &str) -> Insertions {
    let Ok(file) = syn::parse_str::<syn::File>(text) else { return Insertions::new() };
    let starts = file.items.iter().filter_map(|item| match item {
        Item::Const(item) => private(&item.vis, item.const_token.span),
        Item::Enum(item) => private(&item.vis, item.enum_token.span),
        Item::Fn(item) => private(&item.vis, first_span(&item.sig)),
        Item::Mod(item) => private(&item.vis, item.unsafety.map_or(item.mod_token.span, |word| word.span)),
        Item::Static(item) => private(&item.vis, item.static_token.span),
        Item::Struct(item) => private(&item.vis, item.struct_token.span),
        Item::Trait(item) => private(&item.vis, trait_start(item)),
        Item::Type(item) => private(&item.vis, item.type_token.span),
        Item::Union(item) => private(&item.vis, item.union_token.span),
        _ => None,
    });
    starts.map(|start| (start.line - 1, start.column)).collect()
}

/// Returns the position behind the visibility of an item, if it has none.
fn private(visibility: &Visibility, keyword: Span) -> Option<LineColumn> {
    matches!(visibility, Visibility::Inherited).then(|| keyword.start())
}

/// Returns the beginning of a trait: `unsafe`, `auto` or `trait`.
fn trait_start(item: &syn::ItemTrait) -> Span {
    let auto = item.auto_token.map_or(item.trait_token.span, |word| word.span);
    item.unsafety.map_or(auto, |word| word.span)
}

fn first_span(tokens: &impl ToTokens) -> Span {
    tokens.to_token_stream().into_iter().next().map_or_else(Span::call_site, |token| token.span())
}

/// Splits at the first placeholder of a kind: the text before it, its number, the text behind it.
fn placeholder<'l>(line: &'l str, open: &str, close: &str) -> Option<(&'l str, usize, &'l str)> {
    let (before, rest) = line.split_once(open)?;
    let (number, after) = rest.split_once(close)?;
    Some((before, number.trim().parse().ok()?, after))
}

/// Adds blank lines between items, which `prettyplease` does not.
#[derive(Default)]
struct Spacing {
    previous: String,
    in_impl: bool,
}

impl Spacing {
    /// Returns whether a blank line belongs before this one.
    fn blank_before(&mut self, line: &str) -> bool {
        let previous = core::mem::replace(&mut self.previous, line.to_owned());
        if line.starts_with("impl ") {
            self.in_impl = true;
        } else if line == "}" {
            self.in_impl = false;
        }
        let top_level = !line.starts_with([' ', '}', ')', ']']) && !line.is_empty();
        if top_level {
            let inner = |line: &str| line.starts_with("//!") || line.starts_with("#![") || line == ")]";
            let import =
                |line: &str| ["use ", "mod ", "pub mod ", "pub use "].iter().any(|start| line.starts_with(start));
            let constant = |line: &str| line.starts_with("const ") && line.ends_with(';');
            let ended = previous.ends_with(['}', ';']) || (inner(&previous) && !inner(line));
            let alike = |is: &dyn Fn(&str) -> bool| is(&previous) && is(line);
            let grouped = alike(&import) || alike(&inner) || alike(&constant);
            return ended && !grouped;
        }
        let member = line.starts_with("    ") && !line.starts_with("     ") && line != "    }";
        self.in_impl && member && previous == "    }"
    }
}

#[cfg(test)]
mod tests {
    use super::indentation;

    #[test]
    fn indentation_is_left_out_where_no_literal_spans_lines() {
        assert_eq!(indentation("\n    use a;\n\n      use b;\n  "), 4);
        assert_eq!(indentation("use a;\n  use b;"), 2);
        assert_eq!(indentation("\n  const TEXT: &str = \"a\n  b\";\n"), 0);
        assert_eq!(indentation("one line"), 0);
    }
}
