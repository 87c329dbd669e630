// SPDX-License-Identifier: Apache-2.0
//! Additions between the words of a file: commands above its main reactor, and waits behind its federates.

use lf_compiler::syntax::ast::ReactorKind;
use lsp_types::{
    CodeLens, CodeLensParams, Command, InlayHint, InlayHintKind, InlayHintLabel, InlayHintParams, Position,
};
use serde_json::{Value, json};

use super::asked::Asked;
use super::buffers::Buffers;
use super::facts::Facts;
use super::positions::range;

/// A command of the editor's extension, with its words.
struct EditorCommand {
    title: &'static str,
    id: &'static str,
}

const RUN: EditorCommand = EditorCommand { title: "▶ Run", id: "lfz.run" };
const RUN_FEDERATION: EditorCommand = EditorCommand { title: "▶ Run federation", id: "lfz.runFederation" };
const DEBUG: EditorCommand = EditorCommand { title: "Debug", id: "lfz.debug" };
const BUILD: EditorCommand = EditorCommand { title: "Build for board", id: "lfz.buildForBoard" };
const GRAPH: EditorCommand = EditorCommand { title: "Show graph", id: "lfz.showGraph" };

/// Returns the commands of the editor's extension that it says it has, by `experimental.commands.commands` among its
/// capabilities, as rust-analyzer asks for them.
pub(super) fn commands_of(capabilities: &Value) -> Vec<String> {
    let all = capabilities["experimental"]["commands"]["commands"].as_array();
    all.into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

/// Returns the commands above the main reactor that the editor has.
pub(super) fn lenses(buffers: &Buffers, known: &[String], asked: &CodeLensParams) -> Option<Vec<CodeLens>> {
    let asked = Asked::whole(buffers, &asked.text_document)?;
    let source = asked.source()?;
    let main = asked.unit().reactors.iter().find(|reactor| reactor.kind != ReactorKind::Plain)?;
    let run = if main.kind == ReactorKind::Federated { RUN_FEDERATION } else { RUN };
    let all = [run, DEBUG, BUILD, GRAPH].into_iter().filter(|command| known.iter().any(|id| id == command.id));
    let lens = |EditorCommand { title, id }| CodeLens {
        range: range(source, main.keyword),
        command: Some(Command::new(title.to_owned(), id.to_owned(), Some(vec![json!(asked.path)]))),
        data: None,
    };
    Some(all.map(lens).collect())
}

/// Returns how the federates of a file wait for each other, each behind its instance.
pub(super) fn hints(buffers: &Buffers, asked: &InlayHintParams) -> Option<Vec<InlayHint>> {
    let (path, text) = buffers.get(&asked.text_document.uri)?;
    let facts = Facts::of(buffers, path)?;
    let lines: Vec<&str> = text.lines().collect();
    let mut hints: Vec<InlayHint> = Vec::new();
    for (at, wait) in facts.waits(path) {
        let line = lines.get(at.line - 1).copied().unwrap_or_default();
        let code = line.split("//").next().unwrap_or_default().trim_end();
        let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let position = Position::new(number(at.line - 1), number(code.encode_utf16().count()));
        let is_asked = asked.range.start.line <= position.line && position.line <= asked.range.end.line;
        // The members of a bank are in one place.
        let is_first = hints.last().is_none_or(|last| last.position != position);
        if is_asked && is_first {
            hints.push(InlayHint {
                position,
                label: InlayHintLabel::String(wait),
                kind: Some(InlayHintKind::TYPE),
                text_edits: None,
                tooltip: None,
                padding_left: Some(true),
                padding_right: None,
                data: None,
            });
        }
    }
    Some(hints)
}
