// SPDX-License-Identifier: Apache-2.0
//! What is known of the messages that wait at the front of a receive buffer.

use lf_model::InputId;
use lf_model::time::Tag;

/// The messages at the front of the input buffer that have been looked at, and wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// How many bytes they have.
    pub(super) bytes: usize,
    /// The earliest of their tags; FOREVER if nothing is held.
    pub(super) earliest: Tag,
    /// The input for which the first of them is.
    pub(super) input: Option<InputId>,
    /// Some of them are for something else.
    mixed: bool,
    /// Some of them may have room now: they are to be looked at though nothing has come.
    pub(super) stale: bool,
    /// A grant behind them reaches their earliest tag.
    pub(super) granted: bool,
}

impl Held {
    /// Nothing is held.
    pub(super) const NONE: Self =
        Self { bytes: 0, earliest: Tag::FOREVER, input: None, mixed: false, stale: false, granted: false };

    /// A tag has been begun, which takes its events out of their queues: there is room for others.
    ///
    /// All that is held is then looked at from the front. As room comes about in no other way, a message never
    /// overtakes an earlier one for the same input.
    pub(super) fn recheck(&mut self) {
        self.stale = self.input.is_some();
    }

    /// Lets go what is held, if it may have room now. How many bytes at the front all are messages for one input, so
    /// that none of them has room when the first has not: a long queue of them need not be looked at after each tag.
    pub(super) fn release(&mut self) -> usize {
        if !self.stale {
            return 0;
        }
        let alike = if self.mixed { 0 } else { self.bytes };
        *self = Self::NONE;
        alike
    }

    /// The message stays where it is.
    pub(super) fn hold(&mut self, bytes: usize, tag: Tag, input: Option<InputId>) {
        self.mixed |= self.bytes > 0 && self.input != input;
        self.bytes += bytes;
        self.earliest = self.earliest.min(tag);
        self.input = self.input.or(input);
    }

    /// A grant stays where it is, which reaches the earliest tag.
    pub(super) fn hold_grant(&mut self, bytes: usize) {
        self.hold(bytes, Tag::FOREVER, None);
        self.granted = true;
    }
}
