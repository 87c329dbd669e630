// SPDX-License-Identifier: Apache-2.0
//! The C compiler's messages, as the build script of a generated crate has passed them on to cargo.

use lf_compiler::plan::{Plan, Reaction};

use super::rustc::Diagnostic;

/// Returns the diagnostics in cargo's output, in order. GCC and Clang write `file:line:column: level: message`; the
/// text between such lines, such as their excerpts, is not needed.
pub(super) fn diagnostics(log: &str) -> Vec<Diagnostic> {
    let mut all: Vec<Diagnostic> = Vec::new();
    for line in log.lines() {
        let Some(said) = NativeDiagnostic::read(line) else { continue };
        match said.level {
            "note" => {
                if let Some(last) = all.last_mut() {
                    last.add_note(said.diagnostic());
                }
            }
            _ => all.push(said.diagnostic()),
        }
    }
    all
}

/// Adds the linker's messages about missing functions to the diagnostics, at the reactions whose bodies they are.
pub(super) fn with_missing_functions(diagnostics: Vec<Diagnostic>, plan: &Plan) -> Vec<Diagnostic> {
    let reactions = plan.classes.iter().flat_map(|class| &class.reactions).filter(|reaction| reaction.external);
    let reactions: Vec<(&str, &Reaction)> =
        reactions.filter_map(|reaction| Some((reaction.name.as_deref()?, reaction))).collect();
    let mut all = Vec::new();
    for diagnostic in diagnostics {
        let names: Vec<&str> = diagnostic.rendered().lines().filter_map(missing_function).collect();
        let is_named = |name: &str| reactions.iter().any(|(function, _)| *function == name);
        if names.is_empty() || !names.iter().all(|name| is_named(name)) {
            all.push(diagnostic);
            continue;
        }
        for (name, reaction) in reactions.iter().filter(|(name, _)| names.contains(name)) {
            let message = format!(
                "no file of C has the function `{name}`, which is the body of this reaction: name the file in a \
                 `cmake-include`, or write the body here"
            );
            all.push(Diagnostic::at("error", &message, (plan.path(reaction.at), reaction.at.line, reaction.at.column)));
        }
    }
    all
}

/// Returns the function that a linker's message misses, without its arguments, which those of C++ have.
fn missing_function(line: &str) -> Option<&str> {
    let (_, symbol) = line.split_once("undefined symbol: ").or_else(|| line.split_once("undefined reference to `"))?;
    symbol.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

/// The text between a position and a message, and its level.
const LEVELS: [(&str, &str); 4] =
    [(": fatal error: ", "error"), (": error: ", "error"), (": warning: ", "warning"), (": note: ", "note")];

/// One line.
struct NativeDiagnostic<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    level: &'static str,
    message: &'a str,
}

impl<'a> NativeDiagnostic<'a> {
    fn read(line: &'a str) -> Option<Self> {
        // Before a warning of a build script, cargo prints its level and its package.
        let line = match line.trim_start().strip_prefix("warning: ") {
            Some(rest) => rest.split_once(": ").map_or(rest, |(_, rest)| rest),
            None => line.trim_start(),
        };
        let (at, mark, level) =
            LEVELS.iter().filter_map(|(mark, level)| Some((line.find(mark)?, *mark, *level))).min()?;
        let (place, message) = (&line[..at], &line[at + mark.len()..]);
        let (place, column) = place.rsplit_once(':')?;
        let (file, number) = place.rsplit_once(':')?;
        Some(Self { file, line: number.parse().ok()?, column: column.parse().ok()?, level, message })
    }

    fn diagnostic(&self) -> Diagnostic {
        Diagnostic::at(self.level, self.message, (self.file, self.line, self.column))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linkers_name_what_they_miss() {
        let names = ["rust-lld: error: undefined symbol: check", "A.c:3: undefined reference to `check(t*)'", "check"];
        assert_eq!(names.map(missing_function), [Some("check"), Some("check"), None]);
    }

    #[test]
    fn lines_of_compilers_are_told_from_others() {
        let log = "   Compiling a v0.1.0\nwarning: a@0.1.0: src/A.lf:3:5: warning: unused variable ‘x’\n\
                   A.lf: In function ‘f’:\nA.lf:9:31: error: ‘y’ undeclared: use it\n    9 |  y\n\
                   A.lf:9:31: note: each undeclared identifier is reported only once\n\
                   B.lf:1:2: fatal error: no.h: No such file or directory\n";
        let all = diagnostics(log);
        assert_eq!(all.iter().map(Diagnostic::is_error).collect::<Vec<_>>(), [false, true, true]);
        assert_eq!(all[1].to_string(), "A.lf:9:31: error: ‘y’ undeclared: use it");
    }
}
