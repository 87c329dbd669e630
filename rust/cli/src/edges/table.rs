// SPDX-License-Identifier: Apache-2.0
//! The results as text.

use std::fmt::{self, Write as _};

use super::analysis::{Histogram, Line, Statistics};
use super::file::Signal;
use super::report::{Comparison, Report};

/// The longest bar of a histogram, in characters.
const BAR: usize = 50;

/// Returns the list of signals.
pub(super) fn signals(signals: &[Signal]) -> String {
    let width = signals.iter().map(|signal| signal.name.len()).max().unwrap_or(0);
    let lines = signals.iter().map(|Signal { name, edges }| format!("{name:width$}  {} edges", edges.len()));
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns the results of the comparisons.
pub(super) fn report(report: &Report) -> String {
    let mut text = format!("{}: {} edges, the reference", report.reference, report.edges);
    for comparison in &report.compared {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n\n{comparison}");
    }
    text
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { signal, edges, missing, extra, .. } = self;
        write!(f, "{signal}: {edges} edges, {} of them matched, {missing} missing, {extra} more", self.pairs.len())?;
        if let Some(Statistics { min_us, mean_us, median_us, p99_us, max_us, sigma_us, .. }) = &self.delay {
            write!(f, "\n  {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}", "min", "median", "mean", "99 %", "max", "σ")?;
            write!(f, "\n  {min_us:10.3} {median_us:10.3} {mean_us:10.3} {p99_us:10.3} {max_us:10.3} {sigma_us:10.3}")?;
            f.write_str("  µs, the delay")?;
        }
        if let Some(line) = &self.drift {
            write!(f, "\n  {}", drift(line))?;
        }
        if let Some(histogram) = &self.histogram {
            let of = if self.drift.is_some() { "distance from the line" } else { "delay" };
            write!(f, "\n  {of} in µs:\n{}", bars(histogram))?;
        }
        Ok(())
    }
}

/// Returns a line as text.
pub(super) fn drift(line: &Line) -> String {
    let Line { slope_us_per_s, slope_error_us_per_s, offset_us, residual_us, median_slope_us_per_s } = line;
    format!(
        "drift {slope_us_per_s:.3} ± {slope_error_us_per_s:.3} µs/s, {offset_us:.3} µs at 0 s, σ around the line \
         {residual_us:.3} µs;\n  median of slopes {median_slope_us_per_s:.3} µs/s"
    )
}

fn bars(histogram: &Histogram) -> String {
    let most = histogram.counts.iter().copied().max().unwrap_or(0).max(1);
    let mut from_us = histogram.from_us;
    let bar = |count: &usize| {
        let to_us = from_us + histogram.width_us;
        let text = format!("  {from_us:10.3} to {to_us:10.3} {count:6} {}", "#".repeat((count * BAR).div_ceil(most)));
        from_us = to_us;
        text.trim_end().to_owned()
    };
    histogram.counts.iter().map(bar).collect::<Vec<_>>().join("\n")
}
