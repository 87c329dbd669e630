// SPDX-License-Identifier: Apache-2.0
//! What is drawn, apart from how.

use serde::{Deserialize, Serialize};

use crate::{Samples, micros};

/// A drawing with its title.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What it shows.
    pub title: String,
    /// What of the thesis it stands beside, such as `figure 6.6`; empty where there is nothing.
    pub thesis: String,
    /// How to read it.
    pub caption: String,
    /// The drawing.
    pub plot: Plot,
}

/// A kind of drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Plot {
    /// A row for each of several things: all that was measured, and the median.
    Rows {
        /// The axis of the values.
        axis: Axis,
        /// From top to bottom.
        rows: Vec<Row>,
        /// Values to compare all rows with.
        marks: Vec<Mark>,
    },
    /// One value over another.
    Curves {
        /// From left to right.
        x: Axis,
        /// From bottom to top.
        y: Axis,
        /// What is drawn.
        curves: Vec<Curve>,
        /// Values of x to compare all curves with.
        marks: Vec<Mark>,
    },
    /// A bar for each of several things, of the same parts.
    Stacked {
        /// The axis of the values.
        axis: Axis,
        /// The names of the parts.
        parts: Vec<String>,
        /// The name of each bar, and the value of each of its parts.
        bars: Vec<(String, Vec<f64>)>,
    },
}

/// An axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// What is on it, with its unit.
    pub label: String,
    /// Whether each step is a multiple of the one before.
    pub is_logarithmic: bool,
}

impl Axis {
    /// An axis with equal steps.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), is_logarithmic: false }
    }

    /// An axis whose steps are multiples.
    pub fn logarithmic(label: &str) -> Self {
        Self { label: label.to_owned(), is_logarithmic: true }
    }
}

/// Whose values these are: each has its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Who {
    /// Ours.
    Ours,
    /// Ours, in another way.
    OursToo,
    /// LF's own RTI or algorithm.
    Stock,
    /// As little as can be: raw sockets.
    Raw,
    /// The thesis.
    Thesis,
}

/// Values of one thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What it is.
    pub label: String,
    /// Whose.
    pub who: Who,
    /// All that was measured.
    pub values: Vec<f64>,
}

impl Row {
    /// A row.
    pub fn new(label: impl Into<String>, who: Who, values: Vec<f64>) -> Self {
        Self { label: label.into(), who, values }
    }
}

/// A value to compare with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// What it is.
    pub label: String,
    /// Whose.
    pub who: Who,
    /// Where it is.
    pub at: f64,
}

/// How the points of a curve are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    /// Joined by a line.
    Solid,
    /// The same, dashed.
    Dashed,
    /// Each by itself.
    Points,
}

/// Points that belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// What it is.
    pub label: String,
    /// Whose.
    pub who: Who,
    /// How it is drawn.
    pub line: Line,
    /// Values of x and y.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// How many of a hundred samples took at most so many microseconds. The slowest one of a hundred, which may be a
    /// thousand times slower than the others, is left out.
    pub fn distribution(label: impl Into<String>, who: Who, samples: &Samples) -> Self {
        let quantiles = samples.quantiles().into_iter().filter(|(percent, _)| *percent <= 99.0);
        let points = quantiles.map(|(percent, time)| [micros(time), percent]);
        Self { label: label.into(), who, line: Line::Solid, points: points.collect() }
    }
}
