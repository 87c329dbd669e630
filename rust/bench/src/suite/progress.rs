// SPDX-License-Identifier: Apache-2.0
//! How far the measurements are, and how long they will take.

use std::time::Duration;

/// How much slower or quicker than expected a computer may seem to be.
const FACTOR_MAX: f64 = 20.0;

/// Expects of all parts that they take so many times as long as they should, as those before did.
#[derive(Debug)]
pub(super) struct Progress {
    /// What each part should take.
    nominal: Vec<Duration>,
    done: usize,
    elapsed: Duration,
}

impl Progress {
    pub(super) fn new(nominal: Vec<Duration>) -> Self {
        Self { nominal, done: 0, elapsed: Duration::ZERO }
    }

    /// What to say before the next part: `[3/11] delay, about 4 min left of 25 min`.
    pub(super) fn begin(&self, name: &str) -> String {
        let (before, rest) = self.nominal.split_at(self.done.min(self.nominal.len()));
        let (before, rest): (Duration, Duration) = (before.iter().sum(), rest.iter().sum());
        let factor = self.elapsed.as_secs_f64() / before.as_secs_f64();
        // A few seconds say nothing about the computer yet.
        let factor = if before < Duration::from_secs(5) { 1.0 } else { factor.clamp(1.0 / FACTOR_MAX, FACTOR_MAX) };
        let left = rest.mul_f64(factor);
        let place = format!("[{}/{}] {name}", self.done + 1, self.nominal.len());
        format!("{place}, about {} left of {}", words(left), words(self.elapsed + left))
    }

    pub(super) fn end(&mut self, took: Duration) {
        self.done += 1;
        self.elapsed += took;
    }
}

fn words(time: Duration) -> String {
    match time.as_secs() {
        seconds @ ..90 => format!("{seconds} s"),
        seconds => format!("{} min", (seconds + 30) / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_what_was_measured() {
        let seconds = |seconds: &[u64]| seconds.iter().copied().map(Duration::from_secs).collect();
        let mut progress = Progress::new(seconds(&[30, 60, 120]));
        assert_eq!(progress.begin("delay"), "[1/3] delay, about 4 min left of 4 min");
        progress.end(Duration::from_secs(60));
        assert_eq!(progress.begin("rate"), "[2/3] rate, about 6 min left of 7 min");
        progress.end(Duration::from_secs(12));
        assert_eq!(progress.begin("grid"), "[3/3] grid, about 2 min left of 3 min");
        let nothing = Progress::new(seconds(&[0]));
        assert_eq!(nothing.begin("sizes"), "[1/1] sizes, about 0 s left of 0 s");
    }
}
