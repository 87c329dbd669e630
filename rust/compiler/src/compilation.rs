// SPDX-License-Identifier: Apache-2.0
//! The pipeline of a program through all stages.

use crate::analysis;
use crate::diagnostics::{Code, Diagnostics};
use crate::diagram::{self, BankView, Diagram};
use crate::elaborated::Elaborated;
use crate::plan::Plan;
use crate::resolve::{self, SourceProvider};
use crate::stack::with_stack;
use crate::syntax::ast::SourceUnit;

/// The results of compiling a program.
#[derive(Debug)]
pub struct Compilation {
    /// The plan; it exists exactly if the diagnostics have no error.
    pub plan: Option<Plan>,
    /// The diagnostics of the program, with its texts.
    pub diagnostics: Diagnostics,
}

/// Compiles the program whose main file is `main_path`, as far as the plan.
///
/// All errors of a stage are reported together; a stage runs if the previous one left a usable result.
pub fn compile(main_path: &str, sources: &dyn SourceProvider) -> Compilation {
    let (plan, diagnostics) = through(main_path, sources, |_, plan| plan);
    Compilation { plan, diagnostics }
}

/// The results of compiling a program, and its diagram.
#[derive(Debug)]
pub struct DrawnCompilation {
    /// The same as without a diagram.
    pub compilation: Compilation,
    /// The diagram; it exists exactly if there is a plan.
    pub diagram: Option<Diagram>,
}

/// Compiles the program whose main file is `main_path`, and describes what a picture of it shows.
pub fn diagram(main_path: &str, sources: &dyn SourceProvider, banks: BankView) -> DrawnCompilation {
    let (both, diagnostics) = through(main_path, sources, |elaborated, plan| {
        let drawn = diagram::diagram_of(elaborated, &plan, banks);
        (plan, drawn)
    });
    let (plan, drawn) = both.unzip();
    DrawnCompilation { compilation: Compilation { plan, diagnostics }, diagram: drawn }
}

/// Runs all stages, and the work on the instances and the plan of a program without errors.
fn through<T: Send>(
    main_path: &str,
    sources: &dyn SourceProvider,
    work: impl FnOnce(&Elaborated<'_>, Plan) -> T + Send,
) -> (Option<T>, Diagnostics) {
    let mut diagnostics = Diagnostics::default();
    let result = with_stack(|| stages(main_path, sources, &mut diagnostics, work));
    diagnostics.sort();
    let result = result.filter(|_| !diagnostics.has_errors());
    (result, diagnostics)
}

/// The tree of one file.
#[derive(Debug)]
pub struct SyntaxTree {
    /// The declarations that could be parsed; places are in the text that the diagnostics have.
    pub unit: SourceUnit,
    /// All errors of syntax, including those in code blocks, with the text.
    pub diagnostics: Diagnostics,
}

/// Parses one file with any content. Does not follow imports.
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

fn stages<T>(
    main_path: &str,
    sources: &dyn SourceProvider,
    diagnostics: &mut Diagnostics,
    work: impl FnOnce(&Elaborated<'_>, Plan) -> T,
) -> Option<T> {
    let program = resolve::load(main_path, sources, diagnostics)?;
    let incomplete = diagnostics.iter().any(|entry| leaves_gaps(entry.code));
    let target = resolve::check_target(&program, sources, diagnostics);
    if diagnostics.keep_wrong_targets() {
        return None;
    }
    resolve::check_code(&program, diagnostics);
    // Each use of a declaration that could not be parsed would be another error, and no later stage may parse deeply
    // nested code.
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
    let plan = analysis::analyse(&program, &elaborated, target, diagnostics)?;
    Some(work(&elaborated, plan))
}

/// Returns whether the parser skips text at an error of this kind.
pub(crate) fn leaves_gaps(code: Code) -> bool {
    matches!(
        code,
        Code::Syntax
            | Code::UnterminatedCode
            | Code::UnterminatedComment
            | Code::UnterminatedString
            | Code::NestingTooDeep
            | Code::MissingFile
            | Code::MissingImport
            | Code::TooLarge
    )
}
