// SPDX-License-Identifier: Apache-2.0
//! The distances in pictures, in pixels.

/// The least vertical distance of a block from another one.
pub(super) const BLOCK_GAP: i64 = 18;
/// The least distance of a wire from a block, and from another wire.
pub(super) const WIRE_GAP: i64 = 10;
/// The height of a row with a pin.
pub(crate) const PIN_ROW: i64 = 20;
/// The least distance of two layers.
pub(super) const LAYER_GAP: i64 = 28;
/// The distance of the contents of a container from its border.
pub(super) const PADDING: i64 = 14;

/// Returns a count as a number of pixels.
pub(super) fn int(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
