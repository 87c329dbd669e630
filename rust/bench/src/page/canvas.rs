// SPDX-License-Identifier: Apache-2.0
//! What all drawings have in common: colours, sizes of texts, and the area that is drawn on.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Result;
use crate::results::{Mark, Who};

/// In the SVG's own units, which are CSS pixels where the page is wide enough.
pub(super) const WIDTH: u32 = 860;
/// The height of a line of text.
pub(super) const LINE: u32 = 22;
/// The size of texts.
pub(super) const TEXT: i32 = 17;
/// Room below a plot for its axis.
pub(super) const AXIS: u32 = 52;

/// The page's style sheet has another value for each of these where the reader prefers dark pages.
pub(super) const INK: RGBColor = RGBColor(31, 35, 40);
pub(super) const MUTED: RGBColor = RGBColor(91, 98, 107);
pub(super) const GRID: RGBColor = RGBColor(221, 225, 230);
/// Of parts of one bar.
pub(super) const PARTS: [RGBColor; 9] = [
    RGBColor(154, 163, 173),
    RGBColor(200, 206, 213),
    RGBColor(31, 95, 168),
    RGBColor(42, 143, 131),
    RGBColor(194, 106, 22),
    RGBColor(122, 78, 163),
    RGBColor(178, 58, 94),
    RGBColor(108, 142, 52),
    RGBColor(84, 110, 140),
];

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// An SVG of this height, as it is drawn.
pub(super) fn svg(height: u32, draw: impl FnOnce(&Area<'_>) -> Result<()>) -> Result<String> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
    draw(&area)?;
    area.present()?;
    drop(area);
    Ok(text)
}

pub(super) fn colour(who: Who) -> RGBColor {
    match who {
        Who::Ours => RGBColor(31, 96, 169),
        Who::OursToo => RGBColor(42, 144, 132),
        Who::Stock => RGBColor(194, 107, 23),
        Who::Raw => RGBColor(118, 125, 134),
        Who::Thesis => RGBColor(179, 38, 85),
    }
}

/// How texts look.
pub(super) fn style(colour: RGBColor, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    ("sans-serif", TEXT).into_font().color(&colour).pos(Pos::new(horizontal, vertical))
}

/// A text that begins here, in the middle of its line.
pub(super) fn write(area: &Area<'_>, text: &str, colour: RGBColor, at: (i32, i32)) -> Result<()> {
    Ok(area.draw_text(text, &style(colour, HPos::Left, VPos::Center), at)?)
}

/// A text that ends here.
pub(super) fn write_before(area: &Area<'_>, text: &str, colour: RGBColor, at: (i32, i32)) -> Result<()> {
    Ok(area.draw_text(text, &style(colour, HPos::Right, VPos::Center), at)?)
}

/// How wide a text is, about: an em has two and a bit characters of a usual font without serifs.
pub(super) fn width(text: &str) -> u32 {
    u32::try_from(text.chars().count()).unwrap_or(u32::MAX).saturating_mul(15) / 2
}

/// The room that the labels of marks take above a plot, a line for each.
pub(super) fn room(marks: &[Mark]) -> u32 {
    u32::try_from(marks.len()).unwrap_or(0) * LINE
}

/// Dashed lines from the labels of marks, which are above the plot, to its bottom. `place` is where a value is.
pub(super) fn marks(area: &Area<'_>, marks: &[Mark], bottom: i32, place: impl Fn(f64) -> i32) -> Result<()> {
    let end = i32::try_from(WIDTH)? - 8;
    let mut places = Vec::new();
    for mark in marks {
        places.push((place(mark.at), i32::try_from(width(&mark.label))?, mark));
    }
    // All labels are on one side of their lines, and in an order in which no line goes through one.
    let are_right = places.iter().all(|(x, wide, _)| x + wide < end);
    places.sort_by_key(|(x, ..)| if are_right { *x } else { -x });
    for (line, (x, _, mark)) in (0..).zip(places) {
        let (colour, y) = (colour(mark.who), line * i32::try_from(LINE)? + 12);
        if are_right {
            write(area, &mark.label, colour, (x + 6, y))?;
        } else {
            write_before(area, &mark.label, colour, (x - 6, y))?;
        }
        area.draw(&DashedPathElement::new([(x, y - 8), (x, bottom)], 5, 4, colour.stroke_width(2)))?;
    }
    Ok(())
}
