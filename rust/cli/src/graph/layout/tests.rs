// SPDX-License-Identifier: Apache-2.0
//! Properties of all layouts.

use proptest::collection::vec;
use proptest::prelude::*;

use super::{Block, Figure, Pin, Placed, Rectangle, Side, Wire, lay_out};

/// Returns figures of blocks in blocks, with wires in each container.
fn figures() -> impl Strategy<Value = Figure> {
    let block =
        (any::<prop::sample::Index>(), 0..120_i64, 0..60_i64, vec((any::<bool>(), 0..60_i64), 0..5), any::<bool>());
    let wire = (any::<prop::sample::Index>(), any::<[prop::sample::Index; 2]>(), 0..3_usize);
    (vec(block, 1..14), vec(wire, 0..40)).prop_map(|(blocks, wires)| {
        let mut figure = Figure::default();
        for (index, (parent, width, height, pins, is_delay)) in blocks.into_iter().enumerate() {
            let side = |is_left| if is_left { Side::Left } else { Side::Right };
            let pins = pins.into_iter().map(|(is_left, width)| Pin { side: side(is_left), width }).collect();
            let parent = (index > 0).then(|| parent.index(index));
            figure.blocks.push(Block {
                parent,
                least: (width, height),
                header: height / 2,
                is_delay,
                keeps_order: index % 2 == 0,
                pins,
            });
        }
        for (container, ends, style) in wires {
            let container = container.index(figure.blocks.len());
            let [from, to] = [Side::Right, Side::Left].map(|outer| ends_in(&figure, container, outer));
            if !from.is_empty() && !to.is_empty() {
                let (from, to) = (from[ends[0].index(from.len())], to[ends[1].index(to.len())]);
                figure.wires.push(Wire { container, from, to, style });
            }
        }
        figure
    })
}

/// Returns the pins in a container where wires begin or end: at this side of its contents, and at its own other side.
fn ends_in(figure: &Figure, container: usize, outer: Side) -> Vec<(usize, usize)> {
    let mut ends = Vec::new();
    for (index, block) in figure.blocks.iter().enumerate() {
        for (pin, declared) in block.pins.iter().enumerate() {
            let is_end = if index == container { declared.side != outer } else { declared.side == outer };
            if is_end && (index == container || block.parent == Some(container)) {
                ends.push((index, pin));
            }
        }
    }
    ends
}

fn contains(outer: Rectangle, inner: Rectangle) -> bool {
    outer.x <= inner.x
        && outer.y <= inner.y
        && inner.x + inner.width <= outer.x + outer.width
        && inner.y + inner.height <= outer.y + outer.height
}

/// Returns whether the insides of two rectangles, or of a line and a rectangle, have a point in common.
fn overlap(one: Rectangle, other: Rectangle) -> bool {
    one.x < other.x + other.width
        && other.x < one.x + one.width
        && one.y < other.y + other.height
        && other.y < one.y + one.height
}

/// Returns the parts of a wire.
fn parts(placed: &Placed, wire: usize) -> impl Iterator<Item = [(i64, i64); 2]> {
    placed.wires[wire].windows(2).map(|ends| [ends[0].min(ends[1]), ends[0].max(ends[1])])
}

proptest! {
    #[test]
    fn blocks_are_in_their_containers_and_beside_each_other(figure in figures()) {
        let placed = lay_out(&figure);
        for (index, block) in figure.blocks.iter().enumerate() {
            if let Some(parent) = block.parent {
                prop_assert!(contains(placed.blocks[parent], placed.blocks[index]), "{index}: {placed:?}");
            }
            for other in 0..index {
                let are_siblings = figure.blocks[other].parent == block.parent;
                prop_assert!(!are_siblings || !overlap(placed.blocks[index], placed.blocks[other]), "{index}, {other}");
            }
        }
    }

    #[test]
    fn pins_are_at_their_sides(figure in figures()) {
        let placed = lay_out(&figure);
        for (index, block) in figure.blocks.iter().enumerate() {
            let Rectangle { x, y, width, height } = placed.blocks[index];
            for (pin, point) in block.pins.iter().zip(&placed.pins[index]) {
                prop_assert_eq!(point.0, if pin.side == Side::Left { x } else { x + width });
                prop_assert!((y..=y + height).contains(&point.1));
            }
        }
    }

    #[test]
    fn wires_go_from_pin_to_pin_in_right_angles_and_through_no_block(figure in figures()) {
        let placed = lay_out(&figure);
        for (index, wire) in figure.wires.iter().enumerate() {
            let points = &placed.wires[index];
            // Inside a container, a wire reaches the name of the container's pin.
            let end = |(block, pin): (usize, usize)| {
                let (x, y) = placed.pins[block][pin];
                let Pin { side, width } = figure.blocks[block].pins[pin];
                let inner = if side == Side::Left { width } else { -width };
                (if block == wire.container { x + inner } else { x }, y)
            };
            prop_assert_eq!(points.first(), Some(&end(wire.from)));
            prop_assert_eq!(points.last(), Some(&end(wire.to)));
            for [low, high] in parts(&placed, index) {
                prop_assert!(low.0 == high.0 || low.1 == high.1);
                let part = Rectangle { x: low.0, y: low.1, width: high.0 - low.0, height: high.1 - low.1 };
                prop_assert!(contains(placed.blocks[wire.container], part));
                for (other, block) in figure.blocks.iter().enumerate() {
                    let is_sibling = block.parent == Some(wire.container);
                    prop_assert!(!is_sibling || !overlap(part, placed.blocks[other]), "{wire:?} through {other}");
                }
            }
        }
    }

    /// Wires that neither begin nor end together have vertical parts beside each other.
    #[test]
    fn vertical_parts_of_different_wires_are_apart(figure in figures()) {
        let placed = lay_out(&figure);
        let bundle = |wire: &Wire| (wire.from, wire.style);
        let targets = |wire: &Wire| -> Vec<(usize, usize)> {
            figure.wires.iter().filter(|other| bundle(other) == bundle(wire)).map(|other| other.to).collect()
        };
        for (index, wire) in figure.wires.iter().enumerate() {
            for (other_index, other) in figure.wires.iter().enumerate().take(index) {
                let may_share = bundle(wire) == bundle(other)
                    || wire.container != other.container
                    || targets(wire).iter().any(|target| targets(other).contains(target));
                if may_share {
                    continue;
                }
                for [low, high] in parts(&placed, index).filter(|[low, high]| low.0 == high.0) {
                    let mut others = parts(&placed, other_index).filter(|[low, high]| low.0 == high.0);
                    let on_it = others.find(|[from, to]| from.0 == low.0 && from.1 < high.1 && low.1 < to.1);
                    prop_assert_eq!(on_it, None, "{:?} and {:?}", wire, other);
                }
            }
        }
    }

    #[test]
    fn equal_figures_have_equal_layouts(figure in figures()) {
        prop_assert_eq!(lay_out(&figure), lay_out(&figure.clone()));
    }
}

/// A block in a block in a block, and so on, needs no stack.
#[test]
fn blocks_can_be_nested_deeply_and_beside_each_other_in_great_number() {
    let chain = |index: usize| Block { parent: index.checked_sub(1), ..Block::default() };
    let nested = Figure { blocks: (0..10_000).map(chain).collect(), wires: Vec::new() };
    assert_eq!(lay_out(&nested).blocks.len(), 10_000);
    let pins = [Side::Left, Side::Right].map(|side| Pin { side, width: 0 });
    let mut row = Figure { blocks: vec![Block::default()], wires: Vec::new() };
    for index in 1..500 {
        row.blocks.push(Block { parent: Some(0), least: (20, 20), pins: pins.to_vec(), ..Block::default() });
        if index > 1 {
            row.wires.push(Wire { container: 0, from: (index - 1, 1), to: (index, 0), style: 0 });
        }
    }
    let placed = lay_out(&row);
    assert!(placed.wires.iter().all(|points| points.len() == 2), "a chain is straight");
}
