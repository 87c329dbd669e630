// SPDX-License-Identifier: Apache-2.0
//! Places the layers beside each other, and the vertical parts of lines in the gaps between them.

use std::collections::BTreeMap;

use super::layers::{Layered, Segment, SegmentEnd, Vertex, VertexRole};
use super::measures::{LAYER_GAP, WIRE_GAP, int};
use super::place::Heights;

/// The result.
pub(super) struct Routed {
    /// The left border of each vertex.
    pub(super) x: Vec<i64>,
    /// The width of all layers.
    pub(super) width: i64,
    /// The corners of each line.
    pub(super) lines: Vec<Vec<(i64, i64)>>,
}

/// Places layers and lines.
pub(super) fn route(layered: &Layered, heights: &Heights) -> Routed {
    let count = layered.layers.len();
    let mut x = vec![0; layered.vertices.len()];
    let mut tracks: BTreeMap<(usize, usize), i64> = BTreeMap::new();
    let mut right = 0;
    for gap in 0..=count {
        let nets = nets(layered, heights, gap);
        let slots = slots(&nets);
        let used = slots.values().max().map_or(0, |slot| slot + 1);
        let is_outside = gap == 0 || gap == count;
        let lines = int(used) * WIRE_GAP;
        let begin = if is_outside { right } else { right + (LAYER_GAP.max(lines + LAYER_GAP / 2) - lines) / 2 };
        for (bundle, slot) in slots {
            tracks.insert((gap, bundle), begin + int(slot) * WIRE_GAP + WIRE_GAP / 2);
        }
        right = if is_outside { right + lines } else { right + LAYER_GAP.max(lines + LAYER_GAP / 2) };
        let Some(layer) = layered.layers.get(gap) else { continue };
        let widest = layer.iter().map(|vertex| layered.vertices[*vertex].width).max().unwrap_or_default();
        for vertex in layer {
            let Vertex { width, role, .. } = layered.vertices[*vertex];
            x[*vertex] = right
                + match role {
                    VertexRole::First => 0,
                    VertexRole::Last => widest - width,
                    VertexRole::Free | VertexRole::Delay | VertexRole::Bend => (widest - width) / 2,
                };
        }
        right += widest;
    }
    let lines = layered.lines.iter().map(|line| corners(layered, heights, &x, &tracks, line)).collect();
    Routed { x, width: right, lines }
}

/// Returns the point at which a segment ends.
fn point(layered: &Layered, heights: &Heights, x: &[i64], end: SegmentEnd) -> (i64, i64) {
    let side = if end.is_left { layered.vertices[end.vertex].width } else { 0 };
    (x[end.vertex] + side, heights.top[end.vertex] + end.y)
}

/// Returns the corners of a line.
fn corners(
    layered: &Layered,
    heights: &Heights,
    x: &[i64],
    tracks: &BTreeMap<(usize, usize), i64>,
    line: &[Segment],
) -> Vec<(i64, i64)> {
    let mut corners = Vec::new();
    for segment in line {
        let [from, to] = segment.ends.map(|end| point(layered, heights, x, end));
        corners.push(from);
        if from.1 != to.1 {
            let track = tracks[&(segment.gap, segment.bundle)];
            corners.extend([(track, from.1), (track, to.1)]);
        }
        corners.push(to);
    }
    // Only corners and ends are left.
    let mut kept: Vec<(i64, i64)> = Vec::new();
    for corner in corners {
        if kept.last() == Some(&corner) {
            continue;
        }
        if let [.., before, last] = kept[..]
            && ((before.0 == last.0 && last.0 == corner.0) || (before.1 == last.1 && last.1 == corner.1))
        {
            kept.pop();
        }
        kept.push(corner);
    }
    kept
}

/// Bundles with one vertical part in a gap.
struct Net {
    bundles: Vec<usize>,
    /// The heights at the left and at the right side of the gap.
    heights: [Vec<i64>; 2],
    low: i64,
    high: i64,
}

/// Returns the bundles in a gap that have vertical parts; those of one style that end at the same heights together.
fn nets(layered: &Layered, heights: &Heights, gap: usize) -> Vec<Net> {
    let mut bundles: BTreeMap<usize, [Vec<i64>; 2]> = BTreeMap::new();
    for segment in &layered.segments[gap] {
        let sides = bundles.entry(segment.bundle).or_default();
        for end in segment.ends {
            sides[usize::from(!end.is_left)].push(heights.top[end.vertex] + end.y);
        }
    }
    let mut nets: Vec<Net> = Vec::new();
    let mut by_ends: BTreeMap<(usize, Vec<i64>), usize> = BTreeMap::new();
    for (bundle, [left, mut right]) in bundles {
        right.sort_unstable();
        right.dedup();
        let all = || left.iter().chain(&right).copied();
        let (low, high) = (all().min().unwrap_or_default(), all().max().unwrap_or_default());
        if low == high {
            continue;
        }
        // Bundles that turn around at the left side end at different heights.
        let known = if right.is_empty() { None } else { by_ends.get(&(layered.styles[bundle], right.clone())) };
        if let Some(net) = known {
            let net = &mut nets[*net];
            net.bundles.push(bundle);
            net.heights[0].extend(left);
            (net.low, net.high) = (net.low.min(low), net.high.max(high));
        } else {
            by_ends.insert((layered.styles[bundle], right.clone()), nets.len());
            nets.push(Net { bundles: vec![bundle], heights: [left, right], low, high });
        }
    }
    nets
}

/// The cost of two lines on each other, in crossings.
const OVERLAP: i64 = 100;

/// Returns the crossings of two bundles if the first one's vertical part is left of the second one's.
fn cost(left: &Net, right: &Net) -> i64 {
    let crosses = |heights: &[i64], other: &Net| {
        heights.iter().filter(|height| other.low < **height && **height < other.high).count()
    };
    let crossings = crosses(&left.heights[1], right) + crosses(&right.heights[0], left);
    let is_near = |height: &&i64| right.heights[0].iter().any(|other| (other - **height).abs() < WIRE_GAP / 2);
    int(crossings) + OVERLAP * int(left.heights[1].iter().filter(is_near).count())
}

/// Returns the slots of the bundles' vertical parts, from the left: few crossings, and no two on each other.
fn slots(nets: &[Net]) -> BTreeMap<usize, usize> {
    let costs: Vec<Vec<i64>> = nets.iter().map(|left| nets.iter().map(|right| cost(left, right)).collect()).collect();
    // The gain of placing a bundle left of all that are not placed yet.
    let gain = |net: usize, other: usize| costs[other][net] - costs[net][other];
    let mut gains: Vec<i64> = (0..nets.len()).map(|net| (0..nets.len()).map(|other| gain(net, other)).sum()).collect();
    let mut open: Vec<usize> = (0..nets.len()).collect();
    let mut placed: Vec<(usize, usize)> = Vec::new();
    while let Some((position, net)) =
        open.iter().copied().enumerate().max_by_key(|(_, net)| (gains[*net], std::cmp::Reverse(*net)))
    {
        open.remove(position);
        for other in &open {
            gains[*other] -= gain(*other, net);
        }
        let touches = |other: usize| {
            let (one, other_net) = (&nets[net], &nets[other]);
            let is_beside = one.low <= other_net.high + WIRE_GAP && other_net.low <= one.high + WIRE_GAP;
            is_beside || gain(net, other) != 0
        };
        let slot = placed.iter().filter(|(other, _)| touches(*other)).map(|(_, slot)| slot + 1).max();
        placed.push((net, slot.unwrap_or_default()));
    }
    let each = placed.into_iter().flat_map(|(net, slot)| nets[net].bundles.iter().map(move |bundle| (*bundle, slot)));
    each.collect()
}
