// SPDX-License-Identifier: Apache-2.0
//! One direction of a connection: bytes that arrive late and in pieces, and end in order or not.

use std::collections::VecDeque;

/// One direction of a connection.
#[derive(Debug, Default)]
pub(crate) struct Pipe {
    bytes: VecDeque<u8>,
    /// The pieces: the time of arrival and the length of each.
    pieces: VecDeque<(u64, usize)>,
    /// The arrival of the last piece that was ever written.
    latest: u64,
    /// The arrival of the writer's end.
    pub(crate) end: Option<u64>,
    /// The arrival of the news that the connection is broken; unread bytes are lost then.
    pub(crate) reset: Option<u64>,
    /// Whether the reader is gone.
    pub(crate) deserted: bool,
}

impl Pipe {
    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }

    pub(crate) fn is_reset(&self, now: u64) -> bool {
        self.reset.is_some_and(|at| at <= now)
    }

    pub(crate) fn has_ended(&self, now: u64) -> bool {
        self.bytes.is_empty() && self.end.is_some_and(|at| at <= now)
    }

    /// Returns the number of bytes that have arrived.
    pub(crate) fn available(&self, now: u64) -> usize {
        self.pieces.iter().take_while(|(at, _)| *at <= now).map(|(_, len)| len).sum()
    }

    /// Returns this time, or the arrival of the last piece if that is later.
    pub(crate) fn after_all(&self, at: u64) -> u64 {
        at.max(self.latest)
    }

    pub(crate) fn push(&mut self, at: u64, bytes: &[u8]) {
        self.latest = at;
        self.bytes.extend(bytes);
        self.pieces.push_back((at, bytes.len()));
    }

    /// Takes the first bytes, as many as `target` holds; the caller has checked that they are there.
    pub(crate) fn take(&mut self, target: &mut [u8]) {
        let mut left = target.len();
        let (front, back) = self.bytes.as_slices();
        let first = front.len().min(left);
        target[..first].copy_from_slice(&front[..first]);
        target[first..].copy_from_slice(&back[..left - first]);
        self.bytes.drain(..left);
        while left > 0 {
            let Some((_, len)) = self.pieces.front_mut() else { return };
            let taken = left.min(*len);
            *len -= taken;
            left -= taken;
            if *len == 0 {
                self.pieces.pop_front();
            }
        }
    }

    /// Returns the time of the next event for the reader: a piece, the end, or the news of a broken connection.
    pub(crate) fn next_time(&self) -> Option<u64> {
        let piece = self.pieces.front().map(|(at, _)| *at);
        let end = self.end.filter(|_| self.bytes.is_empty());
        [piece, end, self.reset].into_iter().flatten().min()
    }
}
