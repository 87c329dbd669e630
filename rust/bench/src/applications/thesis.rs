// SPDX-License-Identifier: Apache-2.0
//! What the thesis tells of its message test (section 6.2).

use crate::results::{Cell, Comparison, Mark, Row, Who};

/// What the thesis tells of messages with one coordination.
pub(super) struct Thesis {
    /// As LF calls it.
    pub(super) coordination: &'static str,
    /// Milliseconds, about (section 6.2.1).
    pub(super) delay_ms: f64,
    /// Messages per second in each of ten runs (table 6.1).
    pub(super) rates: [f64; 10],
}

/// Between its two boards.
pub(super) const THESIS: [Thesis; 2] = [
    Thesis {
        coordination: "centralized",
        delay_ms: 6.0,
        rates: [604.76, 619.56, 614.00, 616.52, 599.82, 587.96, 581.17, 674.53, 628.42, 589.79],
    },
    Thesis {
        coordination: "decentralized",
        delay_ms: 4.0,
        rates: [583.43, 592.86, 585.22, 589.41, 601.12, 583.03, 588.81, 590.12, 588.02, 586.82],
    },
];

impl Thesis {
    /// The average messages per second.
    pub(super) fn rate(&self) -> f64 {
        self.rates.iter().sum::<f64>() / 10.0
    }

    /// A row of its rates.
    pub(super) fn row(&self) -> Row {
        Row::new(format!("thesis, boards, {}", self.coordination), Who::Thesis, self.rates.to_vec())
    }

    /// Where its delay is, in µs.
    pub(super) fn mark(&self) -> Mark {
        let label = format!("thesis, boards, {}: about {} ms", self.coordination, self.delay_ms);
        Mark { label, who: Who::Thesis, at: self.delay_ms * 1e3 }
    }

    /// A rate of ours beside the average.
    pub(super) fn compare_rate(&self, what: &str, ours: Cell) -> Comparison {
        Comparison {
            what: format!("messages, {what}"),
            unit: "messages/s".to_owned(),
            less_is_better: false,
            ours,
            with: "thesis, table 6.1".to_owned(),
            theirs: Cell::number(self.rate(), 2),
        }
    }
}
