// SPDX-License-Identifier: Apache-2.0
//! Items of completion for declarations and words.

use lf_compiler::syntax::ast::{ReactionSyntax, Reference};
use lf_compiler::{Declaration, NameKind};
use lsp_types::{CompletionItem, CompletionItemKind, Documentation, MarkupContent, MarkupKind};

use crate::lsp::asked::{Asked, described};

/// Returns all names of a reaction's signature.
pub(super) fn signature(reaction: &ReactionSyntax) -> impl Iterator<Item = &Reference> {
    reaction.triggers.iter().chain(&reaction.uses).chain(&reaction.effects)
}

pub(super) fn item(label: &str, kind: CompletionItemKind, detail: &str) -> CompletionItem {
    CompletionItem {
        label: label.to_owned(),
        kind: Some(kind),
        detail: (!detail.is_empty()).then(|| detail.to_owned()),
        ..CompletionItem::default()
    }
}

pub(super) fn markdown(text: &str) -> Option<Documentation> {
    let content = MarkupContent { kind: MarkupKind::Markdown, value: text.to_owned() };
    (!text.is_empty()).then_some(Documentation::MarkupContent(content))
}

/// Returns an item for a declaration.
pub(super) fn declared(asked: &Asked<'_>, declaration: &Declaration) -> CompletionItem {
    let name = asked.name(declaration);
    CompletionItem {
        documentation: markdown(declaration.docs.as_deref().unwrap_or_default()),
        ..item(name, completion_kind(declaration.kind), &described(declaration, name))
    }
}

pub(super) fn of_kinds(asked: &Asked<'_>, kinds: &[NameKind]) -> Vec<CompletionItem> {
    let mut all: Vec<CompletionItem> = Vec::new();
    for member in asked.members().filter(|member| kinds.contains(&member.kind)) {
        let member = declared(asked, member);
        if !all.contains(&member) {
            all.push(member);
        }
    }
    all
}

/// Returns the ports of a contained reactor, with those that it inherits.
pub(super) fn ports_of(asked: &Asked<'_>, instance: &str) -> Vec<CompletionItem> {
    let is_it = |one: &&Declaration| one.kind == NameKind::Instance && asked.name(one) == instance;
    let class = asked.members().find(is_it).and_then(|one| one.ty.as_deref());
    let class = class.and_then(|class| asked.class(class.split('<').next().unwrap_or_default().trim()));
    let members = class.into_iter().flat_map(|class| asked.members_of(class));
    let ports = members.filter(|one| matches!(one.kind, NameKind::Input | NameKind::Output));
    ports.map(|port| declared(asked, port)).collect()
}

fn completion_kind(kind: NameKind) -> CompletionItemKind {
    match kind {
        NameKind::Reactor => CompletionItemKind::CLASS,
        NameKind::TypeParameter => CompletionItemKind::TYPE_PARAMETER,
        NameKind::Parameter => CompletionItemKind::CONSTANT,
        NameKind::State => CompletionItemKind::FIELD,
        NameKind::Input | NameKind::Output => CompletionItemKind::INTERFACE,
        NameKind::Timer | NameKind::LogicalAction | NameKind::PhysicalAction | NameKind::Watchdog => {
            CompletionItemKind::EVENT
        }
        NameKind::Instance => CompletionItemKind::VARIABLE,
        NameKind::Mode => CompletionItemKind::MODULE,
        NameKind::Method | NameKind::Reaction => CompletionItemKind::METHOD,
    }
}
