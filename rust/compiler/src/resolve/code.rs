// SPDX-License-Identifier: Apache-2.0
//! Checks the syntax of code blocks, without the target language's compiler.

use std::thread;

use super::load::Program;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::lexical::{CodeKind, Language};
use crate::stack::{STACK_BYTES, joined};
use crate::syntax::ast;

/// The number of code blocks below which a thread does not pay.
const BLOCKS_PER_THREAD: usize = 256;

/// Reports the first problem of each code block.
///
/// This takes half of the front end's time for large programs, so it uses all processors.
pub(crate) fn check(program: &Program, diagnostics: &mut Diagnostics) {
    let units = program.units.iter().enumerate();
    let codes: Vec<_> = units
        .flat_map(|(index, unit)| {
            let language = program.language(index);
            unit.ast.codes.iter().map(move |code| (code, language))
        })
        .collect();
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let mut parts = codes.chunks(codes.len().div_ceil(threads).max(BLOCKS_PER_THREAD));
    let first = parts.next().unwrap_or_default();
    thread::scope(|scope| {
        let thread = || thread::Builder::new().stack_size(STACK_BYTES);
        let others: Vec<_> = parts.map(|part| (part, thread().spawn_scoped(scope, || problems(part)))).collect();
        diagnostics.extend(problems(first));
        for (part, other) in others {
            // If no thread can be created, this thread checks the part.
            diagnostics.extend(other.map_or_else(|_| problems(part), joined));
        }
    });
}

fn problems(codes: &[(&(ast::CodeBlock, CodeKind), Language)]) -> Vec<Diagnostic> {
    codes.iter().filter_map(|((code, kind), language)| problem(code, *kind, *language)).collect()
}

fn problem(code: &ast::CodeBlock, kind: CodeKind, language: Language) -> Option<Diagnostic> {
    let problem = language.code_problem(&code.text, kind)?;
    let at = |range: &core::ops::Range<usize>| {
        Span::new(code.span.file, code.span.start + range.start, code.span.start + range.end)
    };
    let mut diagnostic = Diagnostic::new(problem.code, at(&problem.range), problem.message);
    if let Some((range, text)) = &problem.also {
        diagnostic = diagnostic.also(at(range), text.as_str());
    }
    Some(diagnostic.hint_maybe(problem.hint))
}
