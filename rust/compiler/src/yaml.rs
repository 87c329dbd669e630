// SPDX-License-Identifier: Apache-2.0
//! Files in YAML that stand beside a program, and what can be wrong with them.

use core::fmt;

use serde::de::DeserializeOwned;
use serde_saphyr::Location;

/// Something that is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file, as it was named.
    pub path: String,
    /// The line, from 1.
    pub line: u64,
    /// The column, from 1.
    pub column: u64,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: error: {}", self.path, self.line, self.column, self.message)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "\n  hint: {hint}"))
    }
}

impl core::error::Error for FileError {}

/// Reads the YAML; an empty file has the default.
pub(crate) fn read<T: DeserializeOwned + Default>(path: &str, text: &str) -> Result<T, FileError> {
    let empty = text.lines().all(|line| line.trim_start().is_empty() || line.trim_start().starts_with('#'));
    if empty {
        return Ok(T::default());
    }
    serde_saphyr::from_str(text).map_err(|error| {
        let (line, column) = place(error.location().unwrap_or(Location::UNKNOWN));
        let rendered = error.without_snippet().to_string();
        // The location is shown before the message, so it is taken off its end.
        let message = rendered.split(" at line ").next().unwrap_or(&rendered);
        // And so is advice for the author of a program rather than of a file.
        let message = message.split(", set DuplicateKeyPolicy").next().unwrap_or(message).to_owned();
        FileError { path: path.to_owned(), line, column, message, hint: None }
    })
}

/// Line and column; the beginning of the file where they are not known.
pub(crate) fn place(location: Location) -> (u64, u64) {
    (location.line().max(1), location.column().max(1))
}
