// SPDX-License-Identifier: Apache-2.0
//! The output of this program: a line of JSON for each value.

use std::io::Write;

use serde::Serialize;

use crate::{Result, Samples, micros};

/// One value of one round. Rounds of the same row, unit and owner belong together.
#[derive(Debug, Serialize)]
pub struct Measured<'a> {
    /// The part of the measurements, by its name for `--only`.
    pub part: &'a str,
    /// The subject of the measurement, such as the shape of a federation.
    pub row: &'a str,
    /// The program that the value belongs to.
    pub who: &'a str,
    /// The unit of the number; absent in an error.
    pub unit: &'a str,
    /// The value, or the median of the samples; absent in an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The samples behind the value, in the order of measurement.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samples: Vec<f64>,
    /// The reason why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl<'a> Measured<'a> {
    /// Returns a row with a single value.
    pub fn value(part: &'a str, row: &'a str, who: &'a str, unit: &'a str, value: f64) -> Self {
        Self { part, row, who, unit, value: Some(value), samples: Vec::new(), error: None }
    }

    /// Returns a row of durations; the value is their median in µs.
    pub fn samples(part: &'a str, row: &'a str, who: &'a str, unit: &'a str, samples: &Samples) -> Self {
        let median = micros(samples.percentile(50));
        Self { samples: samples.micros(), ..Self::value(part, row, who, unit, median) }
    }

    /// Returns the row of a failed measurement.
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
