// SPDX-License-Identifier: Apache-2.0
//! Panics in code of the program, reported with the position in the LF file.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{Location, PanicHookInfo, set_hook, take_hook};

/// Lines of a generated file that the program has unchanged.
#[derive(Clone, Copy, Debug)]
pub struct Lines {
    /// The generated file, as rustc received it, or the end of its path.
    pub file: &'static str,
    /// The first line, from 1.
    pub line: u32,
    /// The first column, from 1.
    pub column: u32,
    /// The number of lines.
    pub count: u32,
    /// The LF file.
    pub lf: &'static str,
    /// The LF line of the first one.
    pub lf_line: u32,
    /// The LF column of [`Lines::column`].
    pub lf_column: u32,
}

/// Makes panics at these lines name the program's lines instead.
pub fn name_lf_lines(all: &'static [Lines]) {
    let usual = take_hook();
    set_hook(Box::new(move |info| match info.location().and_then(|location| find(all, location)) {
        Some((file, line, column)) => say(info, file, line, column),
        None => usual(info),
    }));
}

/// Returns the position in the program.
fn find(all: &[Lines], location: &Location<'_>) -> Option<(&'static str, u32, u32)> {
    let (line, column) = (location.line(), location.column());
    let has = |lines: &&Lines| {
        (lines.line..lines.line + lines.count).contains(&line)
            && lines.column <= column
            && location.file().ends_with(lines.file)
    };
    let lines = all.iter().rfind(has)?;
    Some((lines.lf, lines.lf_line + (line - lines.line), lines.lf_column + (column - lines.column)))
}

/// Prints the standard library's message with another position.
fn say(info: &PanicHookInfo<'_>, file: &str, line: u32, column: u32) {
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
    let thread = std::thread::current();
    let whose =
        thread.name().filter(|name| *name != "main").map_or_else(String::new, |name| format!(" in thread {name}"));
    eprintln!("panicked at {file}:{line}:{column}{whose}:\n{}", text.unwrap_or("a value that is no text"));
    let backtrace = Backtrace::capture();
    if backtrace.status() == BacktraceStatus::Captured {
        eprintln!("{backtrace}");
    } else {
        eprintln!("note: run with `RUST_BACKTRACE=1` to see how it came there");
    }
}

#[cfg(test)]
mod tests {
    use std::panic::Location;

    use super::{Lines, find};

    #[test]
    fn places_in_generated_lines_are_found_in_the_program() {
        let here = Location::caller();
        let lines = Lines {
            file: "panics.rs",
            line: here.line() - 1,
            column: 1,
            count: 2,
            lf: "P.lf",
            lf_line: 7,
            lf_column: 3,
        };
        assert_eq!(find(&[lines], here), Some(("P.lf", 8, here.column() + 2)));
        assert_eq!(find(&[Lines { count: 1, ..lines }], here), None);
        assert_eq!(find(&[Lines { column: 200, ..lines }], here), None);
        assert_eq!(find(&[Lines { file: "other.rs", ..lines }], here), None);
    }
}
