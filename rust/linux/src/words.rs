// SPDX-License-Identifier: Apache-2.0
//! The parts that several options of a command line share: times and errors.

use std::fmt;

use lexopt::prelude::ValueExt as _;
use lf_model::time::Interval;
use lf_model::units::{nanoseconds, number_and_unit, unit_ns};

/// An error in a command line, as a phrase.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

impl From<lexopt::Error> for UsageError {
    fn from(error: lexopt::Error) -> Self {
        Self(error.to_string())
    }
}

/// Parses a number and a unit, in one argument or in two.
pub(crate) fn interval(parser: &mut lexopt::Parser) -> Result<Interval, UsageError> {
    let first = parser.value()?.string()?;
    let (number, unit) = number_and_unit(&first);
    let mut unit = unit.to_owned();
    // The unit of 0 may be left out.
    if unit.is_empty() {
        unit = if number == "0" && !next_is_unit(parser) { "ns".to_owned() } else { parser.value()?.string()? };
    }
    nanoseconds(number, &unit).map(Interval::from_nanos).map_err(|error| UsageError(error.to_string()))
}

/// Returns whether the next argument is a unit of time.
fn next_is_unit(parser: &mut lexopt::Parser) -> bool {
    let next = parser.try_raw_args().and_then(|arguments| arguments.as_slice().first().cloned());
    next.as_deref().and_then(std::ffi::OsStr::to_str).is_some_and(|word| unit_ns(word).is_some())
}
