// SPDX-License-Identifier: Apache-2.0
//! The way of a program through all stages.

use crate::analysis;
use crate::diagnostics::{Code, Diagnostics};
use crate::elaborated::Elaborated;
use crate::plan::Plan;
use crate::resolve::{self, SourceProvider};
use crate::stack::with_stack;
use crate::syntax::ast::SourceUnit;

/// What came of a program.
#[derive(Debug)]
pub struct Compilation {
    /// The plan; there is one exactly if the diagnostics have no error.
    pub plan: Option<Plan>,
    /// What was said about the program, with its texts.
    pub diagnostics: Diagnostics,
}

/// Compiles the program whose main file is `main_path`, as far as the plan.
///
/// All errors of a stage are reported together; a stage is entered when the one before it left enough to go on.
pub fn compile(main_path: &str, sources: &dyn SourceProvider) -> Compilation {
    let mut diagnostics = Diagnostics::default();
    let plan = with_stack(|| stages(main_path, sources, &mut diagnostics));
    diagnostics.sort();
    let plan = plan.filter(|_| !diagnostics.has_errors());
    Compilation { plan, diagnostics }
}

/// The tree of one file.
#[derive(Debug)]
pub struct SyntaxTree {
    /// The declarations that could be read; places are in the text that the diagnostics have.
    pub unit: SourceUnit,
    /// All that is wrong with the syntax, of code blocks too, with the text.
    pub diagnostics: Diagnostics,
}

/// Parses one file, whatever is in it. Imports are not followed.
pub fn parse(path: &str, text: &str) -> SyntaxTree {
    let mut diagnostics = Diagnostics::default();
    let unit = with_stack(|| {
        let mut program = resolve::alone(path, text, &mut diagnostics);
        resolve::check_code(&program, &mut diagnostics);
        program.units.pop().map(|unit| unit.ast).unwrap_or_default()
    });
    diagnostics.sort();
    SyntaxTree { unit, diagnostics }
}

fn stages(main_path: &str, sources: &dyn SourceProvider, diagnostics: &mut Diagnostics) -> Option<Plan> {
    let program = resolve::load(main_path, sources, diagnostics)?;
    let incomplete = diagnostics.iter().any(|entry| leaves_gaps(entry.code));
    let target = resolve::check_target(&program, sources, diagnostics);
    if diagnostics.keep_wrong_targets() {
        return None;
    }
    resolve::check_code(&program, diagnostics);
    // A declaration that could not be read would be missed at every use, and what is too deep nobody may parse.
    if incomplete || diagnostics.iter().any(|entry| entry.code == Code::NestingTooDeep) {
        return None;
    }
    let expanded = resolve::expand(&program, diagnostics);
    let (classes, main) = resolve::check(&program, &expanded, diagnostics);
    let main = main?;
    if diagnostics.has_errors() {
        return None;
    }
    let elaborated = Elaborated::new(&classes, main, diagnostics)?;
    analysis::analyse(&program, &elaborated, target, diagnostics)
}

/// Whether text was skipped at an error of this kind.
fn leaves_gaps(code: Code) -> bool {
    matches!(
        code,
        Code::Syntax
            | Code::UnterminatedCode
            | Code::UnterminatedComment
            | Code::UnterminatedString
            | Code::NestingTooDeep
            | Code::MissingFile
            | Code::MissingImport
            | Code::ImportCycle
            | Code::TooLarge
    )
}
