// SPDX-License-Identifier: Apache-2.0
//! A row for each of several things: a dot for each value, and a mark with a number at the median.

use plotters::prelude::*;

use super::canvas::{AXIS, INK, LINE, WIDTH, colour, marks, room, svg, width, write, write_before};
use super::lines;
use super::scale::{Scale, text};
use crate::Result;
use crate::results::{Axis, Mark, Row};

/// Half of the height of a median's mark.
const HALF: i32 = 8;

pub(super) fn draw(axis: &Axis, rows: &[Row], all_marks: &[Mark]) -> Result<String> {
    let top = room(all_marks) + 4;
    let count = u32::try_from(rows.len())?;
    let height = top + LINE * count + 8 + AXIS;
    let values = rows.iter().flat_map(|row| row.values.iter().copied());
    let scale = Scale::new(axis, values.chain(all_marks.iter().map(|mark| mark.at)));
    let left = rows.iter().map(|row| width(&row.label)).max().unwrap_or(0).min(WIDTH / 2) + 14;
    let numbers: Vec<String> = rows.iter().map(|row| number(&row.values)).collect();
    let right = numbers.iter().map(|number| width(number)).max().unwrap_or(0) + 18;
    svg(height, |area| {
        let plot = area.clone().shrink((left, top), (WIDTH - left - right, height - top));
        let chart = lines::chart(&plot, &scale, axis, count)?;
        let bottom = i32::try_from(height - AXIS)?;
        let place = |value: f64| chart.backend_coord(&(value, 0.0)).0;
        marks(area, all_marks, bottom, place)?;
        for ((row, number), line) in rows.iter().zip(&numbers).zip(0..) {
            let y = i32::try_from(top + LINE / 2)? + line * i32::try_from(LINE)?;
            let colour = colour(row.who);
            write_before(area, &row.label, INK, (i32::try_from(left)? - 10, y))?;
            write(area, number, colour, (i32::try_from(WIDTH - right)? + 10, y))?;
            let dots: Vec<i32> = row.values.iter().map(|value| place(*value)).collect();
            if let (Some(least), Some(greatest)) = (dots.iter().min(), dots.iter().max()) {
                area.draw(&PathElement::new([(*least, y), (*greatest, y)], colour.mix(0.35).stroke_width(2)))?;
            }
            for dot in &dots {
                area.draw(&Circle::new((*dot, y), 4, colour.mix(0.45).filled()))?;
            }
            if let Some(median) = median(&row.values) {
                let x = place(median);
                area.draw(&Rectangle::new([(x - 2, y - HALF), (x + 2, y + HALF)], colour.filled()))?;
            }
        }
        Ok(())
    })
}

/// The median, and the range.
fn number(values: &[f64]) -> String {
    let Some(median) = median(values) else { return "none".to_owned() };
    let least = values.iter().copied().fold(f64::MAX, f64::min);
    let greatest = values.iter().copied().fold(f64::MIN, f64::max);
    if least < greatest { format!("{} ({}–{})", text(median), text(least), text(greatest)) } else { text(median) }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len().is_multiple_of(2) { f64::midpoint(sorted[middle - 1], upper) } else { upper })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_its_median_and_its_range() {
        assert_eq!(number(&[3.0, 1.0, 2.0]), "2 (1–3)");
        assert_eq!(number(&[1.0, 2.0]), "1.5 (1–2)");
        assert_eq!(number(&[7.0]), "7");
        assert_eq!(number(&[]), "none");
    }
}
