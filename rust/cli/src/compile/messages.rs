// SPDX-License-Identifier: Apache-2.0
//! The output of `cargo build --message-format=json`.

use std::path::PathBuf;

use serde::Deserialize;

use super::rustc::Diagnostic;

/// One line of it; other reasons do not matter.
#[derive(Debug, Deserialize)]
#[serde(tag = "reason")]
pub(super) enum CargoMessage {
    /// A diagnostic of rustc.
    #[serde(rename = "compiler-message")]
    Diagnostic { manifest_path: PathBuf, target: Option<Target>, message: Diagnostic },
    /// A compiled artifact.
    #[serde(rename = "compiler-artifact")]
    Artifact { target: Target, executable: Option<PathBuf>, fresh: bool },
    /// Any other message.
    #[serde(other)]
    Other,
}

/// A target in cargo's sense: a library or a program of a package.
#[derive(Debug, Deserialize)]
pub(super) struct Target {
    pub(super) name: String,
    #[serde(default)]
    kind: Vec<String>,
}

impl Target {
    /// Returns whether it is a program, and neither a library nor a build script.
    pub(super) fn is_program(&self) -> bool {
        self.kind.iter().any(|kind| kind == "bin")
    }
}

impl CargoMessage {
    /// Reads a line; returns `None` for other text, since a build script may print anything.
    pub(super) fn read(line: &str) -> Option<Self> {
        serde_json::from_str(line).ok()
    }
}
