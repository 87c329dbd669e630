// SPDX-License-Identifier: Apache-2.0
//! The reason why a command does not succeed.

use std::fmt;
use std::io;

use lf_linux::keys::KeyError;

/// The reason why a command does not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The user has been told already.
    Reported,
    /// A sentence for the user.
    Message(String),
}

impl Failure {
    /// Returns the failure with a sentence for the user.
    pub(crate) fn message(text: impl Into<String>) -> Self {
        Self::Message(text.into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reported => Ok(()),
            Self::Message(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for Failure {}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            // The reader has closed the output, and knows.
            return Self::Reported;
        }
        Self::Message(error.to_string())
    }
}

impl From<KeyError> for Failure {
    fn from(error: KeyError) -> Self {
        Self::Message(error.to_string())
    }
}

impl From<String> for Failure {
    fn from(text: String) -> Self {
        Self::Message(text)
    }
}
