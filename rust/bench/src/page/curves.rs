// SPDX-License-Identifier: Apache-2.0
//! One value over another.

use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{AXIS, Area, GRID, LINE, MUTED, WIDTH, colour, marks, room, style, svg, width, write};
use super::scale::Scale;
use crate::Result;
use crate::results::{Axis, Curve, Line, Mark};

/// The height of the plot itself.
const HEIGHT: u32 = 300;
/// Room left of it for its axis.
const LEFT: u32 = 92;

pub(super) fn draw(x: &Axis, y: &Axis, curves: &[Curve], all_marks: &[Mark]) -> Result<String> {
    let top = room(all_marks) + 10;
    let height = top + HEIGHT + AXIS;
    let of = |index: usize| curves.iter().flat_map(move |curve| curve.points.iter().map(move |point| point[index]));
    let across = Scale::new(x, of(0).chain(all_marks.iter().map(|mark| mark.at)));
    let up = Scale::new(y, of(1));
    let right = curves.iter().map(|curve| width(&curve.label)).max().unwrap_or(0) + 34;
    svg(height, |area| {
        let plot = area.clone().shrink((0, top), (WIDTH - right, height - top));
        let mut chart = ChartBuilder::on(&plot)
            .x_label_area_size(AXIS)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(across.clone(), up.clone())?;
        chart
            .configure_mesh()
            .x_labels(across.steps())
            .y_labels(up.steps())
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(GRID)
            .x_desc(x.label.as_str())
            .y_desc(y.label.as_str())
            .x_label_style(style(MUTED, HPos::Center, VPos::Top))
            .y_label_style(style(MUTED, HPos::Right, VPos::Center))
            .draw()?;
        marks(area, all_marks, i32::try_from(height - AXIS)?, |value| chart.backend_coord(&(value, 0.0)).0)?;
        for curve in curves {
            let colour = colour(curve.who);
            let points = curve.points.iter().map(|[x, y]| (across.clamp(*x), up.clamp(*y)));
            let stroke = colour.stroke_width(2);
            match curve.line {
                Line::Solid => chart.draw_series(LineSeries::new(points, stroke))?,
                Line::Dashed => chart.draw_series(DashedLineSeries::new(points, 6, 4, stroke))?,
                Line::Points => chart.draw_series(points.map(|at| Circle::new(at, 4, colour.mix(0.55).filled())))?,
            };
        }
        labels(area, curves, (top, right), |[x, y]| chart.backend_coord(&(x, y)).1)
    })
}

/// A label at the end of each curve, or as near to it as the others allow. `place` is the height of a point.
fn labels(area: &Area<'_>, curves: &[Curve], (top, right): (u32, u32), place: impl Fn([f64; 2]) -> i32) -> Result<()> {
    let line = i32::try_from(LINE)?;
    let mut ends: Vec<(i32, &Curve)> =
        curves.iter().filter_map(|curve| curve.points.last().map(|end| (place(*end), curve))).collect();
    // Those that end at one height are in the order in which they get there.
    ends.sort_by(|(one, first), (other, second)| one.cmp(other).then(middle(first).total_cmp(&middle(second))));
    let lowest = i32::try_from(top + HEIGHT)? - line / 2;
    let mut free = i32::try_from(top)? + line / 2;
    let x = i32::try_from(WIDTH - right)?;
    let count = i32::try_from(ends.len())?;
    for ((end, curve), before) in ends.into_iter().zip(0..) {
        let y = end.max(free).min(lowest - line * (count - 1 - before));
        free = y + line;
        let colour = colour(curve.who);
        match curve.line {
            Line::Points => area.draw(&Circle::new((x + 16, y), 4, colour.filled()))?,
            Line::Solid => area.draw(&PathElement::new([(x + 8, y), (x + 24, y)], colour.stroke_width(3)))?,
            Line::Dashed => {
                area.draw(&DashedPathElement::new([(x + 8, y), (x + 24, y)], 5, 3, colour.stroke_width(3)))?;
            }
        }
        write(area, &curve.label, colour, (x + 30, y))?;
    }
    Ok(())
}

/// The value of x halfway along a curve.
fn middle(curve: &Curve) -> f64 {
    curve.points.get(curve.points.len() / 2).map_or(0.0, |point| point[0])
}
