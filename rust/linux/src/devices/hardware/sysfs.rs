// SPDX-License-Identifier: Apache-2.0
//! Attributes in sysfs: small files of one number each.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;

/// Reads a number.
pub(super) fn number(file: &Path) -> io::Result<f64> {
    let text = fs::read_to_string(file)?;
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {text:?}", file.display())))
}

/// Reads a number that may be missing.
pub(super) fn optional_number(file: &Path) -> io::Result<Option<f64>> {
    match number(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        other => other.map(Some),
    }
}

/// Writes a number.
pub(super) fn set(file: &Path, number: u32) -> io::Result<()> {
    // No file can be created in sysfs: a missing file is an error.
    OpenOptions::new().write(true).truncate(true).open(file)?.write_all(number.to_string().as_bytes())
}
