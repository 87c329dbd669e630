// SPDX-License-Identifier: Apache-2.0
//! The axes of drawings that have a line for each of several things.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{AXIS, Area, GRID, MUTED, style};
use super::scale::Scale;
use crate::Result;
use crate::results::Axis;

/// So many lines on this scale, whose steps and description are below them.
pub(super) fn chart<'a>(
    plot: &Area<'a>,
    scale: &Scale,
    axis: &Axis,
    count: u32,
) -> Result<ChartContext<'a, SVGBackend<'a>, Cartesian2d<Scale, RangedCoordf64>>> {
    let mut chart = ChartBuilder::on(plot)
        .x_label_area_size(AXIS)
        .build_cartesian_2d(scale.clone(), 0.0..f64::from(count) + 0.4)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .x_labels(scale.steps())
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .x_desc(axis.label.as_str())
        .x_label_style(style(MUTED, HPos::Center, VPos::Top))
        .draw()?;
    Ok(chart)
}
