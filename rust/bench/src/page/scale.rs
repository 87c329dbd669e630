// SPDX-License-Identifier: Apache-2.0
//! The values of an axis, and where its lines are.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::canvas::width;
use crate::results::{Axis, Cell};

/// The width of a plot that is narrow.
const NARROW: f64 = 440.0;
/// Room between the texts of two steps.
const GAP: u32 = 14;

/// An axis that holds what is drawn, with steps of 1, 2 or 5 times a power of ten.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    is_logarithmic: bool,
    least: f64,
    greatest: f64,
    steps: Vec<f64>,
}

impl Scale {
    /// An axis for these values, which may be none. Where nothing has no logarithm, it is left out.
    pub(super) fn new(axis: &Axis, values: impl IntoIterator<Item = f64>) -> Self {
        let values = values.into_iter().filter(|value| value.is_finite());
        let (mut least, mut greatest) = (f64::MAX, f64::MIN);
        for value in values.filter(|value| !axis.is_logarithmic || *value > 0.0) {
            (least, greatest) = (least.min(value), greatest.max(value));
        }
        if least > greatest {
            (least, greatest) = (1.0, 10.0);
        }
        if axis.is_logarithmic { logarithmic(least, greatest) } else { linear(least, greatest) }
    }

    /// From nothing on.
    pub(super) fn from_zero(axis: &Axis, values: impl IntoIterator<Item = f64>) -> Self {
        Self::new(axis, values.into_iter().chain([0.0]))
    }

    pub(super) fn steps(&self) -> usize {
        self.steps.len()
    }

    /// What is beyond the axis stands at its end.
    pub(super) fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.least, self.greatest)
    }

    fn place(&self, value: f64) -> f64 {
        let place = |value: f64| if self.is_logarithmic { value.ln() } else { value };
        (place(self.clamp(value)) - place(self.least)) / (place(self.greatest) - place(self.least))
    }
}

fn linear(least: f64, greatest: f64) -> Scale {
    let span = if greatest > least { greatest - least } else { greatest.abs().max(1.0) };
    let rough = span / 5.0;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= rough);
    let step = step.unwrap_or(power);
    // Times are not below nothing.
    let first = if least >= -0.02 * span && least < span { 0.0 } else { (least / step).floor() };
    let mut steps = Vec::new();
    let mut next = first;
    while next * step < greatest + step * 0.999 {
        steps.push(next * step);
        next += 1.0;
    }
    let greatest = steps.last().copied().unwrap_or(greatest).max(greatest);
    Scale { is_logarithmic: false, least: first * step, greatest, steps }
}

fn logarithmic(least: f64, greatest: f64) -> Scale {
    let (begin, end) = (least / 1.15, greatest * 1.15);
    let steps = |digits: &[f64]| {
        let (mut steps, mut power) = (Vec::new(), 10_f64.powf(begin.log10().floor()));
        while power <= end {
            steps.extend(digits.iter().map(|digit| digit * power).filter(|step| (begin..=end).contains(step)));
            power *= 10.0;
        }
        steps
    };
    let place = |step: f64| (step / begin).ln() / (end / begin).ln();
    // As many steps as there is room for texts.
    let digits: [&[f64]; 5] =
        [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0], &[1.0, 2.0, 3.0, 5.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
    let half = |step: f64| f64::from(width(&text(step)) + GAP) / 2.0 / NARROW;
    let is_apart = |pair: &[f64]| place(pair[1]) - place(pair[0]) > half(pair[0]) + half(pair[1]);
    let fits = |steps: &Vec<f64>| steps.len() > 1 && steps.windows(2).all(is_apart);
    let all = digits.map(steps);
    let steps = all.iter().find(|steps| fits(steps)).or(all.last()).cloned().unwrap_or_default();
    Scale { is_logarithmic: true, least: begin, greatest: end, steps }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    #[expect(clippy::cast_possible_truncation, reason = "it is a place on the drawing")]
    fn map(&self, value: &f64, (begin, end): (i32, i32)) -> i32 {
        begin + (self.place(*value) * f64::from(end - begin)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.steps.clone()
    }

    fn range(&self) -> Range<f64> {
        self.least..self.greatest
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        text(*value)
    }
}

/// A value with three digits that count, or all of a whole number.
pub(super) fn text(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let rounded = format!("{:.2e}", value.abs()).parse::<f64>().unwrap_or(value.abs());
    let digits = match rounded {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        0.1.. => 3,
        _ => 4,
    };
    let text = Cell::number(value, digits).to_string();
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_hold_all_values() {
        let scale = Scale::new(&Axis::linear(""), [25.0, 26.1, 150.2]);
        assert_eq!(scale.steps, [0.0, 50.0, 100.0, 150.0, 200.0]);
        let scale = Scale::new(&Axis::logarithmic(""), [0.0, 30.0, 4000.0]);
        assert_eq!(scale.steps, [50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0].map(|step: f64| step));
        let scale = Scale::new(&Axis::linear(""), [-12.0, 3.0]);
        assert!(scale.range().start <= -12.0 && scale.range().end >= 3.0);
        assert_eq!(
            Scale::new(&Axis::logarithmic(""), []).range().start.partial_cmp(&1.0),
            Some(std::cmp::Ordering::Less)
        );
        let same = Scale::new(&Axis::linear(""), [7.0]);
        assert!(same.range().end > same.range().start);
    }

    #[test]
    fn values_have_as_many_digits_as_count() {
        let texts = [0.0, 0.25, 1.5, 35.27, 611.65, 12_000.0].map(text);
        assert_eq!(texts, ["0", "0.25", "1.5", "35.3", "612", "12,000"]);
    }
}
