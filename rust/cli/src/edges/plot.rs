// SPDX-License-Identifier: Apache-2.0
//! The results as a picture: delays over time with their lines, a histogram, and the first edges as waves.

use std::error::Error;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::file::Signal;
use super::report::{Comparison, Report};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

const SIZE: (u32, u32) = (960, 900);
/// The colours of signals in this order. People with red-green blindness can distinguish them.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];
/// The number of edges of the reference that are shown as waves.
const WAVES: usize = 8;

/// Draws the report; the signals are the reference and those that were compared with it.
pub(super) fn write(file: &Path, report: &Report, signals: &[&Signal]) -> Drawn {
    let root = SVGBackend::new(file, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (delays, rest) = root.split_vertically(430);
    let (histograms, waves) = rest.split_vertically(250);
    draw_delays(&delays, report)?;
    draw_histograms(&histograms, report)?;
    draw_waves(&waves, signals)?;
    root.present()?;
    Ok(())
}

fn colour(signal: usize) -> RGBColor {
    COLOURS[signal % COLOURS.len()]
}

/// Returns the range of these values with a margin.
fn range(values: impl Iterator<Item = f64> + Clone) -> std::ops::Range<f64> {
    let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
    if low > high {
        return 0.0..1.0;
    }
    let room = ((high - low) * 0.08).max(0.001);
    low - room..high + room
}

fn draw_delays(area: &Area<'_>, report: &Report) -> Drawn {
    let pairs = report.compared.iter().flat_map(|comparison| &comparison.pairs);
    let last_s = pairs.clone().map(|pair| pair.time_ns / 1e9).fold(0.0, f64::max).max(1e-9);
    let mut chart = ChartBuilder::on(area)
        .caption(format!("How much later than {} edges are", report.reference), ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(72)
        .build_cartesian_2d(0.0..last_s * 1.02, range(pairs.map(|pair| pair.delay_ns / 1e3)))?;
    chart.configure_mesh().light_line_style(WHITE).x_desc("seconds since the start").y_desc("delay, µs").draw()?;
    for (number, Comparison { signal, pairs, drift, .. }) in (1..).zip(&report.compared) {
        let points = pairs.iter().map(|pair| (pair.time_ns / 1e9, pair.delay_ns / 1e3));
        let points = points.map(|point| Circle::new(point, 2, colour(number).filled()));
        let label = match drift {
            Some(line) => format!("{signal}: {:.1} µs/s, σ {:.1} µs", line.slope_us_per_s, line.residual_us),
            None => signal.clone(),
        };
        let key = move |(x, y)| Circle::new((x + 8, y), 3, colour(number).filled());
        chart.draw_series(points)?.label(label).legend(key);
        if let Some(line) = drift {
            let ends = [0.0, last_s].map(|time_s| (time_s, line.at_us(time_s)));
            chart.draw_series(LineSeries::new(ends, colour(number).stroke_width(1)))?;
        }
    }
    // The position avoids the first line.
    let slope = report.compared.iter().find_map(|comparison| comparison.drift.as_ref()).map(|line| line.slope_us_per_s);
    let is_falling = slope.is_some_and(|slope| slope < 0.0);
    chart
        .configure_series_labels()
        .position(if is_falling { SeriesLabelPosition::LowerLeft } else { SeriesLabelPosition::UpperLeft })
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

fn draw_histograms(area: &Area<'_>, report: &Report) -> Drawn {
    let histograms = || report.compared.iter().filter_map(|comparison| comparison.histogram.as_ref());
    let ends = histograms().flat_map(|histogram| {
        let width_us: f64 = histogram.counts.iter().map(|_| histogram.width_us).sum();
        [histogram.from_us, histogram.from_us + width_us]
    });
    let most = histograms().flat_map(|histogram| histogram.counts.iter().copied()).max().unwrap_or(1);
    let has_line = report.compared.iter().any(|comparison| comparison.drift.is_some());
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(72)
        .build_cartesian_2d(range(ends), 0..most + most / 12 + 1)?;
    let of = if has_line { "distance from the line, µs" } else { "delay, µs" };
    chart.configure_mesh().light_line_style(WHITE).disable_x_mesh().x_desc(of).y_desc("edges").draw()?;
    for (number, comparison) in (1..).zip(&report.compared) {
        let Some(histogram) = &comparison.histogram else { continue };
        let mut from_us = histogram.from_us;
        for count in &histogram.counts {
            let corners = [(from_us, 0), (from_us + histogram.width_us, *count)];
            from_us += histogram.width_us;
            chart.draw_series([Rectangle::new(corners, colour(number).mix(0.55).filled())])?;
        }
    }
    Ok(())
}

fn draw_waves(area: &Area<'_>, signals: &[&Signal]) -> Drawn {
    let reference = signals.first().map_or(&[][..], |signal| &signal.edges);
    let first_ms = reference.first().map_or(0.0, |edge| edge.time_ns / 1e6);
    let last_ms = reference.iter().take(WAVES).next_back().map_or(1.0, |edge| edge.time_ns / 1e6);
    let room = ((last_ms - first_ms) * 0.06).max(0.001);
    let (from, to) = (first_ms - room, last_ms + room);
    let rows = signals.iter().fold(0.0, |rows, _| rows + 1.0);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(72)
        .build_cartesian_2d(from..to, 0.0..rows)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .light_line_style(WHITE)
        .y_labels(0)
        .x_desc("the first edges, milliseconds since the start")
        .draw()?;
    let mut base = rows;
    for (number, signal) in signals.iter().enumerate() {
        base -= 1.0;
        let height = |is_high: bool| base + if is_high { 0.75 } else { 0.15 };
        let shown = signal.edges.iter().filter(|edge| (from..to).contains(&(edge.time_ns / 1e6)));
        let mut level = shown.clone().next().is_some_and(|edge| !edge.is_rising);
        let mut points = vec![(from, height(level))];
        for edge in shown {
            let at = edge.time_ns / 1e6;
            points.extend([(at, height(level)), (at, height(edge.is_rising))]);
            level = edge.is_rising;
        }
        points.push((to, height(level)));
        chart.draw_series(LineSeries::new(points, colour(number).stroke_width(2)))?;
        let at = chart.backend_coord(&(from, base + 0.6));
        area.draw_text(
            &signal.name,
            &("sans-serif", 14).into_text_style(area).color(&colour(number)),
            (12, at.1 - area.get_base_pixel().1),
        )?;
    }
    Ok(())
}
