// SPDX-License-Identifier: Apache-2.0
//! The C compiler's messages, as the build script of a generated crate has passed them on to cargo.

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
