// SPDX-License-Identifier: Apache-2.0
//! Places the vertices of each layer at heights, so that many lines are straight.
//!
//! Each line wants both its ends at one height. For one layer, with its neighbors where they are, the sum of the
//! weighted distances from these heights is least for the weighted median; vertices that would overlap move as one
//! (isotonic regression by pooling of adjacent violators). The layers are placed in turns.

use super::layers::{Layered, VertexRole};
use super::measures::{BLOCK_GAP, WIRE_GAP};

/// The number of times that all layers are placed after their neighbors on one side.
const SWEEPS: usize = 8;

/// The heights of the vertices.
pub(super) struct Heights {
    /// The distance of each vertex's top from the highest one's.
    pub(super) top: Vec<i64>,
    /// The distance of the lowest bottom from the highest top.
    pub(super) total: i64,
}

/// The neighbors whose heights count.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Neighbors {
    Left,
    Right,
    Both,
}

/// Places all layers.
pub(super) fn place(layered: &Layered) -> Heights {
    let mut top = vec![0; layered.vertices.len()];
    for layer in &layered.layers {
        let mut below: Option<usize> = None;
        for vertex in layer {
            top[*vertex] = below.map_or(0, |above| top[above] + distance(layered, above, *vertex));
            below = Some(*vertex);
        }
    }
    let wishes = wishes(layered);
    let count = layered.layers.len();
    for sweep in 0..SWEEPS {
        let goes_right = sweep % 2 == 0;
        for step in 0..count {
            let (layer, side) = if goes_right { (step, Neighbors::Left) } else { (count - 1 - step, Neighbors::Right) };
            place_layer(layered, layer, side, &wishes, &mut top);
        }
    }
    for layer in (0..count).chain((0..count).rev()) {
        place_layer(layered, layer, Neighbors::Both, &wishes, &mut top);
    }
    let total = close_gaps(layered, &mut top);
    Heights { top, total }
}

/// Moves everything up where no vertex is in a wide strip through all layers, and returns the height of the whole.
fn close_gaps(layered: &Layered, top: &mut [i64]) -> i64 {
    let mut vertices: Vec<usize> = (0..top.len()).collect();
    vertices.sort_by_key(|vertex| top[*vertex]);
    let mut bottom: Option<i64> = None;
    let mut moved = 0;
    for vertex in vertices {
        let moved_top = top[vertex] - moved;
        let free = bottom.map_or(moved_top, |bottom| (moved_top - bottom - BLOCK_GAP).max(0));
        moved += free;
        top[vertex] -= moved;
        let own = top[vertex] + layered.vertices[vertex].height;
        bottom = Some(bottom.map_or(own, |bottom| bottom.max(own)));
    }
    bottom.unwrap_or_default()
}

/// Returns the least distance of the tops of two neighbors in a layer.
fn distance(layered: &Layered, upper: usize, lower: usize) -> i64 {
    let (upper, lower) = (&layered.vertices[upper], &layered.vertices[lower]);
    let gap = match (upper.role, lower.role) {
        // Rows of pins have their room in themselves.
        (VertexRole::First, VertexRole::First) | (VertexRole::Last, VertexRole::Last) => 0,
        (VertexRole::Free, VertexRole::Free) => BLOCK_GAP,
        _ => WIRE_GAP,
    };
    upper.height + gap
}

/// The height of a neighbor's pin that a vertex wants for its own.
#[derive(Clone, Copy)]
struct Wish {
    /// The neighbor, and the height of the line below its top.
    neighbor: (usize, i64),
    /// The height of the line below the vertex's own top.
    own: i64,
    is_left: bool,
    weight: i64,
}

/// Returns the wishes of all vertices.
fn wishes(layered: &Layered) -> Vec<Vec<Wish>> {
    let mut wishes = vec![Vec::new(); layered.vertices.len()];
    for segment in layered.segments.iter().flatten() {
        let [one, other] = segment.ends;
        // A line that turns around begins and ends in one layer, at different heights.
        if one.is_left == other.is_left {
            continue;
        }
        let bends = segment.ends.iter().filter(|end| layered.vertices[end.vertex].role == VertexRole::Bend).count();
        let weight = [1, 2, 8][bends];
        for (own, other) in [(one, other), (other, one)] {
            let neighbor = (other.vertex, other.y);
            wishes[own.vertex].push(Wish { neighbor, own: own.y, is_left: other.is_left, weight });
        }
    }
    wishes
}

/// Vertices that touch each other, and their wishes for the first one's height.
struct Pool {
    wanted: Vec<(i64, i64)>,
    /// The number of vertices.
    count: usize,
    at: i64,
}

impl Pool {
    fn new(mut wanted: Vec<(i64, i64)>, count: usize) -> Self {
        wanted.sort_unstable();
        let total: i64 = wanted.iter().map(|(_, weight)| weight).sum();
        let mut sum = 0;
        let median = wanted.iter().find(|(_, weight)| {
            sum += weight;
            2 * sum >= total
        });
        let at = median.map_or(0, |(at, _)| *at);
        Self { wanted, count, at }
    }
}

/// Places a layer as its neighbors on a side want it.
fn place_layer(layered: &Layered, layer: usize, side: Neighbors, wishes: &[Vec<Wish>], top: &mut [i64]) {
    let vertices = &layered.layers[layer];
    // Without the least distances, the heights only have to be in order.
    let mut offsets = Vec::new();
    let mut offset = 0;
    for (position, vertex) in vertices.iter().enumerate() {
        if position > 0 {
            offset += distance(layered, vertices[position - 1], *vertex);
        }
        offsets.push(offset);
    }
    let mut pools: Vec<Pool> = Vec::new();
    for (vertex, offset) in vertices.iter().zip(&offsets) {
        let counts = |wish: &&Wish| side == Neighbors::Both || (side == Neighbors::Left) == wish.is_left;
        // Whole numbers of weights leave room for the wish to stay, which decides where there is no other.
        let wanted = wishes[*vertex]
            .iter()
            .filter(counts)
            .map(|wish| (top[wish.neighbor.0] + wish.neighbor.1 - wish.own - offset, wish.weight * 1000));
        let stay = (top[*vertex] - offset, 1);
        let mut pool = Pool::new(wanted.chain([stay]).collect(), 1);
        while let Some(above) = pools.pop_if(|above| above.at > pool.at) {
            let mut wanted = above.wanted;
            wanted.append(&mut pool.wanted);
            pool = Pool::new(wanted, above.count + pool.count);
        }
        pools.push(pool);
    }
    let heights = pools.iter().flat_map(|pool| std::iter::repeat_n(pool.at, pool.count));
    for ((vertex, offset), at) in vertices.iter().zip(&offsets).zip(heights) {
        top[*vertex] = at + offset;
    }
}
