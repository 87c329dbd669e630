// SPDX-License-Identifier: Apache-2.0
//! Layered layout of blocks in blocks: from left to right along the wires, with pins at the sides of blocks and wires
//! in right angles.
//!
//! Each container is laid out by itself, after the blocks in it, whose sizes and pins are fixed then. Wires against the
//! direction make the graph of a container cyclic; a few of them, which run around, are left out when blocks are put
//! into layers (`layers`). Then the blocks of each layer get an order with few crossings (`order`), heights with which
//! many wires are straight (`place`), and the wires get their vertical parts between the layers (`route`). All numbers
//! are integers and all choices follow the order of blocks and wires, so that equal figures have equal pictures.

mod layers;
mod measures;
mod order;
mod place;
mod route;
#[cfg(test)]
mod tests;

use layers::{LayerLine, Layered, Returns, Vertex, VertexRole};
pub(crate) use measures::PIN_ROW;
use measures::{PADDING, int};
use place::Heights;
use route::Routed;

/// The ratio of a screen's sides.
const SCREEN: (i64, i64) = (16, 10);

/// The input of a layout: blocks, and wires between their pins.
#[derive(Clone, Debug, Default)]
pub(crate) struct Figure {
    /// Containers come before their contents; the first block contains all others.
    pub(crate) blocks: Vec<Block>,
    /// The wires.
    pub(crate) wires: Vec<Wire>,
}

/// A rectangle with pins, and maybe other blocks in it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    /// The position of its container.
    pub(crate) parent: Option<usize>,
    /// The least width and height.
    pub(crate) least: (i64, i64),
    /// The height of the room for its name above pins and contents.
    pub(crate) header: i64,
    /// Whether it stays above those that are given after it, where that is possible.
    pub(crate) keeps_order: bool,
    /// Whether it is the delay of a wire.
    pub(crate) is_delay: bool,
    /// Its pins.
    pub(crate) pins: Vec<Pin>,
}

/// The place where wires reach a block: those from outside end at the left side and begin at the right side, those
/// from inside do the opposite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pin {
    /// The side of the block.
    pub(crate) side: Side,
    /// The width of its name, which stands inside the block.
    pub(crate) width: i64,
}

/// A side of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// A line from a pin to another one. Both are pins of blocks in one container, or of the container itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire {
    /// The container.
    pub(crate) container: usize,
    /// The block and the pin where it begins.
    pub(crate) from: (usize, usize),
    /// The block and the pin where it ends.
    pub(crate) to: (usize, usize),
    /// The number of its style: wires of one style from one pin share their way.
    pub(crate) style: usize,
}

/// The positions of everything in a figure.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Placed {
    /// The rectangles of the blocks.
    pub(crate) blocks: Vec<Rectangle>,
    /// Per block, the points of its pins.
    pub(crate) pins: Vec<Vec<(i64, i64)>>,
    /// The corners of the wires, both ends included.
    pub(crate) wires: Vec<Vec<(i64, i64)>>,
}

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rectangle {
    /// The left border.
    pub(crate) x: i64,
    /// The upper border.
    pub(crate) y: i64,
    /// The width.
    pub(crate) width: i64,
    /// The height.
    pub(crate) height: i64,
}

/// Lays out a figure.
pub(crate) fn lay_out(figure: &Figure) -> Placed {
    let mut contents: Vec<Vec<usize>> = vec![Vec::new(); figure.blocks.len()];
    for (index, block) in figure.blocks.iter().enumerate() {
        if let Some(parent) = block.parent {
            contents[parent].push(index);
        }
    }
    let mut wires: Vec<Vec<usize>> = vec![Vec::new(); figure.blocks.len()];
    for (index, wire) in figure.wires.iter().enumerate() {
        wires[wire.container].push(index);
    }
    let mut placed = Placed {
        blocks: vec![Rectangle::default(); figure.blocks.len()],
        pins: figure.blocks.iter().map(|block| vec![(0, 0); block.pins.len()]).collect(),
        wires: vec![Vec::new(); figure.wires.len()],
    };
    // Positions are those in the container until the last loop.
    for index in (0..figure.blocks.len()).rev() {
        if contents[index].is_empty() && wires[index].is_empty() {
            place_pins(figure, index, &mut placed);
        } else {
            place_contents(figure, index, &contents[index], &wires[index], &mut placed);
        }
    }
    for (index, block) in figure.blocks.iter().enumerate() {
        let Some(parent) = block.parent else { continue };
        let (x, y) = (placed.blocks[parent].x, placed.blocks[parent].y);
        placed.blocks[index].x += x;
        placed.blocks[index].y += y;
    }
    for (rectangle, pins) in placed.blocks.iter().zip(&mut placed.pins) {
        for pin in pins {
            *pin = (pin.0 + rectangle.x, pin.1 + rectangle.y);
        }
    }
    for (wire, points) in figure.wires.iter().zip(&mut placed.wires) {
        let container = placed.blocks[wire.container];
        for point in points {
            *point = (point.0 + container.x, point.1 + container.y);
        }
    }
    placed
}

/// Sets the size of a block without contents, and places its pins one below the other.
fn place_pins(figure: &Figure, index: usize, placed: &mut Placed) {
    let block = &figure.blocks[index];
    let of = |side| block.pins.iter().enumerate().filter(move |(_, pin)| pin.side == side);
    let widest = |side| of(side).map(|(_, pin)| pin.width).max().unwrap_or_default();
    let rows = of(Side::Left).count().max(of(Side::Right).count());
    let width = block.least.0.max(widest(Side::Left) + widest(Side::Right) + PADDING);
    let height = block.least.1.max(block.header + int(rows) * PIN_ROW);
    placed.blocks[index] = Rectangle { x: 0, y: 0, width, height };
    for (side, x) in [(Side::Left, 0), (Side::Right, width)] {
        let count = int(of(side).count());
        for (row, (pin, _)) in of(side).enumerate() {
            let y = block.header + (height - block.header) * (2 * int(row) + 1) / (2 * count);
            placed.pins[index][pin] = (x, y);
        }
    }
}

/// Lays out the contents of a container, whose own pins are in the first and the last layer.
fn place_contents(figure: &Figure, index: usize, contents: &[usize], wires: &[usize], placed: &mut Placed) {
    let block = &figure.blocks[index];
    let mut vertices = Vec::new();
    let mut vertex_of = std::collections::BTreeMap::new();
    for content in contents {
        vertex_of.insert(*content, vertices.len());
        let Rectangle { width, height, .. } = placed.blocks[*content];
        let role = if figure.blocks[*content].is_delay { VertexRole::Delay } else { VertexRole::Free };
        vertices.push(Vertex { width, height, role, keeps_order: figure.blocks[*content].keeps_order });
    }
    let first_pin = vertices.len();
    for pin in &block.pins {
        let role = if pin.side == Side::Left { VertexRole::First } else { VertexRole::Last };
        vertices.push(Vertex { width: pin.width, height: PIN_ROW, role, keeps_order: false });
    }
    // A pin of the container is a vertex of its own, and has its wires in the middle.
    let end = |(other, pin): (usize, usize)| {
        if other == index { (first_pin + pin, PIN_ROW / 2) } else { (vertex_of[&other], placed.pins[other][pin].1) }
    };
    let lines = wires.iter().map(|wire| {
        let Wire { from, to, style, .. } = figure.wires[*wire];
        LayerLine { from: end(from), to: end(to), bundle: (from, style) }
    });
    let has = |role| vertices.iter().any(|vertex| vertex.role == role);
    let top = block.header + PADDING;
    let left = if has(VertexRole::First) { 0 } else { PADDING };
    let right = if has(VertexRole::Last) { 0 } else { PADDING };
    let (heights, routed) = arrange(&vertices, &lines.collect::<Vec<_>>());
    let width = block.least.0.max(left + routed.width + right);
    let height = block.least.1.max(top + heights.total + PADDING);
    // A wide name leaves room, which goes to the gap before the last layer.
    let spare = width - (left + routed.width + right);
    placed.blocks[index] = Rectangle { x: 0, y: 0, width, height };
    for content in contents {
        let vertex = vertex_of[content];
        placed.blocks[*content].x = left + routed.x[vertex];
        placed.blocks[*content].y = top + heights.top[vertex];
    }
    for (pin, declared) in block.pins.iter().enumerate() {
        let x = if declared.side == Side::Left { 0 } else { width };
        placed.pins[index][pin] = (x, top + heights.top[first_pin + pin] + PIN_ROW / 2);
    }
    for (wire, points) in wires.iter().zip(routed.lines) {
        let ends_at_border = figure.wires[*wire].to.0 == index;
        let last = points.len() - 1;
        let stretched = |(point, (x, y)): (usize, (i64, i64))| {
            let more = if ends_at_border && point == last { spare } else { 0 };
            (left + x + more, top + y)
        };
        placed.wires[*wire] = points.into_iter().enumerate().map(stretched).collect();
    }
}

/// Arranges vertices and lines with as few lines against the direction as possible, or with those into all delays of
/// cycles. The better arrangement is larger on a screen and has fewer corners; the product of the two decides.
fn arrange(vertices: &[Vertex], lines: &[LayerLine]) -> (Heights, Routed) {
    let arranged = |returns| {
        let mut layered = Layered::new(vertices.to_vec(), lines, returns);
        order::order(&mut layered);
        let heights = place::place(&layered);
        let routed = route::route(&layered, &heights);
        (heights, routed)
    };
    let wide = arranged(Returns::Fewest);
    if vertices.iter().all(|vertex| vertex.role != VertexRole::Delay) {
        return wide;
    }
    let high = arranged(Returns::IntoDelays);
    let cost = |(heights, routed): &(Heights, Routed)| {
        let size = (routed.width * SCREEN.1).max(heights.total * SCREEN.0);
        let parts = routed.lines.iter().map(|line| int(line.len()) - 1).sum::<i64>();
        size.saturating_mul(parts)
    };
    if cost(&high) < cost(&wide) { high } else { wide }
}
