// SPDX-License-Identifier: Apache-2.0
//! The deployment file as it is written: keys and kinds of values, with their places.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::{Location, Spanned};

use super::DeploymentError;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Raw {
    pub(super) rti: Option<RawRti>,
    #[serde(default)]
    pub(super) federates: BTreeMap<String, Option<Spanned<RawPlace>>>,
    pub(super) joint_rti: Option<Spanned<IgnoredAny>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRti {
    pub(super) platform: Option<Spanned<String>>,
    pub(super) ip: Option<Spanned<String>>,
    pub(super) port: Option<Spanned<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPlace {
    pub(super) platform: Spanned<String>,
    pub(super) ip: Option<Spanned<String>>,
    pub(super) netmask: Option<Spanned<String>>,
    pub(super) gateway: Option<Spanned<String>>,
    pub(super) mac: Option<Spanned<String>>,
    pub(super) ethernet: Option<Spanned<String>>,
    pub(super) runner: Option<Spanned<String>>,
    pub(super) probe: Option<Spanned<String>>,
}

/// Reads the YAML; an empty file is an empty deployment.
pub(super) fn read(path: &str, text: &str) -> Result<Raw, DeploymentError> {
    let empty = text.lines().all(|line| line.trim_start().is_empty() || line.trim_start().starts_with('#'));
    if empty {
        return Ok(Raw { rti: None, federates: BTreeMap::new(), joint_rti: None });
    }
    serde_saphyr::from_str(text).map_err(|error| {
        let (line, column) = place(error.location().unwrap_or(Location::UNKNOWN));
        let rendered = error.without_snippet().to_string();
        // The location is shown before the message, so it is taken off its end.
        let message = rendered.split(" at line ").next().unwrap_or(&rendered);
        // And so is advice for the author of a program rather than of a file.
        let message = message.split(", set DuplicateKeyPolicy").next().unwrap_or(message).to_owned();
        DeploymentError { path: path.to_owned(), line, column, message, hint: None }
    })
}

/// Line and column; the beginning of the file where they are not known.
pub(super) fn place(location: Location) -> (u64, u64) {
    (location.line().max(1), location.column().max(1))
}
