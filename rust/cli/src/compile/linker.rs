// SPDX-License-Identifier: Apache-2.0
//! The linker's messages about what C lacks or has twice, at the lines of the program that they name.

use std::collections::BTreeSet;

use lf_compiler::plan::{Plan, Reaction};

use super::rustc::Diagnostic;

/// The fault of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum SymbolFault {
    Missing,
    Repeated,
}

/// A message of a linker about a symbol.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Complaint<'a> {
    fault: SymbolFault,
    /// With its arguments, which those of C++ have.
    symbol: &'a str,
    /// The file and line of a use of it, or of one of its definitions.
    at: Option<(&'a str, usize)>,
}

/// Replaces the messages of linkers about symbols by errors at the reactions whose bodies are missing, and at the lines
/// that use or define a symbol, if the linker knows them.
pub(super) fn with_places(diagnostics: Vec<Diagnostic>, plan: &Plan) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    for diagnostic in diagnostics {
        // A place makes it a compiler's, whose excerpt may quote such words.
        let found = if diagnostic.has_place() { BTreeSet::new() } else { complaints(diagnostic.rendered()) };
        all.extend(found.iter().map(|complaint| complaint.error(plan)));
        if found.is_empty() {
            all.push(diagnostic);
        }
    }
    all
}

/// Returns what a linker complains about, each once. LLD writes the places into the lines behind, GNU's linker before
/// the message.
fn complaints(message: &str) -> BTreeSet<Complaint<'_>> {
    let mut all: Vec<Complaint<'_>> = Vec::new();
    for line in message.lines().map(str::trim) {
        if let Some(complaint) = Complaint::of_lld(line).or_else(|| Complaint::of_gnu(line)) {
            all.push(complaint);
        } else if let Some(place) = line.strip_prefix(">>> referenced by ").or(line.strip_prefix(">>> defined at "))
            && let Some(last) = all.last_mut()
        {
            // The path is in parentheses, if it is more than the name.
            let path = place.split_once(" (").map_or(place, |(_, path)| path.trim_end_matches(')'));
            last.at = last.at.or_else(|| file_and_line(path));
        }
    }
    all.into_iter().collect()
}

fn file_and_line(text: &str) -> Option<(&str, usize)> {
    let (file, line) = text.rsplit_once(':')?;
    Some((file, line.parse().ok()?))
}

impl<'a> Complaint<'a> {
    fn of_lld(line: &'a str) -> Option<Self> {
        let (_, symbol, fault) = after(line, "undefined symbol: ", SymbolFault::Missing)
            .or_else(|| after(line, "duplicate symbol: ", SymbolFault::Repeated))?;
        Some(Self { fault, symbol, at: None })
    }

    fn of_gnu(line: &'a str) -> Option<Self> {
        let (place, rest, fault) = after(line, ": undefined reference to `", SymbolFault::Missing)
            .or_else(|| after(line, ": multiple definition of `", SymbolFault::Repeated))?;
        let (symbol, _) = rest.split_once('\'')?;
        // The name of the linker may come first.
        let place = place.rsplit_once(": ").map_or(place, |(_, place)| place);
        Some(Self { fault, symbol, at: file_and_line(place) })
    }

    fn error(&self, plan: &Plan) -> Diagnostic {
        let symbol = self.symbol;
        let name = symbol.split(|c: char| !c.is_alphanumeric() && c != '_').next();
        let is_body = |reaction: &&Reaction| reaction.external && reaction.name.as_deref() == name;
        let mut reactions = plan.classes.iter().flat_map(|class| &class.reactions);
        let body = reactions.find(is_body).filter(|_| self.fault == SymbolFault::Missing);
        if let (Some(reaction), Some(name)) = (body, name) {
            let message = format!(
                "no file of C has the function `{name}`, which is the body of this reaction: name the file in a \
                 `cmake-include`, or write the body here"
            );
            let at = (plan.path(reaction.at), reaction.at.line, reaction.at.column);
            return Diagnostic::at("error", &message, at);
        }
        let message = match self.fault {
            SymbolFault::Missing => format!(
                "no file of C and no library has `{symbol}`, which is used: name the file or the library in a \
                 `cmake-include`"
            ),
            SymbolFault::Repeated => format!(
                "`{symbol}` is defined more than once: a preamble is part of each reactor of its file, and of each \
                 file that imports that; write `static` before the definition"
            ),
        };
        match self.at {
            Some((file, line)) => Diagnostic::at("error", &message, (file, line, 1)),
            None => Diagnostic::without_place("error", &message),
        }
    }
}

/// Returns what is before and behind a mark.
fn after<'a>(line: &'a str, mark: &str, fault: SymbolFault) -> Option<(&'a str, &'a str, SymbolFault)> {
    line.split_once(mark).map(|(before, behind)| (before, behind, fault))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(message: &str) -> Vec<Complaint<'_>> {
        complaints(message).into_iter().collect()
    }

    fn missing<'a>(symbol: &'a str, at: Option<(&'a str, usize)>) -> Complaint<'a> {
        Complaint { fault: SymbolFault::Missing, symbol, at }
    }

    fn repeated<'a>(symbol: &'a str, at: (&'a str, usize)) -> Complaint<'a> {
        Complaint { fault: SymbolFault::Repeated, symbol, at: Some(at) }
    }

    #[test]
    fn lld_names_places_behind_its_messages() {
        let message = "  = note: rust-lld: error: undefined symbol: check(int)\n          >>> referenced by A.lf:5\n\
                       >>>        /b/a.o:(body)\n>>> referenced by A.lf:9\n\
                       rust-lld: error: duplicate symbol: f\n>>> defined at U.lf:2 (lib/U.lf:2)\n>>>  a.o:(f)\n\
                       >>> defined at U.lf:2 (lib/U.lf:2)\nrust-lld: error: duplicate symbol: f\n\
                       >>> defined at U.lf:2 (lib/U.lf:2)\n";
        assert_eq!(read(message), [missing("check(int)", Some(("A.lf", 5))), repeated("f", ("lib/U.lf", 2))]);
    }

    #[test]
    fn the_linker_of_gnu_names_places_before_its_messages() {
        let message = "/usr/bin/ld: /b/a.o: in function `body':\n/p/A.lf:3: undefined reference to `check(t*)'\n\
                       /usr/bin/ld: U.lf:2: multiple definition of `f'; /b/b.o:U.lf:2: first defined here\n\
                       a.o:(.text+0x1): undefined reference to `g'\n";
        let expected = [missing("check(t*)", Some(("/p/A.lf", 3))), missing("g", None), repeated("f", ("U.lf", 2))];
        assert_eq!(read(message), expected);
    }

    #[test]
    fn other_messages_are_none_of_a_linker() {
        assert_eq!(read("error[E0425]: cannot find value `x` in this scope\n --> src/main.rs:3:5\n"), []);
    }
}
