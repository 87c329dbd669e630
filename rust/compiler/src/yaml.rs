// SPDX-License-Identifier: Apache-2.0
//! YAML files that belong to a program, and their errors.

use core::fmt;

use serde::de::DeserializeOwned;
use serde_saphyr::Location;

/// An error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The path, as the user gave it.
    pub path: String,
    /// The line, from 1.
    pub line: u64,
    /// The column, from 1.
    pub column: u64,
    /// The problem.
    pub message: String,
    /// The advice.
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
        // The location is printed before the message, so this removes it from its end.
        let message = rendered.split(" at line ").next().unwrap_or(&rendered);
        // The same for advice that addresses the author of a program rather than of a file.
        let message = message.split(", set DuplicateKeyPolicy").next().unwrap_or(message).to_owned();
        FileError { path: path.to_owned(), line, column, message, hint: None }
    })
}

/// Returns line and column; the beginning of the file if they are unknown.
pub(crate) fn place(location: Location) -> (u64, u64) {
    (location.line().max(1), location.column().max(1))
}
