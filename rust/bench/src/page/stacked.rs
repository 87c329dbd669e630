// SPDX-License-Identifier: Apache-2.0
//! Bars of parts that make a whole.

use plotters::prelude::*;

use super::canvas::{AXIS, INK, LINE, PARTS, WIDTH, svg, width, write, write_before};
use super::lines;
use super::scale::{Scale, text};
use crate::Result;
use crate::results::Axis;

/// Half of the height of a bar.
const HALF: i32 = 8;

pub(super) fn draw(axis: &Axis, parts: &[String], bars: &[(String, Vec<f64>)]) -> Result<String> {
    let (names, lines) = names(parts);
    let top = LINE * lines + 10;
    let count = u32::try_from(bars.len())?;
    let height = top + LINE * count + 8 + AXIS;
    let sums: Vec<f64> = bars.iter().map(|(_, values)| values.iter().sum()).collect();
    let scale = Scale::from_zero(axis, sums.iter().copied());
    let left = bars.iter().map(|(label, _)| width(label)).max().unwrap_or(0).min(WIDTH / 2) + 14;
    let right = 64;
    svg(height, |area| {
        let plot = area.clone().shrink((left, top), (WIDTH - left - right, height - top));
        let chart = lines::chart(&plot, &scale, axis, count)?;
        for ((name, (x, y)), colour) in parts.iter().zip(names).zip(PARTS.iter().cycle()) {
            area.draw(&Rectangle::new([(x, y - 6), (x + 12, y + 6)], colour.filled()))?;
            write(area, name, INK, (x + 18, y))?;
        }
        for (((label, values), sum), line) in bars.iter().zip(&sums).zip(0..) {
            let y = i32::try_from(top + LINE / 2)? + line * i32::try_from(LINE)?;
            write_before(area, label, INK, (i32::try_from(left)? - 10, y))?;
            let place = |value: f64| chart.backend_coord(&(value, 0.0)).0;
            let mut begin = 0.0;
            for (value, colour) in values.iter().zip(PARTS.iter().cycle()) {
                let corners = [(place(begin), y - HALF), (place(begin + value), y + HALF)];
                area.draw(&Rectangle::new(corners, colour.filled()))?;
                begin += value;
            }
            write(area, &text(*sum), INK, (place(*sum) + 6, y))?;
        }
        Ok(())
    })
}

/// Where the names of the parts begin, above the bars, and how many lines they take.
fn names(parts: &[String]) -> (Vec<(i32, i32)>, u32) {
    let (mut x, mut line, mut places) = (4, 0, Vec::new());
    for part in parts {
        let room = width(part) + 18;
        if x > 4 && x + room > WIDTH {
            (x, line) = (4, line + 1);
        }
        let place = |number: u32| i32::try_from(number).unwrap_or(i32::MAX);
        places.push((place(x), place(line * LINE + 12)));
        x += room + 22;
    }
    (places, line + 1)
}
