// SPDX-License-Identifier: Apache-2.0
//! The messages that wait at the front of a receive buffer.

use lf_model::InputId;
use lf_model::time::Tag;

/// The messages at the front of the input buffer that have been examined, and wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// The number of their bytes.
    pub(super) bytes: usize,
    /// The earliest of their tags; FOREVER if nothing is held.
    pub(super) earliest: Tag,
    /// The input of the first of them.
    pub(super) input: Option<InputId>,
    /// Whether some of them are for something else.
    mixed: bool,
    /// Whether some of them may have room now, and have to be examined though nothing has come.
    pub(super) stale: bool,
    /// Whether a grant behind them reaches their earliest tag.
    pub(super) granted: bool,
}

impl Held {
    /// No message is held.
    pub(super) const NONE: Self =
        Self { bytes: 0, earliest: Tag::FOREVER, input: None, mixed: false, stale: false, granted: false };

    /// Handles that a tag has begun, which removes its events from their queues: there is room for others.
    ///
    /// All held messages are then examined from the front. As room comes about in no other way, a message never
    /// overtakes an earlier one for the same input.
    pub(super) fn recheck(&mut self) {
        self.stale = self.input.is_some();
    }

    /// Releases held messages, if they may have room now. Returns how many bytes at the front are all messages for one
    /// input, so that none of them has room if the first has not: a long queue of them need not be examined after each
    /// tag.
    pub(super) fn release(&mut self) -> usize {
        if !self.stale {
            return 0;
        }
        let alike = if self.mixed { 0 } else { self.bytes };
        *self = Self::NONE;
        alike
    }

    /// Holds a message where it is.
    pub(super) fn hold(&mut self, bytes: usize, tag: Tag, input: Option<InputId>) {
        self.mixed |= self.bytes > 0 && self.input != input;
        self.bytes += bytes;
        self.earliest = self.earliest.min(tag);
        self.input = self.input.or(input);
    }

    /// Holds a grant where it is. It reaches the earliest tag.
    pub(super) fn hold_grant(&mut self, bytes: usize) {
        self.hold(bytes, Tag::FOREVER, None);
        self.granted = true;
    }
}
