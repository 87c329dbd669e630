// SPDX-License-Identifier: Apache-2.0
//! What this program prints: a line of JSON for each value that it has measured.

use std::io::Write;

use serde::Serialize;

use crate::{Result, Samples, micros};

/// One value of one round. Rounds of the same row, unit and owner belong together.
#[derive(Debug, Serialize)]
pub struct Measured<'a> {
    /// The part of the measurements, as `--only` calls it.
    pub part: &'a str,
    /// What was measured, such as the shape of a federation.
    pub row: &'a str,
    /// Whose value it is.
    pub who: &'a str,
    /// What the number counts; nothing where there is an error.
    pub unit: &'a str,
    /// The value; of samples, their median; nothing where there is an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// What the value was taken from, in the order in which it was measured.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samples: Vec<f64>,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl<'a> Measured<'a> {
    /// A value by itself.
    pub fn value(part: &'a str, row: &'a str, who: &'a str, unit: &'a str, value: f64) -> Self {
        Self { part, row, who, unit, value: Some(value), samples: Vec::new(), error: None }
    }

    /// Durations; the value is their median in µs.
    pub fn samples(part: &'a str, row: &'a str, who: &'a str, unit: &'a str, samples: &Samples) -> Self {
        let median = micros(samples.percentile(50));
        Self { samples: samples.micros(), ..Self::value(part, row, who, unit, median) }
    }

    /// What could not be measured.
    pub fn error(part: &'a str, row: &'a str, who: &'a str, error: String) -> Self {
        Self { part, row, who, unit: "", value: None, samples: Vec::new(), error: Some(error) }
    }

    /// Prints it.
    ///
    /// # Errors
    /// When nobody reads the output any more.
    pub fn print(&self) -> Result<()> {
        let mut output = std::io::stdout().lock();
        serde_json::to_writer(&mut output, self)?;
        Ok(writeln!(output)?)
    }
}
