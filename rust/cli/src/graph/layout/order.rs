// SPDX-License-Identifier: Apache-2.0
//! Orders the vertices of each layer so that few lines cross: by the means of their neighbors' positions, and by
//! exchanges of neighbors.

use super::layers::{Layered, Segment, VertexRole};
use super::measures::int;

/// The number of times that all layers are ordered by each neighboring one.
const SWEEPS: usize = 8;
/// The largest layer whose neighbors are exchanged, and the most segments at its sides: each exchange counts crossings.
const EXCHANGED_MAX: (usize, usize) = (40, 200);
/// The distance of two neighbors in a layer, so that pins of one vertex have positions between them.
const STEP: i64 = 1 << 16;

/// The crossings that an order of its own has to save, in parts of those in the order of the program.
const SAVED: (usize, usize) = (1, 3);

/// The places that an order may change.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Freedom {
    /// All places but those of the blocks that keep their order, among each other.
    BetweenBlocks,
    /// All places.
    All,
}

/// Orders all layers. Blocks that keep their order do so unless another one has much fewer crossings.
pub(super) fn order(layered: &mut Layered) {
    let declared = layered.layers.clone();
    let kept = best_order(layered, &declared, Freedom::BetweenBlocks);
    let free = best_order(layered, &declared, Freedom::All);
    let is_better = (kept.0 - free.0.min(kept.0)) * SAVED.1 > kept.0 * SAVED.0;
    layered.layers = if is_better { free.1 } else { kept.1 };
}

/// Returns the best order that is found, and its crossings. The search begins with the lines that pass a layer below or
/// above its blocks, and goes first to the right or to the left.
fn best_order(layered: &mut Layered, declared: &[Vec<usize>], freedom: Freedom) -> (usize, Vec<Vec<usize>>) {
    let begin = |bends_first: bool| -> Vec<Vec<usize>> {
        let is_bend = |vertex: &usize| layered.vertices[*vertex].role == VertexRole::Bend;
        let order = |layer: &Vec<usize>| {
            let (bends, others): (Vec<usize>, Vec<usize>) = layer.iter().partition(|vertex| is_bend(vertex));
            // Lines that go back lie around each other if the last one is the highest.
            let bends = bends.into_iter().rev();
            if bends_first { bends.chain(others).collect() } else { others.into_iter().chain(bends).collect() }
        };
        declared.iter().map(order).collect()
    };
    let (above, below) = (begin(true), begin(false));
    let mut best: Option<(usize, Vec<Vec<usize>>)> = None;
    for (begin, begins_left) in [(&below, true), (&below, false), (&above, true), (&above, false)] {
        layered.layers.clone_from(begin);
        for sweep in 0..=SWEEPS {
            let found = crossings(layered);
            if best.as_ref().is_none_or(|(fewest, _)| found < *fewest) {
                best = Some((found, layered.layers.clone()));
            }
            if found == 0 || sweep == SWEEPS {
                break;
            }
            let goes_right = (sweep % 2 == 0) == begins_left;
            let count = layered.layers.len();
            for step in 0..count {
                let layer = if goes_right { step } else { count - 1 - step };
                by_means(layered, layer, goes_right, freedom);
            }
            exchange(layered, freedom);
        }
    }
    best.unwrap_or_else(|| (0, declared.to_vec()))
}

/// Orders a layer by the means of the positions of its neighbors in the layer before it, seen in the direction.
fn by_means(layered: &mut Layered, layer: usize, goes_right: bool, freedom: Freedom) {
    let positions = positions(layered);
    let gap = if goes_right { layer } else { layer + 1 };
    let mut sums = vec![(0_i64, 0_i64); layered.vertices.len()];
    for segment in layered.segments[gap].iter().chain(turns(layered, layer)) {
        for (own, other) in [(0, 1), (1, 0)] {
            let (own, other) = (segment.ends[own], segment.ends[other]);
            if layered.layer[own.vertex] == layer {
                let is_turn = layered.layer[other.vertex] == layer;
                // A line around its own vertex stays beside it, wherever that goes.
                let at = if is_turn { positions[other.vertex] } else { at(layered, &positions, segment, other.vertex) };
                let sum = &mut sums[own.vertex];
                *sum = (sum.0 + at, sum.1 + 1);
            }
        }
    }
    let key = |vertex: usize| match sums[vertex] {
        (_, 0) => positions[vertex],
        (sum, count) => sum / count,
    };
    let mut vertices = std::mem::take(&mut layered.layers[layer]);
    vertices.sort_by_key(|vertex| (key(*vertex), positions[*vertex]));
    if freedom == Freedom::BetweenBlocks {
        let is_block = |vertex: &usize| layered.vertices[*vertex].keeps_order;
        let mut blocks: Vec<usize> = vertices.iter().copied().filter(is_block).collect();
        blocks.sort_unstable();
        for (place, block) in vertices.iter_mut().filter(|vertex| is_block(vertex)).zip(blocks) {
            *place = block;
        }
    }
    layered.layers[layer] = vertices;
}

/// Returns the segments whose both ends are in a layer.
fn turns(layered: &Layered, layer: usize) -> impl Iterator<Item = &Segment> {
    let gaps = layered.segments[layer].iter().chain(&layered.segments[layer + 1]);
    gaps.filter(move |segment| {
        let is_turn = segment.ends[0].is_left == segment.ends[1].is_left;
        is_turn && layered.layer[segment.ends[0].vertex] == layer
    })
}

/// Returns the position of each vertex in its layer.
fn positions(layered: &Layered) -> Vec<i64> {
    let mut positions = vec![0; layered.vertices.len()];
    for layer in &layered.layers {
        for (position, vertex) in layer.iter().enumerate() {
            positions[*vertex] = int(position + 1) * STEP;
        }
    }
    positions
}

/// Returns the position of the pin at which a segment reaches a vertex.
fn at(layered: &Layered, positions: &[i64], segment: &Segment, vertex: usize) -> i64 {
    let end = if segment.ends[0].vertex == vertex { segment.ends[0] } else { segment.ends[1] };
    positions[vertex] + end.y * (STEP / 2) / layered.vertices[vertex].height.max(1)
}

/// Exchanges neighbors in a layer as long as that makes crossings fewer.
fn exchange(layered: &mut Layered, freedom: Freedom) {
    for layer in 0..layered.layers.len() {
        let segments = layered.segments[layer].len() + layered.segments[layer + 1].len();
        if layered.layers[layer].len() > EXCHANGED_MAX.0 || segments > EXCHANGED_MAX.1 {
            continue;
        }
        let count = |layered: &Layered| {
            let positions = positions(layered);
            crossings_in(layered, &positions, layer) + crossings_in(layered, &positions, layer + 1)
        };
        let mut current = count(layered);
        for _ in 0..layered.layers[layer].len() {
            let before = current;
            for upper in 1..layered.layers[layer].len() {
                let pair = [upper - 1, upper].map(|at| layered.vertices[layered.layers[layer][at]].keeps_order);
                if freedom == Freedom::BetweenBlocks && pair == [true; 2] {
                    continue;
                }
                layered.layers[layer].swap(upper - 1, upper);
                let exchanged = count(layered);
                if exchanged < current {
                    current = exchanged;
                } else {
                    layered.layers[layer].swap(upper - 1, upper);
                }
            }
            if current == before {
                break;
            }
        }
    }
}

/// Returns the number of crossings.
fn crossings(layered: &Layered) -> usize {
    let positions = positions(layered);
    (0..layered.segments.len()).map(|gap| crossings_in(layered, &positions, gap)).sum()
}

/// Returns the number of crossings in a gap. Where a line turns around, those that begin or end between its two ends
/// cross it.
fn crossings_in(layered: &Layered, positions: &[i64], gap: usize) -> usize {
    let at = |segment: &Segment, end: usize| {
        let end = segment.ends[end];
        positions[end.vertex] + end.y * (STEP / 2) / layered.vertices[end.vertex].height.max(1)
    };
    let (mut through, mut turns) = (Vec::new(), Vec::new());
    for segment in &layered.segments[gap] {
        let ends = (at(segment, 0), at(segment, 1));
        let is_left = segment.ends.map(|end| end.is_left);
        match is_left {
            [true, false] => through.push(ends),
            [false, true] => through.push((ends.1, ends.0)),
            [side, _] => turns.push((side, ends.0.min(ends.1), ends.0.max(ends.1))),
        }
    }
    through.sort_unstable();
    let mut crossings = inversions(&through.iter().map(|(_, right)| *right).collect::<Vec<_>>());
    for (index, (side, low, high)) in turns.iter().enumerate() {
        let is_between = |at: i64| *low < at && at < *high;
        crossings += through.iter().filter(|(left, right)| is_between(if *side { *left } else { *right })).count();
        let others = turns[index + 1..].iter().filter(|other| other.0 == *side);
        crossings += others.filter(|other| is_between(other.1) != is_between(other.2)).count();
    }
    crossings
}

/// Returns the number of pairs in a list whose first is greater than the second: by a tree of counts.
fn inversions(list: &[i64]) -> usize {
    let mut sorted = list.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut counts = vec![0_usize; sorted.len() + 1];
    let mut inversions = 0;
    for (seen, value) in list.iter().enumerate() {
        let rank = sorted.partition_point(|other| other < value) + 1;
        let (mut not_greater, mut at) = (0, rank);
        while at > 0 {
            not_greater += counts[at];
            at &= at - 1;
        }
        inversions += seen - not_greater;
        let mut at = rank;
        while at < counts.len() {
            counts[at] += 1;
            at += at & at.wrapping_neg();
        }
    }
    inversions
}

#[cfg(test)]
mod tests {
    use super::inversions;

    #[test]
    fn inversions_are_pairs_in_the_wrong_order() {
        assert_eq!(inversions(&[]), 0);
        assert_eq!(inversions(&[1, 2, 2, 3]), 0);
        assert_eq!(inversions(&[3, 2, 1, 2]), 4);
    }
}
