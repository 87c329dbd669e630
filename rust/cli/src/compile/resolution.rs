// SPDX-License-Identifier: Apache-2.0
//! Cargo's errors about crates that it cannot find, at the position in the program that names them.

use lf_compiler::plan::{Dependency, Plan};

use super::rustc::Diagnostic;

/// Returns the diagnostic for an error of cargo about the program's dependencies; `None` for other errors.
pub(super) fn diagnostic(log: &str, plan: &Plan) -> Option<Diagnostic> {
    let mut lines = log.lines().skip_while(|line| !line.starts_with("error: "));
    let message = lines.next()?.strip_prefix("error: ")?;
    let notes: Vec<&str> = lines.map(str::trim).filter(|line| says_something(line)).collect();
    let dependency = [message].iter().chain(&notes).flat_map(|line| quoted(line)).find_map(|word| named(word, plan))?;
    let place = (plan.path(dependency.at), dependency.at.line, dependency.at.column);
    let mut diagnostic = Diagnostic::at("error", message, place);
    for note in notes {
        diagnostic.add_note(Diagnostic::at("note", note, place));
    }
    Some(diagnostic)
}

/// Returns whether a line is not about generated packages, which the user has not made.
fn says_something(line: &str) -> bool {
    let about_packages = ["required by package", "... required by", "Caused by:", "location searched"];
    !line.is_empty() && !about_packages.iter().any(|start| line.starts_with(start))
}

/// Returns the names in a line, which cargo puts into backquotes, some with a version behind them.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2).map(|text| text.split([' ', '@', '=']).next().unwrap_or(text))
}

/// Returns the dependency of the program whose package has this name.
fn named<'p>(name: &str, plan: &'p Plan) -> Option<&'p Dependency> {
    let package = |dependency: &&Dependency| dependency.package.as_ref().unwrap_or(&dependency.name) == name;
    plan.target.cargo.dependencies.iter().find(package)
}

#[cfg(test)]
mod tests {
    use super::{quoted, says_something};

    #[test]
    fn names_stand_in_backquotes() {
        let names: Vec<&str> =
            quoted("failed to select a version for the requirement `rand = \"^99\"` of `b v1`").collect();
        assert_eq!(names, ["rand", "b"]);
        assert!(!says_something("required by package `x v0.0.0 (/somewhere)`"));
    }
}
