// SPDX-License-Identifier: Apache-2.0
//! Pictures of programs: `figure` makes blocks and wires of a diagram, `layout` places them, and `svg` writes them.

mod figure;
mod layout;
mod svg;
mod text;

use lf_compiler::deployment::Deployment;
use lf_compiler::diagram::Diagram;

use crate::args::GraphTheme;

/// Returns the picture of a program as SVG.
///
/// `depth` is the number of levels below the main reactor whose contents are drawn.
pub(crate) fn picture(diagram: &Diagram, deployment: Option<&Deployment>, depth: usize, theme: GraphTheme) -> String {
    let drawing = figure::drawing(diagram, deployment, depth);
    let placed = layout::lay_out(&drawing.figure);
    svg::write(&drawing, &placed, theme)
}
