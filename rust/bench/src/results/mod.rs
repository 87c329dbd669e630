// SPDX-License-Identifier: Apache-2.0
//! What measurements have found, as values: what is printed, the JSON file and the page all come from these.

mod figure;
mod machine;
mod table;

use serde::{Deserialize, Serialize};

pub use figure::{Axis, Curve, Figure, Line, Mark, Plot, Row, Who};
pub use machine::{Machine, Version};
pub use table::{Cell, Table};

/// The version of the JSON file; it changes when older files cannot be read any more.
pub const FORMAT: u32 = 1;

/// All that one run of the measurements has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`FORMAT`].
    pub format: u32,
    /// When it began, in UTC.
    pub begun: String,
    /// Whether it was a quick run, whose numbers are rough.
    pub quick: bool,
    /// What was asked for, as on the command line.
    pub arguments: Vec<String>,
    /// On what it ran, and with what.
    pub machine: Machine,
    /// The parts that are over, in order.
    pub parts: Vec<Part>,
}

/// One part of the measurements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// What `--only` calls it.
    pub name: String,
    /// How long it took.
    pub seconds: f64,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was measured.
    Measured(Finding),
    /// It failed, with this error.
    Failed(String),
    /// It was left out, for this reason.
    Skipped(String),
}

/// What one part has found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// A few words.
    pub title: String,
    /// What it answers.
    pub question: String,
    /// How it was measured, a sentence or two each.
    pub method: Vec<String>,
    /// The numbers beside what they are to be compared with.
    pub compared: Vec<Comparison>,
    /// All numbers.
    pub tables: Vec<Table>,
    /// What is drawn.
    pub figures: Vec<Figure>,
    /// What cannot be compared, and why.
    pub limits: Vec<String>,
}

/// One of our numbers beside another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// What was measured, and with what.
    pub what: String,
    /// The unit of both.
    pub unit: String,
    /// Whether less of it is better.
    pub less_is_better: bool,
    /// Ours, with its spread.
    pub ours: Cell,
    /// With what it is compared.
    pub with: String,
    /// That one's number.
    pub theirs: Cell,
}

impl Comparison {
    /// How many times theirs ours is.
    pub fn ratio(&self) -> Option<f64> {
        match (&self.ours, &self.theirs) {
            (Cell::Number { value: ours, .. }, Cell::Number { value: theirs, .. }) if *theirs > 0.0 => {
                Some(ours / theirs)
            }
            _ => None,
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "\n{}", self.title)?;
        for line in &self.method {
            writeln!(f, "{line}")?;
        }
        for table in &self.tables {
            writeln!(f, "\n{table}")?;
        }
        self.limits.iter().try_for_each(|line| writeln!(f, "{line}"))
    }
}
