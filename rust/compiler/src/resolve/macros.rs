// SPDX-License-Identifier: Apache-2.0
//! Macros of C that change the meaning of inherited code: the bodies of a reactor are compiled in one file, with the
//! macros of the reactor's file.

use std::collections::{BTreeMap, BTreeSet};

use super::load::Program;
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{CodeBlock, Preamble, Reactor};

/// Warns of a macro in the file of a reactor that occurs in code inherited from another file.
pub(super) fn check(program: &Program, unit: usize, reactor: &Reactor, diagnostics: &mut Vec<Diagnostic>) {
    let (own, language) = (macros(&program.units[unit].ast.preambles), program.language(unit));
    if own.is_empty() {
        return;
    }
    let codes = reactor.body.reactions.iter().filter_map(|reaction| reaction.code.as_ref());
    let codes = codes.chain(reactor.body.methods.iter().map(|method| &method.code));
    for code in codes.filter(|code| code.span.file.index() != unit) {
        let base = program.units.get(code.span.file.index()).map(|unit| macros(&unit.ast.preambles));
        let base = base.unwrap_or_default();
        // Each word counts once.
        for word in language.words(&code.text).collect::<BTreeSet<_>>() {
            let Some((value, span)) = own.get(word).filter(|(value, _)| base.get(word).is_none_or(|it| it.0 != *value))
            else {
                continue;
            };
            let message = format!(
                "`{word}` of this file takes part in code that `{}` inherits",
                reactor.name.as_ref().map_or("this reactor", |name| name.text.as_str())
            );
            let other = if base.contains_key(word) { "its own file defines it, too" } else { "it is named here" };
            let diagnostic = Diagnostic::new(Code::InheritedMacro, *span, message)
                .label(format!("here it is `{value}`"))
                .also(code.span, other)
                .hint("rename it, if the inherited code does not mean this one");
            diagnostics.push(diagnostic);
        }
    }
}

/// Returns the macros that preambles define, each with its text and its place.
fn macros(preambles: &[Preamble]) -> BTreeMap<&str, (&str, Span)> {
    let defined = |code: &'_ CodeBlock| -> Vec<(usize, usize)> {
        let lines = code.text.split_inclusive('\n').scan(0, |at, line| {
            let start = *at;
            *at += line.len();
            Some((start, line))
        });
        let define = |(start, line): (usize, &str)| {
            let directive = line.trim_start().strip_prefix('#')?.trim_start();
            let rest = directive.strip_prefix("define")?.strip_prefix([' ', '\t'])?;
            Some((start + line.len() - rest.trim_start().len(), start + line.len()))
        };
        lines.filter_map(define).collect()
    };
    let mut macros = BTreeMap::new();
    for code in preambles.iter().map(|preamble| &preamble.code) {
        for (start, end) in defined(code) {
            let text = code.text[start..end].trim_end();
            let length = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len());
            let at = code.span.start + start;
            macros.insert(&text[..length], (text[length..].trim(), Span::new(code.span.file, at, at + length)));
        }
    }
    macros
}
