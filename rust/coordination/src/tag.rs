// SPDX-License-Identifier: Apache-2.0
//! Conversions between tags of the model and tags on the wire. Neither crate knows the other, and both use the same
//! numbers.

use lf_model::time::{Instant, Microstep, Tag};

/// Converts a tag on the wire to one of the model.
pub const fn from_wire(tag: lf_wire::Tag) -> Tag {
    Tag { time: Instant::from_nanos(tag.time), microstep: Microstep(tag.microstep) }
}

/// Converts a tag of the model to one on the wire.
pub const fn to_wire(tag: Tag) -> lf_wire::Tag {
    lf_wire::Tag { time: tag.time.as_nanos(), microstep: tag.microstep.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_time_are_the_same_on_both_sides() {
        assert_eq!(from_wire(lf_wire::Tag::NEVER), Tag::NEVER);
        assert_eq!(from_wire(lf_wire::Tag::FOREVER), Tag::FOREVER);
        assert_eq!(to_wire(Tag::FOREVER), lf_wire::Tag::FOREVER);
        assert_eq!(to_wire(Tag::NEVER), lf_wire::Tag::NEVER);
    }
}
