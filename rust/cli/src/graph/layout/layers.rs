// SPDX-License-Identifier: Apache-2.0
//! Puts the vertices of one container into layers.

use std::collections::{BTreeMap, BTreeSet};

/// A rectangle, or the bend of a line that passes a layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) width: i64,
    pub(super) height: i64,
    pub(super) role: VertexRole,
    /// Whether it stays above those that are given after it, unless that makes many crossings.
    pub(super) keeps_order: bool,
}

/// The layers in which a vertex can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VertexRole {
    /// The first one: an input of the container.
    First,
    /// The last one: an output of the container.
    Last,
    /// Any other.
    Free,
    /// Any other, too: the delay of a line.
    Delay,
    /// That in which a line needs it.
    Bend,
}

/// A line from the right side of a vertex to the left side of another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerLine {
    /// The vertex, and the height below its top.
    pub(super) from: (usize, i64),
    pub(super) to: (usize, i64),
    /// Lines of one bundle begin at one point, and share their way.
    pub(super) bundle: ((usize, usize), usize),
}

/// A part of a line between two neighboring layers, or at one side of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Segment {
    /// The number of the gap: gap 0 is left of layer 0.
    pub(super) gap: usize,
    /// The number of its bundle.
    pub(super) bundle: usize,
    /// The vertices, and the heights below their tops.
    pub(super) ends: [SegmentEnd; 2],
}

/// An end of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct SegmentEnd {
    pub(super) vertex: usize,
    /// The height below the top of the vertex.
    pub(super) y: i64,
    /// Whether it is at the left side of the gap, so at the right side of its vertex.
    pub(super) is_left: bool,
}

/// Vertices in layers, with the bends of lines that pass layers.
#[derive(Debug)]
pub(super) struct Layered {
    pub(super) vertices: Vec<Vertex>,
    /// Per layer its vertices, from above.
    pub(super) layers: Vec<Vec<usize>>,
    /// Per vertex its layer.
    pub(super) layer: Vec<usize>,
    /// Per bundle its style.
    pub(super) styles: Vec<usize>,
    /// All segments, each once, by gap.
    pub(super) segments: Vec<Vec<Segment>>,
    /// Per line its segments, in their order.
    pub(super) lines: Vec<Vec<Segment>>,
}

impl Layered {
    /// Puts vertices into layers, and lines through them.
    pub(super) fn new(vertices: Vec<Vertex>, lines: &[LayerLine], returns: Returns) -> Self {
        let (layer, count) = assign(&vertices, lines, returns);
        let mut layers = vec![Vec::new(); count];
        for (vertex, layer) in layer.iter().enumerate() {
            layers[*layer].push(vertex);
        }
        let gaps = vec![Vec::new(); count + 1];
        let mut layered = Self { vertices, layers, layer, styles: Vec::new(), segments: gaps, lines: Vec::new() };
        let mut bundles = Bundles::default();
        let all: Vec<Vec<Segment>> = lines.iter().map(|line| bundles.segments(line, &mut layered)).collect();
        let each: BTreeSet<Segment> = all.iter().flatten().copied().collect();
        for segment in each {
            layered.segments[segment.gap].push(segment);
        }
        layered.lines = all;
        layered
    }

    fn bend(&mut self, layer: usize) -> usize {
        let vertex = self.vertices.len();
        self.vertices.push(Vertex { width: 0, height: 0, role: VertexRole::Bend, keeps_order: false });
        self.layer.push(layer);
        self.layers[layer].push(vertex);
        vertex
    }
}

/// The bundles, with the bends that their lines share.
#[derive(Default)]
struct Bundles {
    numbers: BTreeMap<((usize, usize), usize), usize>,
    /// By bundle, layer, and whether the line goes back.
    bends: BTreeMap<(usize, usize, bool), usize>,
}

impl Bundles {
    /// Returns the segments of a line, whose bends are added to their layers.
    fn segments(&mut self, line: &LayerLine, layered: &mut Layered) -> Vec<Segment> {
        let styles = &mut layered.styles;
        let bundle = *self.numbers.entry(line.bundle).or_insert_with(|| {
            styles.push(line.bundle.1);
            styles.len() - 1
        });
        let (first, last) = (layered.layer[line.from.0], layered.layer[line.to.0]);
        let goes_back = last <= first;
        let passed: Vec<usize> = if goes_back { (last..=first).rev().collect() } else { (first + 1..last).collect() };
        let mut segments = Vec::new();
        let mut at = SegmentEnd { vertex: line.from.0, y: line.from.1, is_left: true };
        let mut gap = first + 1;
        for layer in passed {
            let key = (bundle, layer, goes_back);
            let vertex = *self.bends.entry(key).or_insert_with(|| layered.bend(layer));
            // A line that goes back reaches each layer from the right.
            segments.push(Segment { gap, bundle, ends: [at, SegmentEnd { vertex, y: 0, is_left: goes_back }] });
            at = SegmentEnd { vertex, y: 0, is_left: !goes_back };
            gap = if goes_back { layer } else { layer + 1 };
        }
        segments.push(Segment {
            gap,
            bundle,
            ends: [at, SegmentEnd { vertex: line.to.0, y: line.to.1, is_left: false }],
        });
        segments
    }
}

/// The lines of a cycle that go back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Returns {
    /// As few as possible.
    Fewest,
    /// Those into all delays of the cycle, so that its other parts lie one below the other.
    IntoDelays,
}

/// Returns the layer of each vertex, and the number of layers.
fn assign(vertices: &[Vertex], lines: &[LayerLine], returns: Returns) -> (Vec<usize>, usize) {
    let rank = match returns {
        Returns::Fewest => ranks(vertices, lines),
        Returns::IntoDelays => ranks(vertices, &without_returns(vertices, lines)),
    };
    // A line against the ranks goes back: its end may be in the layer of its beginning, but in no later one.
    let edges: Vec<Bound> = lines
        .iter()
        .map(|line| (line.from.0, line.to.0))
        .filter(|(from, to)| from != to)
        .map(|(from, to)| {
            if rank[from] < rank[to] {
                Bound { low: from, high: to, least: 1 }
            } else {
                Bound { low: to, high: from, least: 0 }
            }
        })
        .collect();
    let is_free = |vertex: usize| matches!(vertices[vertex].role, VertexRole::Free | VertexRole::Delay);
    let mut free: Vec<usize> = (0..vertices.len()).filter(|vertex| is_free(*vertex)).collect();
    free.sort_by_key(|vertex| rank[*vertex]);
    let inner: Vec<Bound> = edges.iter().copied().filter(|it| is_free(it.low) && is_free(it.high)).collect();
    let (mut before, mut after) = (vec![Vec::new(); vertices.len()], vec![Vec::new(); vertices.len()]);
    for bound in &inner {
        before[bound.high].push((bound.low, bound.least));
        after[bound.low].push((bound.high, bound.least));
    }
    let mut layer = vec![0; vertices.len()];
    for vertex in &free {
        layer[*vertex] = before[*vertex].iter().map(|(other, least)| layer[*other] + least).max().unwrap_or_default();
    }
    shorten(&free, &before, &after, &mut layer);
    let count = free.iter().map(|vertex| layer[*vertex] + 1).max().unwrap_or_default();
    let shift = usize::from(vertices.iter().any(|vertex| vertex.role == VertexRole::First));
    let has_last = vertices.iter().any(|vertex| vertex.role == VertexRole::Last);
    for (vertex, layer) in layer.iter_mut().enumerate() {
        match vertices[vertex].role {
            VertexRole::First => *layer = 0,
            VertexRole::Last => *layer = shift + count,
            VertexRole::Free | VertexRole::Delay | VertexRole::Bend => *layer += shift,
        }
    }
    (layer, (shift + count + usize::from(has_last)).max(1))
}

/// Returns the lines except for those into delays that lead back to where they begin.
fn without_returns(vertices: &[Vertex], lines: &[LayerLine]) -> Vec<LayerLine> {
    let mut after = vec![Vec::new(); vertices.len()];
    for line in lines {
        after[line.from.0].push(line.to.0);
    }
    let reached_from = |delay: usize| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![delay]);
        while let Some(vertex) = open.pop() {
            open.extend(after[vertex].iter().copied().filter(|next| reached.insert(*next)));
        }
        reached
    };
    let delays = (0..vertices.len()).filter(|vertex| vertices[*vertex].role == VertexRole::Delay);
    let reached: BTreeMap<usize, BTreeSet<usize>> = delays.map(|delay| (delay, reached_from(delay))).collect();
    let returns = |line: &&LayerLine| reached.get(&line.to.0).is_some_and(|reached| reached.contains(&line.from.0));
    lines.iter().filter(|line| !returns(line)).copied().collect()
}

/// A least distance of two layers.
#[derive(Clone, Copy)]
struct Bound {
    low: usize,
    high: usize,
    least: usize,
}

/// The number of times that vertices are moved towards their neighbors.
const SHORTENINGS: usize = 8;

/// Moves vertices towards the side on which they have more lines, as far as these lines let them.
fn shorten(free: &[usize], before: &[Vec<(usize, usize)>], after: &[Vec<(usize, usize)>], layer: &mut [usize]) {
    for _ in 0..SHORTENINGS {
        let mut has_moved = false;
        for vertex in free.iter().rev().copied() {
            let room = after[vertex].iter().map(|(other, least)| layer[*other] - least).min();
            let Some(room) = room.filter(|room| *room > layer[vertex]) else { continue };
            if after[vertex].len() > before[vertex].len() {
                layer[vertex] = room;
                has_moved = true;
            }
        }
        if !has_moved {
            break;
        }
    }
}

/// Returns an order of the vertices in which few lines go back: the heuristic of Eades, Lin and Smyth. Vertices without
/// lines into them come first, those without lines out of them last, and of the others the one with the most lines more
/// out of it than into it.
fn ranks(vertices: &[Vertex], lines: &[LayerLine]) -> Vec<usize> {
    let count = vertices.len();
    let (mut into, mut out) = (vec![BTreeMap::new(); count], vec![BTreeMap::new(); count]);
    for line in lines {
        let (from, to) = (line.from.0, line.to.0);
        if from != to {
            *out[from].entry(to).or_insert(0_i64) += 1;
            *into[to].entry(from).or_insert(0_i64) += 1;
        }
    }
    let sum = |edges: &BTreeMap<usize, i64>| edges.values().sum::<i64>();
    let mut degrees: Vec<(i64, i64)> = into.iter().zip(&out).map(|(into, out)| (sum(into), sum(out))).collect();
    let mut left: BTreeSet<usize> = (0..count).collect();
    let (mut front, mut back) = (Vec::new(), Vec::new());
    while !left.is_empty() {
        let sink = left.iter().rev().copied().find(|vertex| degrees[*vertex].1 == 0 && degrees[*vertex].0 > 0);
        let source = left.iter().copied().find(|vertex| degrees[*vertex].0 == 0);
        let next = sink.or(source).or_else(|| {
            left.iter()
                .copied()
                .max_by_key(|vertex| (degrees[*vertex].1 - degrees[*vertex].0, std::cmp::Reverse(*vertex)))
        });
        let Some(next) = next else { break };
        let end = if sink.is_some() { &mut back } else { &mut front };
        end.push(next);
        left.remove(&next);
        for (other, weight) in &out[next] {
            degrees[*other].0 -= weight;
        }
        for (other, weight) in &into[next] {
            degrees[*other].1 -= weight;
        }
    }
    let mut rank = vec![0; count];
    for (position, vertex) in front.into_iter().chain(back.into_iter().rev()).enumerate() {
        rank[vertex] = position;
    }
    rank
}
