// SPDX-License-Identifier: Apache-2.0
//! Output for the user: a reader that has closed the other end (`lfz … | head`) is not an error.

use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::os::unix::ffi::OsStrExt;
use std::sync::OnceLock;

use lf_compiler::Style;

use crate::args::{ColorChoice, OutputArgs};

/// The options of the command line; those of a command line without options until then.
static OPTIONS: OnceLock<OutputArgs> = OnceLock::new();

/// Sets the options of the command line, once for this process.
pub(crate) fn set(options: OutputArgs) {
    // A second call would come from another command line, and there is one.
    let _ = OPTIONS.set(options);
}

fn options() -> OutputArgs {
    OPTIONS.get().copied().unwrap_or_default()
}

/// Returns whether the user wants to hear only what is wrong.
pub(crate) fn is_quiet() -> bool {
    options().quiet
}

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

/// Writes a message to standard error, ending the line if it does not end yet. Ignores errors.
pub(crate) fn report(text: impl Display) {
    let text = text.to_string();
    let end = if text.is_empty() || text.ends_with('\n') { "" } else { "\n" };
    let _ = write!(io::stderr(), "{text}{end}");
}

/// Writes a message about progress, or about what was done; with `--quiet` nobody wants it.
pub(crate) fn inform(text: impl Display) {
    if !is_quiet() {
        report(text);
    }
}

/// Writes a command that is run, for those who want to know it (`--verbose`).
pub(crate) fn show_command(words: impl IntoIterator<Item = OsString>) {
    if options().verbose {
        report(format_args!("Running {}", command_line(words)));
    }
}

/// Returns a command line as a shell reads it.
pub(crate) fn command_line(words: impl IntoIterator<Item = OsString>) -> String {
    // A word with a zero byte is none, and cannot come from a command line.
    let quoted = |word: OsString| shlex::bytes::try_quote(word.as_bytes()).map(Cow::into_owned);
    let words: Vec<Vec<u8>> = words.into_iter().filter_map(|word| quoted(word).ok()).collect();
    String::from_utf8_lossy(&words.join(&b' ')).into_owned()
}

/// Returns whether texts on a stream have colours: as `--color` says, else on a terminal whose user has not set
/// `NO_COLOR` (<https://no-color.org>).
pub(crate) fn has_colours(stream: &impl IsTerminal) -> bool {
    match options().color {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => stream.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
    }
}

/// Returns whether texts on standard error have colours.
pub(crate) fn coloured() -> bool {
    has_colours(&io::stderr())
}

/// Returns the compiler's style for that.
pub(crate) fn style() -> Style {
    if coloured() { Style::Coloured } else { Style::Plain }
}
