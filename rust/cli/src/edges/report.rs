// SPDX-License-Identifier: Apache-2.0
//! The results, in the form of `--json`.

use serde::Serialize;

use super::analysis::{Histogram, Line, Pair, Statistics};
use super::file::Signal;

/// The signals.
#[derive(Debug, Serialize)]
pub(super) struct Listing<'s> {
    pub(super) signals: Vec<Listed<'s>>,
}

/// A signal that can be compared.
#[derive(Debug, Serialize)]
pub(super) struct Listed<'s> {
    pub(super) signal: &'s str,
    pub(super) edges: usize,
}

impl<'s> Listing<'s> {
    pub(super) fn of(signals: &'s [Signal]) -> Self {
        let listed = |Signal { name, edges }: &'s Signal| Listed { signal: name, edges: edges.len() };
        Self { signals: signals.iter().map(listed).collect() }
    }
}

/// One signal beside the reference.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    pub(super) signal: String,
    pub(super) edges: usize,
    /// The numbers of edges that only the reference has, and that the reference lacks.
    pub(super) missing: usize,
    pub(super) extra: usize,
    pub(super) delay: Option<Statistics>,
    pub(super) drift: Option<Line>,
    /// The histogram of the distances from the line of the drift; of the delays themselves without one.
    pub(super) histogram: Option<Histogram>,
    pub(super) pairs: Vec<Pair>,
}

/// The complete results.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) reference: String,
    pub(super) edges: usize,
    /// The maximum distance of edges.
    pub(super) window_us: f64,
    pub(super) compared: Vec<Comparison>,
}
