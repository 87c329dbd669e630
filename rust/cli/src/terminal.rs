// SPDX-License-Identifier: Apache-2.0
//! Output for the user: a reader that has closed the other end (`lfz … | head`) is not an error.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};

use lf_compiler::Style;

/// Writes a result to standard output, ending the line.
///
/// # Errors
/// The reason why it cannot be written.
pub(crate) fn print(text: impl Display) -> io::Result<()> {
    writeln!(output(), "{text}")
}

/// Returns the standard output, with errors that name it.
pub(crate) fn output() -> impl Write {
    StandardOutput(io::stdout().lock())
}

struct StandardOutput(io::StdoutLock<'static>);

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(named)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(named)
    }
}

/// Returns an error that names the standard output.
#[allow(clippy::needless_pass_by_value, reason = "`map_err` hands it over")]
pub(crate) fn named(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("the output cannot be written: {error}"))
}

/// Writes a remark to standard error, ending the line if it does not end yet. Ignores errors.
pub(crate) fn remark(text: impl Display) {
    let text = text.to_string();
    let end = if text.is_empty() || text.ends_with('\n') { "" } else { "\n" };
    let _ = write!(io::stderr(), "{text}{end}");
}

/// Returns whether standard error is a terminal whose user wants colours (<https://no-color.org>).
pub(crate) fn coloured() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Returns the compiler's style for that.
pub(crate) fn style() -> Style {
    if coloured() { Style::Coloured } else { Style::Plain }
}
