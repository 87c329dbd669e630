// SPDX-License-Identifier: Apache-2.0
//! Descriptions of the name at a place.

use lf_compiler::diagnostics::Span;
use lsp_types::{Hover, HoverContents, HoverParams, MarkupContent, MarkupKind};

use super::asked::{Asked, described};
use super::buffers::Buffers;
use super::facts::Facts;
use super::positions::range;

/// Describes the name, or the reaction, at a place.
pub(super) fn hover(buffers: &Buffers, asked: &HoverParams) -> Option<Hover> {
    let asked = Asked::new(buffers, &asked.text_document_position_params)?;
    let (span, heading, declared, docs) = if let Some((span, declaration)) = asked.declaration() {
        let heading = described(declaration, asked.name(declaration));
        (span, heading, declaration.span, declaration.docs.clone())
    } else {
        let (keyword, signature) = reaction(&asked)?;
        (keyword, signature, keyword, None)
    };
    let docs = docs.map(|docs| format!("\n\n{docs}")).unwrap_or_default();
    let facts = Facts::of_program_with(buffers, &asked);
    let lines = facts.map(|facts| facts.about(&asked, declared)).unwrap_or_default();
    let list = if lines.is_empty() { String::new() } else { format!("\n\n- {}", lines.join("\n- ")) };
    let value = format!("```lf\n{heading}\n```{docs}{list}");
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    let range = asked.names.sources().get(span.file).map(|source| range(source, span));
    Some(Hover { contents, range })
}

/// Returns the keyword of the reaction at the place, and the reaction without its body.
fn reaction(asked: &Asked<'_>) -> Option<(Span, String)> {
    let mut all = asked.unit().reactors.iter().flat_map(|reactor| &reactor.body.reactions);
    let found = all.find(|one| (one.keyword.start..=one.keyword.end).contains(&asked.byte))?;
    let end = found.code.as_ref().map_or(asked.text.len(), |code| code.span.start.saturating_sub(2));
    let signature = asked.text.get(found.keyword.start..end)?;
    let signature = signature.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    Some((found.keyword, signature.trim().to_owned()))
}
