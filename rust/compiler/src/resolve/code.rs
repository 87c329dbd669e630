// SPDX-License-Identifier: Apache-2.0
//! The syntax of code blocks: what the target language itself says about them without its compiler.

use super::load::Program;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::languages::Language;

/// Reports for each code block the first thing that is wrong with it.
pub(crate) fn check(program: &Program, language: &dyn Language, diagnostics: &mut Diagnostics) {
    for (code, kind) in program.units.iter().flat_map(|unit| &unit.ast.codes) {
        let Some(problem) = language.code_problem(&code.text, *kind) else { continue };
        let at = |range: &core::ops::Range<usize>| {
            Span::new(code.span.file, code.span.start + range.start, code.span.start + range.end)
        };
        let mut diagnostic = Diagnostic::new(Code::CodeSyntax, at(&problem.range), problem.message);
        if let Some((range, text)) = &problem.also {
            diagnostic = diagnostic.also(at(range), text.as_str());
        }
        diagnostics.push(diagnostic.hint_maybe(problem.hint));
    }
}
